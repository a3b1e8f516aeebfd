#pragma once
/// A scene held open: light, eye and instances change, and radiance follows.
///
/// For programs that show a scene while it is worked on. One thread drives a session; the work inside uses
/// all of oneTBB's threads. There is no global state: sessions do not know of each other.
///
/// If the settings have bounces, frames have them, too: those of a light that changes in every frame, by the
/// rays that were shot before; of an eye that moves the diffuse ones, without what highlights show of them;
/// and an instance that moves takes its own along, while those of all others stay. A commit has them in full.
///
/// Every call that may last takes a Progress. When it is interrupted, or fails, the session is as it was
/// before the call.

#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "shading/bake/bounced_radiance.h"
#include "shading/scene/turned_light.h"
#include "shading/transfer/lamp_frames.h"
#include "shading/transfer/light_transfer.h"
#include "shading/transfer/motion_transfer.h"
#include "shading/transfer/view_transfer.h"
#include "shading/visibility/kept_visibility.h"

namespace haarfield {

/// A scene held open; see the top of this file.
class RelightSession {
public:
    /// What the scene's pointers refer to must outlive the session.
    ///
    /// settings  as for scene_radiance.
    RelightSession(ShadedScene scene, const RenderSettings& settings, const TransferSettings& transfer = {});

    const std::vector<ShadedInstance>& instances() const { return scene_.instances; }  ///< As they stand now.
    const std::vector<Lamp>& lamps() const { return scene_.lamps; }                    ///< As they are now.
    const Vec3f& eye() const { return scene_.eye; }  ///< Where the highlights are seen from now.

    /// As the renderers take it: what commit() has baked, if nothing was changed since.
    const ShadedScene& scene() const { return scene_; }

    /// Prepares what the calls below share: how the objects block light, and the environment's coefficients.
    /// A call that finds it missing, after a change, does so first.
    ///
    /// cost    see shading_geometry and lighting_tree: some 0.4 s for 15 million nodes of fields.
    /// errors  interrupted.
    Result<Done> prepare(const Progress& progress = {});

    /// @name What varies
    /// Makes the transfer vectors with which frames follow one kind of change; about a second per 200,000
    /// vertices. They hold until anything else changes.
    /// @{

    /// The vectors are pruned for lights like that which is shown now: one with more detail is reproduced
    /// less exactly. Show a mixture of those that are to come, before.
    Result<Done> vary_light(const Progress& progress = {});
    Result<Done> vary_eye(const Progress& progress = {});  ///< The eye.
    /// The lamps; all else is shaded once, in full.
    Result<Done> vary_lamps(const Progress& progress = {});
    /// The instance's translation and scale.
    Result<Done> vary_instance(std::size_t instance, const Progress& progress = {});
    /// @}

    /// @name Changes
    /// Those that the transfer vectors were not made for make them void.
    /// @{

    /// Exchanges the environment; clean.
    ///
    /// cost    encoding in the next call that needs it, some 0.1 s for 1024 x 512 pixels.
    void set_environment(Environment environment);
    /// Exchanges the light for one that is encoded already, with the lights of its sources, until the
    /// environment is set or turned: for mixing and dimming many times a second. commit() bakes the
    /// environment, not this.
    void show_light(DenseCoefficients light, std::vector<DirectionalLight> lights = {});
    /// Turns the environment as it was set.
    void turn_environment(const Rotation& rotation);
    /// Exchanges the lamps: dims, colours, moves, switches them. Whatever varies, frames follow, at the cost
    /// of LampFrames: of those that have changed more than their colour.
    ///
    /// lamps  what they look like are instances of this scene.
    void set_lamps(std::vector<Lamp> lamps);
    void set_eye(const Vec3f& eye);  ///< Moves the eye.
    /// Moves an instance, and scales it.
    void place(std::size_t instance, const Placement& placement);

    /// Exchanges the materials of an entity, as many as it has. What vertices see stays known.
    void set_materials(std::size_t entity, std::vector<Material> materials);

    /// One more instance of an entity of the scene; its index, the last.
    std::size_t add(const ShadedInstance& instance);
    /// A copy in the same place; its index, the last.
    std::size_t clone(std::size_t instance);
    /// Later instances move up by one.
    void remove(std::size_t instance);
    /// Turns an instance about an axis through the origin of its entity, after the turns that it has. What is
    /// turned back, to 1e-9, is not turned at all.
    void rotate(std::size_t instance, const Vec3d& axis, double angle);
    /// @}

    /// Radiance as it is now, by the transfer vectors.
    ///
    /// errors  interrupted; nothing varies.
    Result<Done> frame(FrameQuality quality = FrameQuality::still, const Progress& progress = {});

    /// The same for some vertices only, such as those that the camera sees: with the bits of a whole frame.
    /// The radiance of others is of no use, unless they were chosen since the last change.
    ///
    /// cost    while the eye varies, that of the chosen ones; otherwise that of all.
    Result<Done> frame_of(VertexMask vertices, FrameQuality quality = FrameQuality::still,
                          const Progress& progress = {});

    /// Radiance as it is now, in full: what scene_radiance makes of the scene. What the vertices see is kept
    /// (RenderSettings::kept_bytes) until an instance changes, or, with Occlusion::automatic, the environment
    /// is set, so that the next commit is faster.
    ///
    /// errors  interrupted.
    Result<Done> commit(const Progress& progress = {});

    /// Takes over what bounces from another session, that has committed the same scene, light and instances
    /// in the same order, but for where the one stood that vary_instance is called for next: that need not
    /// find it then. The other may see more exactly.
    void rest_as(const RelightSession& other) {
        if (other.resting_) resting_ = other.resting_;
    }

    /// Of the last frame or commit. An instance's values stay in one place in memory until instances are
    /// cloned or removed, or the radiance is taken.
    const SceneRadiance& radiance() const { return radiance_; }

    /// Gives the values away, in the memory that they are in; there are none until the next frame or commit.
    SceneRadiance take_radiance() { return std::exchange(radiance_, {}); }

    /// Memory of the transfer vectors. [bytes]
    std::size_t transfer_bytes() const;

private:
    Result<const ShadingGeometry*> current_geometry(const Progress& progress);
    Result<const RgbCubemapTree*> light_tree(const Progress& progress);
    Result<const DenseCoefficients*> light(const Progress& progress);
    const SplitLight& split();
    /// The environment as it is turned.
    Environment shown_environment(const std::stop_token& stop) const;
    std::vector<LightSource> turned_sources();
    std::vector<DirectionalLight> source_lights(FrameQuality quality);
    Result<const BounceRays*> current_rays(const Progress& progress);
    /// Diffuse radiance by the bounces of what shines on rows, as materials will reflect it.
    Result<SceneRadiance> bounced_radiance(const LightTransport& transport, std::vector<Rgb> diffuse,
                                           const BounceSettings& bounces, const Progress& progress) const;
    Result<IndirectLight> indirect_at_rest(const SceneRadiance& diffuse, const SceneLight& light,
                                           const Progress& progress);
    Result<Done> update_lamps(const Progress& progress);
    BounceSettings frame_bounces() const;
    /// Irradiance by row of all bounces of the scratch's direct light, as frames by light have it.
    ///
    /// moving  one bounce more than the last frame had, of the light that is now: later ones lag behind. On
    ///         every other row, in turn, where the light changes little; all of them where it has leapt.
    Result<Done> find_irradiance(FrameQuality quality, const Progress& progress);
    /// What the diffuse terms make of an irradiance by row.
    SceneRadiance radiance_by(std::span<const Rgb> irradiance) const;
    void add_to_radiance(const SceneRadiance& part, const VertexMask* vertices);
    void light_changes();
    void keep(SceneRadiance radiance);
    void instances_change();
    Result<SceneRadiance> full_radiance(const SceneLight& light, const Progress& progress);
    Result<Done> shaded_without_lamps(FrameQuality quality, const VertexMask* vertices,
                                      const Progress& progress);
    Result<Done> transferred(FrameQuality quality, const VertexMask* vertices, const Progress& progress);

    RenderSettings settings_;
    TransferSettings transfer_settings_;
    ShadedScene scene_;
    std::optional<ShadingGeometry> geometry_;  ///< Of scene_'s entities, once needed.
    bool is_placed_ = false;                   ///< geometry_'s instances are where scene_'s are.
    std::optional<KeptVisibility> kept_;       ///< Of scene_'s instances, once needed.

    Environment environment_;                   ///< Not turned.
    std::optional<SplitLight> split_;           ///< Of it, once needed: its image is dropped.
    std::optional<double> unevenness_;          ///< Of what is smooth of it, once needed.
    std::optional<TurnableLight> turnable_;     ///< Of what is smooth of it, once needed.
    Rotation rotation_;                         ///< Of what scene_.environment and the light are now.
    std::optional<RgbCubemapTree> light_tree_;  ///< Of the environment as it is turned, once needed.
    std::optional<DenseCoefficients> light_;    ///< Of that, or what is shown instead,
    std::optional<std::vector<DirectionalLight>>
        shown_lights_;  ///< with its sources; none: the environment's.

    std::optional<BounceRays> rays_;         ///< Of scene_'s entities, once needed;
    bool are_rays_current_ = false;          ///< of its instances as they stand.
    std::optional<LightTransport> refined_;  ///< Of them, for the light that the vectors were made under.
    std::vector<Rgb> reflectances_;          ///< Of that scene: row_reflectances.
    struct LitRows {
        std::vector<Rgb> direct;    ///< Diffuse radiance by direct light. [W/(m^2 sr)]
        std::vector<Rgb> arriving;  ///< Irradiance by all bounces. [W/m^2]
        std::size_t frames = 0;     ///< How many there were.
    } last_;                        ///< Of the last frame by light, by row; or none.
    struct FrameRows {
        std::vector<Rgb> radiance, direct, sent, irradiance;
    } scratch_;  ///< Of a frame by light: memory that is at hand costs nothing.
    std::optional<SceneRadiance>
        resting_;  ///< Diffuse radiance by indirect light, but that of lamps and emitters, as all is now.
    SceneRadiance bounced_;        ///< What frames add: diffuse radiance by indirect light; or none.
    SceneRadiance lamps_bounced_;  ///< The same by what lamps and emitters shed,
    bool is_lamps_bounced_current_ = false;  ///< as they are now.

    /// Of a scene in which lamps alone vary: what all other light makes.
    struct SteadyLight {
        SceneRadiance radiance;
    };
    std::variant<std::monostate, LightTransfer, ViewTransfer, MotionTransfer, SteadyLight> transfer_;
    LampFrames lamp_frames_;  ///< Of the frames.
    SceneRadiance radiance_;
};

}  // namespace haarfield
