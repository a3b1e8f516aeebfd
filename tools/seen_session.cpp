#include "tools/seen_session.h"

namespace haarfield {
namespace {

ShadedScene without_parted_highlights(ShadedScene scene, const SceneEntities& entities) {
    const std::vector<std::vector<bool>> parted = parted_materials(entities);
    for (std::size_t e = 0; e < scene.entities.size(); ++e)
        for (std::size_t m = 0; m < parted[e].size(); ++m)
            if (parted[e][m]) scene.entities[e].materials[m].specular = Rgb(0.0f);
    return scene;
}

}  // namespace

SeenSession::SeenSession(ShadedScene scene, const SceneEntities& entities, const RenderSettings& settings,
                         const TransferSettings& transfer)
    : all_(scene, settings, transfer) {
    if (parts_highlights(entities))
        matte_.emplace(without_parted_highlights(std::move(scene), entities), settings, transfer);
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

Result<Done> SeenSession::vary_instance(std::size_t instance, const Progress& progress) {
    return both([&](RelightSession& session) { return session.vary_instance(instance, progress); });
}

void SeenSession::show_light(const DenseCoefficients& light, const std::vector<DirectionalLight>& lights) {
    all_.show_light(light, lights);
    if (matte_) matte_->show_light(light, lights);
}

void SeenSession::turn_environment(const Rotation& rotation) {
    all_.turn_environment(rotation);
    if (matte_) matte_->turn_environment(rotation);
}

void SeenSession::set_eye(const Vec3f& eye) {
    all_.set_eye(eye);
    if (matte_) matte_->set_eye(eye);
}

void SeenSession::place(std::size_t instance, const Placement& placement) {
    all_.place(instance, placement);
    if (matte_) matte_->place(instance, placement);
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

std::vector<Rgb> SeenSession::highlights(std::size_t instance) const {
    std::vector<Rgb> result;
    if (!matte_) return result;
    const std::vector<Rgb>&all = all_.radiance()[instance], &matte = matte_->radiance()[instance];
    result.reserve(all.size());
    for (std::size_t v = 0; v < all.size(); ++v) result.push_back(without_negative(all[v] - matte[v]));
    return result;
}

}  // namespace haarfield
