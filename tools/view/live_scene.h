#pragma once
/// The radiance of a design while it is edited: the one place of `view` that knows relighting sessions.

#include "bridge/pictures/preview.h"
#include "tools/seen_session.h"
#include "tools/view/design.h"
#include "tools/view/light_table.h"

#include <map>

namespace haarfield {

/// What frames follow without being shaded in full.
struct Variation {
    enum class Of { nothing, light, eye, object };
    Of of = Of::nothing;
    std::uint32_t object = 0;  ///< Whose translation and scale.

    bool operator==(const Variation&) const = default;
};

/// What a page shows at an object's vertices: half floats, three a vertex. [W/(m^2 sr)]
struct VertexColours {
    std::vector<std::uint16_t> under;  ///< To be multiplied with textures.
    std::vector<std::uint16_t> over;   ///< On top of them; empty if there is nothing.
};

/// A scene's meshes and fields, and a relighting session. Occlusion by other objects is interpolated from
/// fields for vectors, frames and quick shading. For what is displayed at rest, it is that of `bake`.
///
/// One thread drives it. A call that takes a Progress and is interrupted, or fails, may be repeated; the
/// colours are then those of before.
class LiveScene {
public:
    /// settings  of `bake`.
    LiveScene(const Scene& scene, SceneEntities entities, const RenderSettings& settings,
              const TransferSettings& transfer);

    const SceneEntities& entities() const { return *entities_; }

    /// Reads a design's light, which all calls below do that need it.
    ///
    /// errors  of its files.
    Result<Done> take_light(const Design& design);

    /// Of an entity the one of Scene::entities that it was prepared from.
    std::size_t described_by(std::size_t entity) const { return described_by_[entity]; }

    /// The variation that the vectors are for.
    const Variation& varied() const { return varied_; }

    /// True if frames can follow the variation in this design.
    bool follows(const Design& design, const Variation& variation) const;

    /// Makes the vectors of a variation, in all else for this design.
    Result<Done> vary(const Design& design, const Variation& variation, const Progress& progress);

    /// The colours by vectors that were made.
    ///
    /// accuracy  see RelightSession::frame; while the eye moves those that the camera may see, after the
    ///           first frame.
    /// errors    interrupted; nothing varies, or the design differs in more than what does.
    ///
    /// window  what the page shows: the eye's place is the design's.
    Result<Done> show(const Design& design, const Camera& window, FrameQuality quality,
                      const Progress& progress);

    /// The colours in full, as far as fields tell. About a second.
    Result<Done> shade(const Design& design, const Progress& progress);

    /// The colours that `bake` makes of the design's file.
    Result<Done> commit(const Design& design, const Progress& progress);

    /// True if a commit finds cached visibility: no object has moved since the last commit.
    bool commits_fast(const Design& design) const;

    /// True if lamps or surfaces emit light, which no exposure changes.
    bool has_own_light(const Design& design) const;

    /// True if expose() suffices: the session's radiance is that of the colours, and all of its light is that
    /// of the environment.
    bool can_expose(const Design& design) const {
        return session_ && shown_ids_ == ids_ && !has_own_light(design);
    }

    /// Changes the exposure of the colours.
    void expose(const Design& design);

    /// True if the colours lack indirect light in specular reflections, because the eye moves.
    bool lacks_reflections() const { return session_ && session_->lacks_reflections(); }

    /// The colours by id: those of the last of these calls, for the objects that it knew.
    const std::map<std::uint32_t, VertexColours>& colours() const { return colours_; }

    /// The exposure of a design, automatic or given, after take_light. [stops]
    float exposure(const Design& design) const;

    LightTable& lights() { return lights_; }

    /// The picture of a design whose colours are these, by the preview renderer.
    Image picture(const Design& design, Preview& preview);

    /// Memory of the vectors. [bytes]
    std::size_t transfer_bytes() const { return session_ ? session_->transfer_bytes() : 0; }

private:
    void take_materials(const Design& design);
    /// Sets the session's inputs to those of a design, and opens the session if there is none.
    ///
    /// varying  what stays as it is in the session: the light, or the place of an object.
    void bring(const Design& design, const Variation& varying);
    void bring_objects(const Design& design, const Variation& varying);
    /// Sets what is divided by the gain of the exposure, since the colours are multiplied by it.
    void bring_own_light(const Design& design);
    bool has_emitters() const;
    void show_light(const Design& design, FrameQuality quality);
    void take_colours(const Design& design, const VertexMask* chosen = nullptr);

    std::unique_ptr<SceneEntities> entities_;
    std::vector<std::size_t> described_by_;            ///< Entities of the scene, by entities_.
    std::vector<std::vector<Surface>> file_surfaces_;  ///< By entities_: as they were prepared.
    std::vector<std::vector<Emitter>> emitters_;       ///< By entities_.
    RenderSettings settings_;
    TransferSettings transfer_settings_;
    std::optional<SeenSession> session_;
    std::vector<std::uint32_t> ids_;        ///< By the session's instances.
    std::vector<std::uint32_t> shown_ids_;  ///< The same when the colours were computed.
    LightTable lights_;
    std::optional<std::uint64_t> material_stamp_;                 ///< Of entities_.
    std::optional<std::pair<std::uint64_t, float>> environment_;  ///< Stamp and share, of the session.

    Variation varied_;                 ///< What there are vectors for,
    std::optional<Design> varied_of_;  ///< and of what.
    bool is_whole_ = false;            ///< All colours are of these vectors.
    std::optional<Design> committed_;
    std::map<std::uint32_t, VertexColours> colours_;
};

}  // namespace haarfield
