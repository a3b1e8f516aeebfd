#pragma once
/// The radiance of a design while it is edited: the one place of `view` that knows relighting sessions.

#include "bridge/pictures/preview.h"
#include "scenes/scene_entities.h"
#include "shading/transfer/relight_session.h"
#include "tools/view/design.h"
#include "tools/view/light_table.h"

#include <map>

namespace haarfield {

/// A change that frames can follow without full shading.
struct Variation {
    enum class Of { nothing, light, eye, object };
    Of of = Of::nothing;
    std::uint32_t object = 0;  ///< The object whose translation and scale change.

    bool operator==(const Variation&) const = default;
};

/// The displayed radiance at an object's vertices: three half floats per vertex. [W/(m^2 sr)]
struct VertexColours {
    std::vector<std::uint16_t> textured;  ///< Multiplied by textures.
    std::vector<std::uint16_t> added;     ///< Added after textures; empty if there is none.
};

/// A scene's meshes and fields, and a relighting session. For vectors, frames and quick shading, occlusion by
/// other objects is interpolated from fields. For the display at rest, it is that of `bake`.
///
/// One thread drives it. If a call with a Progress fails or is interrupted, the colours remain unchanged, and
/// the call may be repeated.
class LiveScene {
public:
    /// settings  those of `bake`.
    LiveScene(const Scene& scene, SceneEntities entities, const RenderSettings& settings,
              const TransferSettings& transfer);

    const SceneEntities& entities() const { return *entities_; }

    /// Reads the light of a design. Must precede calls that use the design.
    ///
    /// errors  those of the light's files.
    Result<Done> take_light(const Design& design);

    /// Returns the index in Scene::entities from which an entity was prepared.
    std::size_t described_by(std::size_t entity) const { return described_by_[entity]; }

    /// The variation that the vectors are for.
    const Variation& varied() const { return varied_; }

    /// True if frames can follow the variation in this design.
    bool follows(const Design& design, const Variation& variation) const;

    /// Computes the transfer vectors of a variation of this design.
    Result<Done> vary(const Design& design, const Variation& variation, const Progress& progress);

    /// Computes the colours by the transfer vectors.
    ///
    /// window    the camera of the page; the eye's position is that of the design.
    /// accuracy  see RelightSession::frame. While the eye moves, frames after the first one update only
    ///           vertices that the camera may see.
    /// errors    interrupted. The transfer vectors must suit the design (asserted); see follows.
    Result<Done> show(const Design& design, const Camera& window, FrameQuality quality,
                      const Progress& progress);

    /// Shades in full, with occlusion by fields. cost: about a second.
    Result<Done> shade(const Design& design, const Progress& progress);

    /// Shades in full. The result is that of `bake` for the design's file.
    Result<Done> commit(const Design& design, const Progress& progress);

    /// Measures the error of the colours of the last commit, over the pixels of a camera.
    ///
    /// design  that of the last commit, apart from its camera and exposure.
    /// errors  interrupted.
    Result<BakeError> error(const Design& design, const Camera& window, Preview& preview,
                            const Progress& progress);

    /// True if a commit finds cached visibility: no object has moved since the last commit.
    bool commits_fast(const Design& design) const;

    /// True if lamps or surfaces emit light, which no exposure changes.
    bool has_own_light(const Design& design) const;

    /// True if a material is specular, so that the radiance depends on the eye.
    bool has_specular() const;

    /// True if expose() suffices: the session's radiance is that of the colours, and all of its light is that
    /// of the environment.
    bool can_expose(const Design& design) const {
        return session_ && shown_ids_ == ids_ && !has_own_light(design);
    }

    /// Changes the exposure of the colours.
    void expose(const Design& design);

    /// True if the colours lack indirect light in specular reflections, because the eye moves.
    bool lacks_reflections() const { return session_ && session_->lacks_reflections(); }

    /// Returns the colours of the last call, by the ids of the objects of its design.
    const std::map<std::uint32_t, VertexColours>& colours() const { return colours_; }

    /// Returns the exposure of a design, automatic or given. Requires take_light. [stops]
    float exposure(const Design& design) const;

    LightTable& lights() { return lights_; }

    /// Renders a picture of a design with the current colours by the preview renderer.
    Image picture(const Design& design, Preview& preview);

    /// Returns the memory of the transfer vectors. [bytes]
    std::size_t transfer_bytes() const { return session_ ? session_->transfer_bytes() : 0; }

private:
    void take_materials(const Design& design);
    /// Sets the session's inputs to those of a design, and opens the session if there is none.
    ///
    /// varying  what stays as it is in the session: the light, or the place of an object.
    void bring(const Design& design, const Variation& varying);
    void bring_objects(const Design& design, const Variation& varying);
    /// Sets lamps and emitters, divided by the gain of the exposure, by which colours are multiplied.
    void bring_own_light(const Design& design);
    bool has_emitters() const;
    void show_light(const Design& design, FrameQuality quality);
    void take_colours(const Design& design, const VertexMask* chosen = nullptr);

    std::unique_ptr<SceneEntities> entities_;
    std::vector<std::size_t> described_by_;            ///< Indices of the scene's entities, by entities_.
    std::vector<std::vector<Surface>> file_surfaces_;  ///< By entities_, as prepared.
    std::vector<std::vector<Emitter>> emitters_;       ///< By entities_.
    RenderSettings settings_;
    TransferSettings transfer_settings_;
    std::optional<RelightSession> session_;
    std::vector<std::uint32_t> ids_;        ///< By the session's instances.
    std::vector<std::uint32_t> shown_ids_;  ///< The same when the colours were computed.
    LightTable lights_;
    std::optional<std::uint64_t> material_stamp_;                 ///< Of entities_.
    std::optional<std::pair<std::uint64_t, float>> environment_;  ///< Stamp and share, of the session.

    Variation varied_;                 ///< For which transfer vectors exist,
    std::optional<Design> varied_of_;  ///< and of which design.
    bool is_whole_ = false;            ///< True if all colours come from these vectors.
    std::optional<Design> committed_;
    std::map<std::uint32_t, VertexColours> colours_;
};

}  // namespace haarfield
