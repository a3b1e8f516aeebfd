#include "tools/textured_session.h"

#include <algorithm>

namespace haarfield {
namespace {

bool has_layers(std::span<const std::vector<Surface>> surfaces) {
    return std::ranges::any_of(surfaces, [](const std::vector<Surface>& of_entity) {
        return std::ranges::any_of(of_entity, &Surface::has_separate_specular);
    });
}

/// Returns the materials of surfaces without the specular lobes that lie on top of textures.
std::vector<Material> matt_materials(std::span<const Surface> surfaces) {
    std::vector<Material> materials = materials_of(surfaces);
    for (std::size_t m = 0; m < materials.size(); ++m)
        if (surfaces[m].has_separate_specular()) materials[m].specular = Rgb(0.0f);
    return materials;
}

}  // namespace

std::vector<std::vector<Surface>> surfaces_of(const SceneEntities& entities) {
    std::vector<std::vector<Surface>> surfaces;
    for (const auto& entity : entities.entities) surfaces.push_back(entity->surfaces);
    return surfaces;
}

TexturedSession::TexturedSession(ShadedScene scene, std::span<const std::vector<Surface>> surfaces,
                                 const RenderSettings& settings, const TransferSettings& transfer)
    : all_(scene, settings, transfer) {
    if (!has_layers(surfaces)) return;
    for (std::size_t e = 0; e < surfaces.size(); ++e)
        scene.entities[e].materials = matt_materials(surfaces[e]);
    matte_.emplace(std::move(scene), settings, transfer);
}

bool TexturedSession::set_materials(std::span<const std::vector<Surface>> surfaces) {
    if (has_layers(surfaces) != matte_.has_value()) return false;
    for (std::size_t e = 0; e < surfaces.size(); ++e) {
        all_.set_materials(e, materials_of(surfaces[e]));
        if (matte_) matte_->set_materials(e, matt_materials(surfaces[e]));
    }
    return true;
}

template <class Act>
Result<Done> TexturedSession::both(const Act& act) {
    const Result<Done> done = act(all_);
    return done && matte_ ? act(*matte_) : done;
}

Result<Done> TexturedSession::prepare(const Progress& progress) {
    return both([&](RelightSession& session) { return session.prepare(progress); });
}

Result<Done> TexturedSession::vary_light(const Progress& progress) {
    return both([&](RelightSession& session) { return session.vary_light(progress); });
}

Result<Done> TexturedSession::vary_eye(const Progress& progress) {
    return both([&](RelightSession& session) { return session.vary_eye(progress); });
}

Result<Done> TexturedSession::vary_lamps(const Progress& progress) {
    return both([&](RelightSession& session) { return session.vary_lamps(progress); });
}

Result<Done> TexturedSession::vary_instance(std::size_t instance, const Progress& progress) {
    return both([&](RelightSession& session) { return session.vary_instance(instance, progress); });
}

void TexturedSession::show_light(const DenseCoefficients& light,
                                 const std::vector<DirectionalLight>& lights) {
    all_.show_light(light, lights);
    if (matte_) matte_->show_light(light, lights);
}

void TexturedSession::set_environment(const Environment& environment) {
    all_.set_environment(environment);
    if (matte_) matte_->set_environment(environment);
}

void TexturedSession::turn_environment(const Rotation& rotation) {
    all_.turn_environment(rotation);
    if (matte_) matte_->turn_environment(rotation);
}

void TexturedSession::set_lamps(const std::vector<Lamp>& lamps) {
    all_.set_lamps(lamps);
    if (matte_) matte_->set_lamps(lamps);
}

void TexturedSession::set_eye(const Vec3f& eye) {
    all_.set_eye(eye);
    if (matte_) matte_->set_eye(eye);
}

void TexturedSession::set_emitters(std::size_t entity, const std::vector<Emitter>& emitters) {
    all_.set_emitters(entity, emitters);
    if (matte_) matte_->set_emitters(entity, emitters);
}

void TexturedSession::set_occlusion(Occlusion occlusion) {
    all_.set_occlusion(occlusion);
    if (matte_) matte_->set_occlusion(occlusion);
}

void TexturedSession::rotate(std::size_t instance, const Vec3d& axis, double angle) {
    all_.rotate(instance, axis, angle);
    if (matte_) matte_->rotate(instance, axis, angle);
}

std::size_t TexturedSession::clone(std::size_t instance) {
    if (matte_) matte_->clone(instance);
    return all_.clone(instance);
}

SceneColours TexturedSession::take_radiance() {
    if (matte_) matte_->take_radiance();
    return all_.take_radiance();
}

void TexturedSession::place(std::size_t instance, const Placement& placement) {
    all_.place(instance, placement);
    if (matte_) matte_->place(instance, placement);
}

std::size_t TexturedSession::add(const ShadedInstance& instance) {
    if (matte_) matte_->add(instance);
    return all_.add(instance);
}

void TexturedSession::remove(std::size_t instance) {
    all_.remove(instance);
    if (matte_) matte_->remove(instance);
}

Result<Done> TexturedSession::frame(FrameQuality quality, const Progress& progress) {
    return both([&](RelightSession& session) { return session.frame(quality, progress); });
}

Result<Done> TexturedSession::frame_of(const VertexMask& vertices, FrameQuality quality,
                                       const Progress& progress) {
    return both([&](RelightSession& session) { return session.frame_of(vertices, quality, progress); });
}

Result<Done> TexturedSession::commit(const Progress& progress) {
    return both([&](RelightSession& session) { return session.commit(progress); });
}

std::size_t TexturedSession::transfer_bytes() const {
    return all_.transfer_bytes() + (matte_ ? matte_->transfer_bytes() : 0);
}

std::vector<Outgoing> TexturedSession::outgoing(std::size_t instance) const {
    std::vector<Outgoing> result;
    const std::vector<Rgb>& all = all_.radiance()[instance];
    for (std::size_t v = 0; v < all.size(); ++v) {
        const Rgb specular = matte_ ? without_negative(all[v] - matte_->radiance()[instance][v]) : Rgb(0.0f);
        result.push_back({all[v] - specular, specular});
    }
    return result;
}

}  // namespace haarfield
