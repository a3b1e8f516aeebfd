#include "tools/seen_session.h"

#include <cassert>

namespace haarfield {
namespace {

ShadedScene without_parted_highlights(ShadedScene scene, const SceneEntities& entities) {
    const std::vector<std::vector<bool>> parted = parted_materials(entities);
    for (std::size_t e = 0; e < scene.entities.size(); ++e)
        for (std::size_t m = 0; m < parted[e].size(); ++m)
            if (parted[e][m]) scene.entities[e].materials[m].specular = Rgb(0.0f);
    return scene;
}

std::vector<std::vector<Rgb>> emissions_of(const SceneEntities& entities) {
    std::vector<std::vector<Rgb>> emissions;
    for (const auto& entity : entities.entities) {
        std::vector<Rgb>& of = emissions.emplace_back();
        for (const Surface& surface : entity->surfaces) of.push_back(surface.emission);
    }
    return emissions;
}

ShadedScene with_materials(ShadedScene scene, const SceneEntities& entities) {
    for (std::size_t e = 0; e < scene.entities.size(); ++e)
        scene.entities[e].materials = entities.entities[e]->materials;
    return scene;
}

}  // namespace

SeenSession::SeenSession(ShadedScene scene, const SceneEntities& entities, const RenderSettings& settings,
                         const TransferSettings& transfer)
    : emissions_(emissions_of(entities)), all_(scene, settings, transfer) {
    if (parts_highlights(entities))
        matte_.emplace(without_parted_highlights(std::move(scene), entities), settings, transfer);
}

bool SeenSession::set_materials(const SceneEntities& entities) {
    if (parts_highlights(entities) != matte_.has_value() || emissions_of(entities) != emissions_)
        return false;
    const ShadedScene shown = with_materials(all_.scene(), entities);
    for (std::size_t e = 0; e < shown.entities.size(); ++e)
        all_.set_materials(e, shown.entities[e].materials);
    if (!matte_) return true;
    const ShadedScene matte = without_parted_highlights(shown, entities);
    for (std::size_t e = 0; e < matte.entities.size(); ++e)
        matte_->set_materials(e, matte.entities[e].materials);
    return true;
}

template <class Act>
Result<Done> SeenSession::both(const Act& act) {
    const Result<Done> done = act(all_);
    return done && matte_ ? act(*matte_) : done;
}

Result<Done> SeenSession::prepare(const Progress& progress) {
    return both([&](RelightSession& session) { return session.prepare(progress); });
}

Result<Done> SeenSession::vary_light(const Progress& progress) {
    return both([&](RelightSession& session) { return session.vary_light(progress); });
}

Result<Done> SeenSession::vary_eye(const Progress& progress) {
    return both([&](RelightSession& session) { return session.vary_eye(progress); });
}

Result<Done> SeenSession::vary_lamps(const Progress& progress) {
    return both([&](RelightSession& session) { return session.vary_lamps(progress); });
}

Result<Done> SeenSession::vary_instance(std::size_t instance, const Progress& progress) {
    return both([&](RelightSession& session) { return session.vary_instance(instance, progress); });
}

void SeenSession::rest_as(const SeenSession& other) {
    assert(matte_.has_value() == other.matte_.has_value());
    all_.rest_as(other.all_);
    if (matte_) matte_->rest_as(*other.matte_);
}

void SeenSession::show_light(const DenseCoefficients& light, const std::vector<DirectionalLight>& lights) {
    all_.show_light(light, lights);
    if (matte_) matte_->show_light(light, lights);
}

void SeenSession::set_environment(const Environment& environment) {
    all_.set_environment(environment);
    if (matte_) matte_->set_environment(environment);
}

void SeenSession::turn_environment(const Rotation& rotation) {
    all_.turn_environment(rotation);
    if (matte_) matte_->turn_environment(rotation);
}

void SeenSession::set_lamps(const std::vector<Lamp>& lamps) {
    all_.set_lamps(lamps);
    if (matte_) matte_->set_lamps(lamps);
}

void SeenSession::set_eye(const Vec3f& eye) {
    all_.set_eye(eye);
    if (matte_) matte_->set_eye(eye);
}

void SeenSession::place(std::size_t instance, const Placement& placement) {
    all_.place(instance, placement);
    if (matte_) matte_->place(instance, placement);
}

std::size_t SeenSession::add(const ShadedInstance& instance) {
    if (matte_) matte_->add(instance);
    return all_.add(instance);
}

void SeenSession::remove(std::size_t instance) {
    all_.remove(instance);
    if (matte_) matte_->remove(instance);
}

Result<Done> SeenSession::frame(FrameQuality quality, const Progress& progress) {
    return both([&](RelightSession& session) { return session.frame(quality, progress); });
}

Result<Done> SeenSession::frame_of(const VertexMask& vertices, FrameQuality quality,
                                   const Progress& progress) {
    return both([&](RelightSession& session) { return session.frame_of(vertices, quality, progress); });
}

Result<Done> SeenSession::commit(const Progress& progress) {
    return both([&](RelightSession& session) { return session.commit(progress); });
}

std::size_t SeenSession::transfer_bytes() const {
    return all_.transfer_bytes() + (matte_ ? matte_->transfer_bytes() : 0);
}

std::vector<Outgoing> SeenSession::outgoing(std::size_t instance) const {
    std::vector<Outgoing> result;
    const std::vector<Rgb>& all = all_.radiance()[instance];
    for (std::size_t v = 0; v < all.size(); ++v) {
        const Rgb specular = matte_ ? without_negative(all[v] - matte_->radiance()[instance][v]) : Rgb(0.0f);
        result.push_back({all[v] - specular, specular});
    }
    return result;
}

}  // namespace haarfield
