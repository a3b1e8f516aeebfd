#pragma once
/// A relighting session whose highlights are known apart, where textures want that.

#include "scenes/scene_entities.h"
#include "shading/transfer/relight_session.h"

namespace haarfield {

/// RelightSession, and a second one without the highlights that lie over textures: see Surface. The second
/// one is there only if the scene has such surfaces; then all takes twice as long.
class SeenSession {
public:
    SeenSession(ShadedScene scene, const SceneEntities& entities, const RenderSettings& settings,
                const TransferSettings& transfer);

    /// @name As in RelightSession. @{
    Result<Done> prepare(const Progress& progress);
    Result<Done> vary_light(const Progress& progress);
    Result<Done> vary_eye(const Progress& progress);
    Result<Done> vary_lamps(const Progress& progress);
    Result<Done> vary_instance(std::size_t instance, const Progress& progress);
    void show_light(const DenseCoefficients& light, const std::vector<DirectionalLight>& lights);
    void set_environment(const Environment& environment);
    void turn_environment(const Rotation& rotation);
    void set_lamps(const std::vector<Lamp>& lamps);
    void set_eye(const Vec3f& eye);
    void place(std::size_t instance, const Placement& placement);
    std::size_t add(const ShadedInstance& instance);
    void remove(std::size_t instance);
    Result<Done> frame(FrameQuality quality, const Progress& progress);
    Result<Done> frame_of(const VertexMask& vertices, FrameQuality quality, const Progress& progress);
    Result<Done> commit(const Progress& progress);
    const SceneColours& radiance() const { return all_.radiance(); }
    const Vec3f& eye() const { return all_.eye(); }
    const std::vector<ShadedInstance>& instances() const { return all_.instances(); }
    std::size_t transfer_bytes() const;
    bool lacks_reflections() const { return all_.lacks_reflections(); }
    /// @}

    /// Takes over the entities' materials. False if the session is of no use any more: surfaces part their
    /// highlights now, or do no longer, or glow differently.
    bool set_materials(const SceneEntities& entities);

    /// See RelightSession. Of a session that parts highlights as this one does.
    void rest_as(const SeenSession& other);

    /// Returns the radiance of an instance. The specular component is zero where no texture needs it.
    std::vector<Outgoing> outgoing(std::size_t instance) const;

private:
    /// Does the same with both sessions.
    template <class Act>
    Result<Done> both(const Act& act);

    std::vector<std::vector<Rgb>> emissions_;  ///< Of each entity's surfaces, when the scene was made.
    RelightSession all_;
    std::optional<RelightSession> matte_;
};

}  // namespace haarfield
