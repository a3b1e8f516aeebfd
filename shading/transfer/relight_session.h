#pragma once
/// An open scene whose radiance follows changes of light, eye and instances.
///
/// For programs that display a scene while it is edited. One thread drives a session; the work inside uses
/// all of oneTBB's threads. There is no global state: sessions do not know of each other.
///
/// If the settings have bounces, frames include indirect light. While the light or lamps change, each frame
/// computes it with rays that were traced before. While the eye moves, frames of FrameQuality::moving lack
/// indirect light in specular reflections: see lacks_reflections(). While an instance moves, indirect light
/// stays as it was at rest, at all vertices. A commit computes it in full.
///
/// Vertices inside other instances get the mean of their neighbours, in frames as in bakes: see PlacedFill.
///
/// Long-running calls accept a Progress. If a call is interrupted or fails, the session is unchanged.

#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "shading/bake/bounced_radiance.h"
#include "shading/bake/error_target.h"
#include "shading/scene/turned_light.h"
#include "shading/transfer/lamp_frames.h"
#include "shading/transfer/light_transfer.h"
#include "shading/transfer/motion_transfer.h"
#include "shading/transfer/session_inputs.h"
#include "shading/transfer/specular_hits.h"
#include "shading/transfer/view_transfer.h"
#include "shading/visibility/cached_visibility.h"
#include "shading/visibility/placed_solids.h"

namespace haarfield {

/// An open scene; see the top of this file.
class RelightSession {
public:
    /// Opens a scene, whose pointers must outlive the session.
    ///
    /// settings  as for scene_radiance.
    RelightSession(ShadedScene scene, const RenderSettings& settings, const TransferSettings& transfer = {});

    const std::vector<ShadedInstance>& instances() const { return scene().instances; }  ///< As they are now.
    const std::vector<Lamp>& lamps() const { return scene().lamps; }                    ///< As they are now.
    const Vec3f& eye() const { return scene().eye; }  ///< The eye as it is now.

    /// The scene for the renderers: the one that commit() has baked, if nothing has changed since.
    const ShadedScene& scene() const { return inputs_.scene; }

    /// Prepares data shared by the calls below: the scene's occluders and the environment's coefficients.
    /// Calls that need the data after a change prepare it, too.
    ///
    /// cost    see shading_geometry and lighting_tree: about 0.4 s for 15 million nodes of fields.
    /// errors  interrupted.
    Result<Done> prepare(const Progress& progress = {});

    /// @name Variable inputs
    /// Each function computes the transfer vectors for frames in which one input varies, in about a second
    /// per 200,000 vertices. The vectors are valid until any other input changes.
    /// @{

    /// Prepares for variable light. The vectors are pruned for lights similar to the present one; a light
    /// with more detail is reproduced less exactly. For several lights, show a mixture of them before the
    /// call.
    Result<Done> vary_light(const Progress& progress = {});
    Result<Done> vary_eye(const Progress& progress = {});  ///< Prepares for a moving eye.
    /// Prepares for variable lamps. All other light is shaded once, in full.
    Result<Done> vary_lamps(const Progress& progress = {});
    /// Prepares for variable translation and scale of an instance.
    Result<Done> vary_instance(std::size_t instance, const Progress& progress = {});
    /// @}

    /// @name Changes
    /// A change invalidates transfer vectors that were not made for it. Setting an input to the value that it
    /// has is no change, except for the environment and show_light.
    /// @{

    /// Replaces the environment, which must be clean, and ends its rotation.
    ///
    /// cost    encoding in the next call that needs it, about 0.1 s for 1024 x 512 pixels.
    void set_environment(Environment environment);
    /// Replaces the environment in frames by a light in coefficients, until the environment is set or
    /// rotated. This is for mixing and dimming many times per second. commit() bakes the environment, not
    /// this light.
    void show_light(DenseCoefficients light, std::vector<DirectionalLight> lights = {});
    /// Rotates the environment, relative to the one that was set.
    void turn_environment(const Rotation& rotation);
    /// Replaces the lamps: dims, colours, moves or switches them. Frames include the new lamps, whichever
    /// kind of change the vectors are for. The cost is that of LampFrames.
    ///
    /// lamps  their shapes are instances of this scene.
    void set_lamps(std::vector<Lamp> lamps);
    void set_eye(const Vec3f& eye);  ///< Moves the eye.
    /// Sets the placement of an instance.
    void place(std::size_t instance, const Placement& placement);
    /// Replaces the materials of an entity, one by one. The visibility at vertices remains cached.
    void set_materials(std::size_t entity, std::vector<Material> materials);
    /// Replaces the emitters of an entity.
    void set_emitters(std::size_t entity, std::vector<Emitter> emitters);
    /// Chooses how the calls that follow compute occlusion by other objects. Existing vectors remain valid.
    /// Visibility is cached only for the occlusion that the session was opened with.
    void set_occlusion(Occlusion occlusion);
    /// Chooses whether the calls that follow separate the components of radiance for outgoing(), as textures
    /// need it. Frames and vectors for a moving instance then take twice as long; vectors made without this
    /// are invalid.
    void separate_components(bool separates);

    /// Adds an instance of an entity of the scene. Returns its index, the last.
    std::size_t add(const ShadedInstance& instance);
    /// Adds a copy in the same place. Returns its index, the last.
    std::size_t clone(std::size_t instance);
    /// Removes an instance. The indices of later instances decrease by one.
    void remove(std::size_t instance);
    /// Rotates an instance about an axis through the origin of its entity, after the rotation that it has. A
    /// result within 1e-9 of the identity becomes the identity.
    void rotate(std::size_t instance, const Vec3d& axis, double angle);
    /// @}

    /// True if frame() is possible: the transfer vectors are valid for the current scene.
    bool has_vectors() const;

    /// Computes the radiance of the current scene with the transfer vectors.
    ///
    /// errors  interrupted; there are no valid vectors.
    Result<Done> frame(FrameQuality quality = FrameQuality::still, const Progress& progress = {});

    /// Computes the radiance of some vertices only, such as those in view. It is bit-identical to that of a
    /// whole frame. The radiance of other vertices is outdated, unless they were chosen since the last
    /// change.
    ///
    /// cost    while the eye varies, that of the chosen vertices; otherwise that of all.
    Result<Done> frame_of(VertexMask vertices, FrameQuality quality = FrameQuality::still,
                          const Progress& progress = {});

    /// Computes the radiance of the current scene in full, as scene_radiance does. The visibility at vertices
    /// is cached (RenderSettings::kept_bytes), so that the next commit is faster. The cache is valid until an
    /// instance changes or, with Occlusion::automatic, the environment is set.
    ///
    /// errors  interrupted.
    Result<Done> commit(const Progress& progress = {});

    /// Measures the error of radiance at the vertices, such as that of the last frame, for the environment
    /// and the scene as they are now; see vertex_bake_error.
    ///
    /// shown   by instance and vertex.
    /// cost    that of vertex_bake_error, and that of a commit if there are bounces.
    /// errors  interrupted.
    Result<BakeError> error(const SceneRadiance& shown, std::vector<DisplayedPoint> population,
                            double accuracy, const Progress& progress = {});

    /// True if the last frame lacks indirect light in specular reflections, because the eye has moved.
    bool lacks_reflections() const { return lacks_reflections_; }

    /// Returns the radiance of the last frame or commit. The memory of an instance's values does not move
    /// until instances are cloned or removed, or take_radiance() is called.
    const SceneColours& radiance() const { return radiance_; }

    /// Returns the components of the radiance of an instance. The specular one is zero unless components were
    /// separated by the last frame or commit.
    std::vector<Outgoing> outgoing(std::size_t instance) const;

    /// Moves the radiance out of the session without copying it. The next frame or commit allocates memory.
    SceneColours take_radiance() {
        diffuse_.clear();
        return std::exchange(radiance_, {});
    }

    /// Returns the memory of the transfer vectors. [bytes]
    std::size_t transfer_bytes() const;

private:
    using I = SessionInput;

    /// Indirect light of a frame.
    struct Bounced {
        SceneColours reflected;    ///< Diffuse radiance by indirect light; empty: none.
        std::vector<Rgb> diffuse;  ///< By row: diffuse radiance by all light, tinted; empty: none.
    };
    /// The state of frames in which the light varies.
    struct LightFrames {
        LightTransfer transfer;
        std::optional<LightTransport>
            transport;                  ///< Refined for the light of the vectors; if there are bounces.
        CoarseTransport coarse;         ///< That of `transport`.
        std::vector<Rgb> reflectances;  ///< row_reflectances.
        /// Results of the last frame, by row.
        struct LastFrame {
            std::vector<Rgb> direct;     ///< Diffuse radiance by direct light. [W/(m^2 sr)]
            std::vector<Rgb> arriving;   ///< Irradiance by all bounces. [W/m^2]
            std::vector<Rgb> reflected;  ///< Specular radiance by indirect light. [W/(m^2 sr)]
            std::size_t frames = 0;      ///< Number of frames so far.
        };
        LastFrame last;
        /// Buffers, reused by all frames.
        std::vector<Rgb> radiance, diffuse, direct, sent, irradiance;

        std::size_t bytes() const { return transfer.bytes() + coarse.bytes(); }
    };
    /// The state of frames in which the eye moves.
    struct EyeFrames {
        ViewTransfer transfer;
        Bounced indirect;

        std::size_t bytes() const { return transfer.bytes(); }
    };
    /// The scene without specular terms, and its state of frames in which an instance moves.
    struct MattMotion {
        ShadedScene scene;  ///< Without environment.
        MotionTransfer transfer;
    };
    /// The state of frames in which an instance moves.
    struct MotionFrames {
        MotionTransfer transfer;
        std::vector<ShadedInstance> instances;  ///< The instances for which the vectors were computed.
        SceneRadiance indirect;                 ///< Radiance by indirect light before motion; empty: none.
        std::optional<MattMotion> matt;         ///< To separate the components.

        std::size_t bytes() const { return transfer.bytes() + (matt ? matt->transfer.bytes() : 0); }
    };
    /// The state of frames in which the lamps vary: the radiance by all other light.
    struct OtherLight {
        SceneColours radiance, diffuse;

        std::size_t bytes() const { return 0; }
    };

    /// Frees data that is invalid for the current inputs.
    void drop_outdated();
    void adapt_geometry();
    Result<const ShadingGeometry*> current_geometry(const Progress& progress);
    Result<const RgbCubemapTree*> light_tree(const Progress& progress);
    Result<const DenseCoefficients*> light(const Progress& progress);
    const SplitLight& split();
    double light_unevenness();
    Environment rotated_environment(const std::stop_token& stop) const;
    std::vector<LightSource> turned_sources();
    std::vector<DirectionalLight> source_lights(FrameQuality quality);
    Result<const BounceRays*> current_rays(const Progress& progress);
    Result<const SpecularHits*> current_hits(const Progress& progress);
    /// Returns the cached visibility; null if none is cached for the occlusion.
    Result<const CachedVisibility*> cached_visibility(const Progress& progress);
    const PlacedFill& placed_fill();
    LampFrames& lamp_frames();
    BounceSettings frame_bounces() const;

    /// Computes the indirect light of diffuse radiance by row, which is not tinted.
    Result<Bounced> bounced(const LightTransport& transport, std::vector<Rgb> diffuse,
                            const BounceSettings& bounces, const Progress& progress) const;
    Result<IndirectLight> indirect_at_rest(const SceneRadiance& direct, const SceneLight& light,
                                           const Progress& progress);
    /// Returns the radiance by indirect light, diffuse and specular.
    Result<SceneRadiance> radiance_at_rest(const IndirectLight& indirect, const SceneLight& light,
                                           const Progress& progress) const;
    /// Computes radiance by a light, as commit() does.
    Result<SceneRadiance> full_radiance(const SceneLight& light, const Progress& progress);
    /// Computes the irradiance by row of all bounces of the direct light in `frames`.
    ///
    /// quality  moving: one bounce more than the last frame had, of the present light; later bounces lag
    ///          behind. If the light changes little, every other row is computed, in turn; if it leaps, all
    ///          bounces.
    Result<Done> find_irradiance(LightFrames& frames, FrameQuality quality, const Progress& progress);
    /// Returns the diffuse radiance by an irradiance by row.
    SceneColours radiance_by(std::span<const Rgb> irradiance) const;
    /// Adds radiance to that of the frame. If the components are separated, its diffuse part is also added to
    /// the diffuse component.
    ///
    /// vertices  null: all.
    /// @{
    void add_diffuse(const SceneColours& part, const VertexMask* vertices);
    void add_specular(const SceneColours& part, const VertexMask* vertices);
    void add_radiance(const SceneRadiance& part);
    /// @}
    /// Computes the light of the lamps and emitters as they are now, and their indirect light.
    Result<Done> update_lamps(const Progress& progress);
    Result<Done> transferred(FrameQuality quality, const VertexMask* vertices, const Progress& progress);
    Result<Done> shade(LightFrames& frames, FrameQuality quality, const VertexMask* vertices,
                       const Progress& progress);
    Result<Done> shade(EyeFrames& frames, FrameQuality quality, const VertexMask* vertices,
                       const Progress& progress);
    Result<Done> shade(MotionFrames& frames, FrameQuality quality, const VertexMask* vertices,
                       const Progress& progress);
    Result<Done> shade(OtherLight& frames, FrameQuality quality, const VertexMask* vertices,
                       const Progress& progress);
    /// Computes the specular reflections of diffuse radiance by row.
    ///
    /// vertices  null: all.
    Result<SceneColours> reflections(std::span<const Rgb> diffuse, const VertexMask* vertices,
                                     const Progress& progress);
    /// Adds the specular reflections that frames by a moving eye lack otherwise.
    Result<Done> add_reflections(const EyeFrames& frames, FrameQuality quality, const VertexMask* vertices,
                                 const Progress& progress);

    const TransferSettings transfer_settings_;
    const Occlusion cached_occlusion_;  ///< Of the settings.
    SessionInputs inputs_;

    std::optional<ShadingGeometry> geometry_;  ///< Of the entities, once needed;
    Memo<Done, I::instances> placed_;          ///< of the instances.
    Memo<SplitLight, I::environment> split_;   ///< Its image is dropped.
    Memo<double, I::environment> unevenness_;  ///< Of the smooth light.
    Memo<TurnableLight, I::environment> turnable_;
    Memo<RgbCubemapTree, I::environment, I::rotation> light_tree_;
    Memo<DenseCoefficients, I::environment, I::rotation> light_;
    Memo<CachedVisibility, I::instances, I::exact_distances> cached_visibility_;
    Memo<BounceRays, I::instances> rays_;
    Memo<PlacedFill, I::instances> placed_fill_;
    Memo<SpecularHits, I::instances, I::materials, I::eye> hits_;
    /// Radiance by indirect light, without that of lamps and emitters.
    Memo<SceneRadiance, I::environment, I::rotation, I::instances, I::materials, I::eye> resting_;
    Memo<LampFrames, I::instances, I::materials, I::emitters> lamp_frames_;
    Memo<Bounced, I::instances, I::materials, I::emitters, I::lamps> lamps_bounced_;
    /// Specular radiance by lamps_bounced_.
    Memo<SceneColours, I::instances, I::materials, I::emitters, I::lamps, I::eye> lamps_reflected_;

    using ByLight = Memo<LightFrames, I::instances, I::materials, I::eye>;
    using ByEye = Memo<EyeFrames, I::environment, I::rotation, I::shown_light, I::instances, I::materials>;
    using ByMotion = Memo<MotionFrames, I::environment, I::rotation, I::shown_light, I::materials, I::eye>;
    using ByLamps =
        Memo<OtherLight, I::environment, I::rotation, I::shown_light, I::instances, I::materials, I::eye>;
    std::variant<std::monostate, ByLight, ByEye, ByMotion, ByLamps> transfer_;
    bool separates_components_ = false;
    bool lacks_reflections_ = false;
    SceneColours radiance_;
    SceneColours diffuse_;  ///< Its diffuse component; empty unless the components are separated.
};

}  // namespace haarfield
