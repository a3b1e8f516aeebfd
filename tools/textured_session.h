#pragma once
/// A relighting session that separates specular radiance from the light that textures multiply.

#include "scenes/scene_entities.h"
#include "shading/transfer/relight_session.h"

namespace haarfield {

/// The surfaces of each entity of a scene.
std::vector<std::vector<Surface>> surfaces_of(const SceneEntities& entities);

/// Two relighting sessions: one with all materials, and one without the specular lobes of textured surfaces
/// (Surface::has_separate_specular). The specular radiance is their difference. The second session exists
/// only if the scene has such surfaces, and doubles the time of all calls.
class TexturedSession {
public:
    /// surfaces  by entity and material.
    TexturedSession(ShadedScene scene, std::span<const std::vector<Surface>> surfaces,
                    const RenderSettings& settings, const TransferSettings& transfer = {});

    /// @name As in RelightSession.
    /// @{
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
    void set_emitters(std::size_t entity, const std::vector<Emitter>& emitters);
    void set_occlusion(Occlusion occlusion);
    void place(std::size_t instance, const Placement& placement);
    void rotate(std::size_t instance, const Vec3d& axis, double angle);
    std::size_t add(const ShadedInstance& instance);
    std::size_t clone(std::size_t instance);
    void remove(std::size_t instance);
    Result<Done> frame(FrameQuality quality = FrameQuality::still, const Progress& progress = {});
    Result<Done> frame_of(const VertexMask& vertices, FrameQuality quality, const Progress& progress);
    Result<Done> commit(const Progress& progress);
    const SceneColours& radiance() const { return all_.radiance(); }
    SceneColours take_radiance();
    const ShadedScene& scene() const { return all_.scene(); }
    const Vec3f& eye() const { return all_.eye(); }
    const std::vector<ShadedInstance>& instances() const { return all_.instances(); }
    std::size_t transfer_bytes() const;
    bool has_vectors() const { return all_.has_vectors(); }
    bool lacks_reflections() const { return all_.lacks_reflections(); }
    /// @}

    /// Replaces the materials of all entities. Returns false and does nothing if the new materials need the
    /// second session and it does not exist, or the reverse.
    bool set_materials(std::span<const std::vector<Surface>> surfaces);

    /// Returns the radiance of an instance. The specular component is zero where no texture needs it.
    std::vector<Outgoing> outgoing(std::size_t instance) const;

private:
    /// Calls `act` with both sessions.
    template <class Act>
    Result<Done> both(const Act& act);

    RelightSession all_;
    std::optional<RelightSession> matte_;
};

}  // namespace haarfield
