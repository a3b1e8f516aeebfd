#pragma once
/// The radiance of a design while hands change it: the one place of `view` that knows relighting sessions.

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

/// A scene's meshes and fields, and two sessions over them: one that looks past other objects by their
/// fields, for quick vectors and frames, and one that sees what `bake` sees, for what is shown at rest.
///
/// One thread drives it. What takes a Progress and is interrupted, or fails, may be asked for again; the
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

    /// What there are vectors for.
    const Variation& varied() const { return varied_; }

    /// Whether frames can follow the variation in this design.
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

    /// Whether a commit need not look from the vertices again: no object has moved since the last.
    bool commits_fast(const Design& design) const;

    /// Whether lamps or surfaces shed light of their own, which no exposure changes.
    bool has_own_light(const Design& design) const;

    /// Whether expose() is enough: the colours' session is as it was, and the design has no light of its own.
    bool can_expose(const Design& design) const {
        return last_ != nullptr && !last_->is_touched && !has_own_light(design);
    }

    /// The colours of before under another exposure.
    void expose(const Design& design);

    /// By id. Of the last of these calls, and of objects that it knew.
    const std::map<std::uint32_t, VertexColours>& colours() const { return colours_; }

    /// The exposure that a design has, found or given. Its light has been taken. [stops]
    float exposure(const Design& design) const;

    /// True if the colours lack indirect light in specular reflections, because the eye moves.
    bool lacks_reflections() const { return last_ && last_->session && last_->session->lacks_reflections(); }

    LightTable& lights() { return lights_; }

    /// The picture of a design whose colours are these, by the preview renderer.
    Image picture(const Design& design, Preview& preview);

    /// Memory of the vectors. [bytes]
    std::size_t transfer_bytes() const { return quick_.session ? quick_.session->transfer_bytes() : 0; }

private:
    /// A session, and what it was told of last.
    struct Stage {
        std::optional<SeenSession> session;
        RenderSettings settings;
        std::vector<std::uint32_t> ids;  ///< By its instances.
        std::uint64_t light_stamp = 0, material_stamp = 0;
        float share = 0;
        float gain = 1;  ///< By which colours will be multiplied: its lamps and emitters are divided by it.
        Rotation turn;
        bool has_mixture = false;  ///< SeenSession::show_light came last.
        bool is_touched = false;   ///< Its session has changed since colours were taken of it.
    };

    void take_materials(const Design& design);
    void bring(Stage& stage, const Design& design, bool with_light);
    void bring_objects(Stage& stage, const Design& design);
    void open(Stage& stage, const Design& design);
    bool has_emitters() const;
    std::vector<Lamp> lamps_for(const Stage& stage, const Design& design) const;
    void show_light(const Design& design, FrameQuality quality);
    void take_colours(Stage& stage, const Design& design, const VertexMask* chosen = nullptr);

    std::unique_ptr<SceneEntities> entities_;
    std::vector<std::size_t> described_by_;            ///< Entities of the scene, by entities_.
    std::vector<std::vector<Surface>> file_surfaces_;  ///< By entities_: as they were prepared.
    TransferSettings transfer_settings_;
    Stage quick_, exact_;
    Stage* last_ = nullptr;  ///< Where the colours are from.
    LightTable lights_;
    std::uint64_t material_stamp_ = 0;

    Variation varied_;                 ///< What there are vectors for,
    std::optional<Design> varied_of_;  ///< and of what.
    bool is_whole_ = false;            ///< All colours are of these vectors.
    std::optional<Design> committed_;
    std::map<std::uint32_t, VertexColours> colours_;
};

}  // namespace haarfield
