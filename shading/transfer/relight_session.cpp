#include "shading/transfer/relight_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "fields/field/field_precompute.h"
#include "shading/bake/renderer.h"
#include "shading/scene/lighting.h"

namespace haarfield {
namespace {

constexpr int lights_while_moving = 4;  ///< A source.

}  // namespace

RelightSession::RelightSession(SessionScene scene, const RenderSettings& settings,
                               const TransferSettings& transfer)
    : settings_(settings),
      transfer_settings_(transfer),
      entities_(std::move(scene.entities)),
      instances_(std::move(scene.instances)),
      poses_(std::move(scene.poses)),
      owned_(poses_.size()),
      environment_(std::move(scene.environment)) {
    for (const SessionPose& pose : poses_)
        scene_.entities.push_back({pose.mesh, pose.occlusion, pose.field, entities_[pose.entity].materials});
    for (const SessionInstance& instance : instances_) {
        const std::optional<std::size_t> pose = pose_of(instance);
        assert(pose);
        scene_.instances.push_back({*pose, instance.placement});
    }
    scene_.environment = environment_;
    scene_.eye = scene.eye;
}

std::optional<std::size_t> RelightSession::pose_of(const SessionInstance& instance) const {
    for (std::size_t p = 0; p < poses_.size(); ++p)
        if (poses_[p].entity == instance.entity && poses_[p].rotate == instance.rotate) return p;
    return std::nullopt;
}

Result<const DenseCoefficients*> RelightSession::light(const Progress& progress) {
    if (!light_) {
        const Result<const RgbCubemapTree*> tree = light_tree(progress);
        if (!tree) return tree.error();
        light_ = dense_coefficients(**tree, settings_.face_size);
    }
    return &*light_;
}

Result<const RgbCubemapTree*> RelightSession::light_tree(const Progress& progress) {
    if (!light_tree_) {
        if (!turnable_) {
            TurnableLight made = turnable_light(split().smooth, settings_.face_size, progress.stop);
            if (progress.stop.stop_requested()) return Error{"", interrupted};
            turnable_ = std::move(made);
        }
        light_tree_ = haar_cubemap<Rgb>(turned_lighting_texels(*turnable_, rotation_), settings_.face_size,
                                        Truncation{settings_.light_coefficients});
    }
    return &*light_tree_;
}

const SplitLight& RelightSession::split() {
    if (!split_) split_ = split_light(environment_, settings_.sources);
    return *split_;
}

std::vector<LightSource> RelightSession::turned_sources() {
    std::vector<LightSource> sources = split().sources;
    for (LightSource& source : sources)
        for (auto* lights : {&source.lights, &source.parts})
            for (DirectionalLight& light : *lights) light.direction = rotation_(light.direction);
    return sources;
}

std::vector<DirectionalLight> RelightSession::source_lights(FrameQuality quality) {
    if (shown_lights_) return *shown_lights_;
    if (quality == FrameQuality::still) return all_lights(turned_sources());
    std::vector<DirectionalLight> lights;
    for (const LightSource& source : split().sources)
        for (DirectionalLight light : few_lights(source.lights, lights_while_moving)) {
            light.direction = rotation_(light.direction);
            lights.push_back(light);
        }
    return lights;
}

Result<const ShadingGeometry*> RelightSession::current_geometry(const Progress& progress) {
    if (!geometry_) {
        Result<ShadingGeometry> made = shading_geometry(scene_, settings_, progress);
        if (!made) return made.error();
        geometry_ = std::move(*made);
    }
    geometry_->grid = influence_grid(scene_, geometry_->entities);
    geometry_->rays.place(scene_);
    return &*geometry_;
}

Result<Done> RelightSession::prepare(const Progress& progress) {
    const Result<const ShadingGeometry*> geometry = current_geometry(progress);
    if (!geometry) return geometry.error();
    const Result<const RgbCubemapTree*> light = light_tree(progress);
    if (!light) return light.error();
    return Done{};
}

Result<Done> RelightSession::vary_light(const Progress& progress) {
    const Result<const ShadingGeometry*> geometry = current_geometry(progress);
    if (!geometry) return geometry.error();
    const Result<const DenseCoefficients*> typical = light(progress);
    if (!typical) return typical.error();
    Result<LightTransfer> made =
        light_transfer(scene_, **geometry, settings_, transfer_settings_, **typical, progress);
    if (!made) return made.error();
    transfer_ = std::move(*made);
    return Done{};
}

Result<Done> RelightSession::vary_eye(const Progress& progress) {
    const Result<const ShadingGeometry*> geometry = current_geometry(progress);
    if (!geometry) return geometry.error();
    const Result<const RgbCubemapTree*> light = light_tree(progress);
    if (!light) return light.error();
    const std::vector<LightSource> sources = turned_sources();
    Result<ViewTransfer> made =
        view_transfer(scene_, **geometry, settings_, transfer_settings_, **light, sources, progress);
    if (!made) return made.error();
    transfer_ = std::move(*made);
    return Done{};
}

Result<Done> RelightSession::vary_instance(std::size_t instance, const Progress& progress) {
    assert(instance < instances_.size());
    const Result<const ShadingGeometry*> geometry = current_geometry(progress);
    if (!geometry) return geometry.error();
    const Result<const RgbCubemapTree*> light = light_tree(progress);
    if (!light) return light.error();
    Result<MotionTransfer> made =
        motion_transfer(scene_, **geometry, settings_, transfer_settings_, **light, instance, progress);
    if (!made) return made.error();
    transfer_ = std::move(*made);
    return Done{};
}

void RelightSession::light_changes() {
    shown_lights_.reset();
    light_tree_.reset();
    light_.reset();
    if (!std::holds_alternative<LightTransfer>(transfer_)) transfer_ = {};
}

void RelightSession::instances_change() {
    transfer_ = {};
    kept_.reset();
}

void RelightSession::set_environment(Environment environment) {
    environment_ = std::move(environment);
    split_.reset();
    turnable_.reset();
    rotation_ = {};
    light_changes();
}

void RelightSession::show_light(DenseCoefficients light, std::vector<DirectionalLight> lights) {
    assert(light.face_size == settings_.face_size);
    light_changes();
    light_ = std::move(light);
    shown_lights_ = std::move(lights);
}

void RelightSession::turn_environment(const Rotation& rotation) {
    rotation_ = rotation;
    light_changes();
}

void RelightSession::set_eye(const Vec3f& eye) {
    scene_.eye = eye;
    if (!std::holds_alternative<ViewTransfer>(transfer_)) transfer_ = {};
}

void RelightSession::place(std::size_t instance, const Placement& placement) {
    assert(instance < instances_.size() && placement.scale > 0);
    const auto* motion = std::get_if<MotionTransfer>(&transfer_);
    if (!motion || motion->instance != instance) transfer_ = {};
    kept_.reset();
    instances_[instance].placement = scene_.instances[instance].placement = placement;
}

std::size_t RelightSession::clone(std::size_t instance) {
    assert(instance < instances_.size());
    instances_change();
    instances_.push_back(SessionInstance(instances_[instance]));
    scene_.instances.push_back(ShadedInstance(scene_.instances[instance]));
    return instances_.size() - 1;
}

void RelightSession::remove(std::size_t instance) {
    assert(instance < instances_.size());
    instances_change();
    instances_.erase(instances_.begin() + static_cast<std::ptrdiff_t>(instance));
    scene_.instances.erase(scene_.instances.begin() + static_cast<std::ptrdiff_t>(instance));
    drop_unused_poses();
}

Result<Done> RelightSession::rotate(std::size_t instance, const Vec3d& axis, double angle,
                                    const Progress& progress) {
    assert(instance < instances_.size());
    SessionInstance turned = instances_[instance];
    turned.rotate = angles_xyz(rotation_about(axis, angle) * rotation_xyz(turned.rotate));
    std::optional<std::size_t> pose = pose_of(turned);
    if (!pose) {
        Result<std::shared_ptr<const OwnPose>> made = made_pose(turned, progress);
        if (!made) return made.error();
        const OwnPose& own = **made;
        if (geometry_) {
            const ShadedEntity shaded{&own.mesh.fine, &own.occlusion, &own.field, {}};
            Result<ShadingGeometry::Entity> blocking = entity_geometry(shaded, settings_, progress);
            if (!blocking) return blocking.error();
            geometry_->entities.push_back(std::move(*blocking));
            geometry_->rays.add_entity(shaded);
        }
        pose = poses_.size();
        poses_.push_back({turned.entity, turned.rotate, &own.mesh.fine, &own.occlusion, &own.field});
        owned_.push_back(std::move(*made));
        scene_.entities.push_back(
            {&own.mesh.fine, &own.occlusion, &own.field, entities_[turned.entity].materials});
    }
    instances_change();
    instances_[instance] = turned;
    scene_.instances[instance].entity = *pose;
    drop_unused_poses();
    return Done{};
}

Result<std::shared_ptr<const RelightSession::OwnPose>> RelightSession::made_pose(
    const SessionInstance& instance, const Progress& progress) const {
    const SessionEntity& entity = entities_[instance.entity];
    auto pose = std::make_shared<OwnPose>(turned_mesh(*entity.mesh, instance.rotate), progress.stop);
    if (progress.stop.stop_requested()) return Error{"", interrupted};
    Result<VisibilityField> field =
        precompute_field(entity.name, pose->mesh, pose->occlusion, entity.field, progress);
    if (!field) return field.error();
    pose->field = std::move(*field);
    return std::shared_ptr<const OwnPose>(std::move(pose));
}

void RelightSession::drop_unused_poses() {
    for (std::size_t p = poses_.size(); p-- > 0;) {
        const auto uses_it = [p](const ShadedInstance& instance) { return instance.entity == p; };
        if (!owned_[p] || std::any_of(scene_.instances.begin(), scene_.instances.end(), uses_it)) continue;
        const auto at = static_cast<std::ptrdiff_t>(p);
        poses_.erase(poses_.begin() + at);
        owned_.erase(owned_.begin() + at);
        scene_.entities.erase(scene_.entities.begin() + at);
        if (geometry_) {
            geometry_->entities.erase(geometry_->entities.begin() + at);
            geometry_->rays.remove_entity(p);
        }
        for (ShadedInstance& instance : scene_.instances)
            if (instance.entity > p) --instance.entity;
    }
}

Result<Done> RelightSession::frame(FrameQuality quality, const Progress& progress) {
    return transferred(quality, nullptr, progress);
}

Result<Done> RelightSession::frame_of(VertexMask vertices, FrameQuality quality, const Progress& progress) {
    assert(vertices.size() == instances_.size());
    if (geometry_)
        for (std::size_t i = 0; i < vertices.size(); ++i)
            geometry_->entities[scene_.instances[i].entity].fill.add_sources(vertices[i]);
    return transferred(quality, &vertices, progress);
}

Result<Done> RelightSession::transferred(FrameQuality quality, const VertexMask* vertices,
                                         const Progress& progress) {
    if (const auto* by_light = std::get_if<LightTransfer>(&transfer_)) {
        const Result<const DenseCoefficients*> now = light(progress);
        if (!now) return now.error();
        return shade_frame(*by_light, scene_, *geometry_, **now, source_lights(quality), radiance_, progress);
    }
    if (const auto* by_eye = std::get_if<ViewTransfer>(&transfer_))
        return shade_frame(*by_eye, scene_, *geometry_, radiance_, vertices, progress);
    if (const auto* by_motion = std::get_if<MotionTransfer>(&transfer_)) {
        geometry_->rays.place(scene_);
        return shade_frame(*by_motion, scene_, *geometry_, settings_, source_lights(quality), quality,
                           radiance_, progress);
    }
    return Error{"",
                 "there are no transfer vectors for what the scene is now; wanted vary_light, vary_eye or "
                 "vary_instance first"};
}

Result<Done> RelightSession::commit(const Progress& progress) {
    const Result<const ShadingGeometry*> geometry = current_geometry(progress);
    if (!geometry) return geometry.error();
    Environment environment =
        is_identity(rotation_) ? environment_ : turned_environment(environment_, rotation_, progress.stop);
    const SceneLight light = scene_light(environment, settings_, progress.stop);
    if (progress.stop.stop_requested()) return Error{"", interrupted};
    if (!kept_ && settings_.kept_bytes > 0) {
        Result<KeptVisibility> made =
            KeptVisibility::make(scene_, **geometry, settings_.kept_bytes, progress);
        if (!made) return made.error();
        kept_ = std::move(*made);
    }
    Result<SceneRadiance> full =
        scene_radiance({scene_, **geometry, light, settings_, kept_ ? &*kept_ : nullptr}, progress);
    if (!full) return full.error();
    scene_.environment = std::move(environment);
    radiance_ = std::move(*full);
    return Done{};
}

std::size_t RelightSession::transfer_bytes() const {
    return std::visit(
        [](const auto& transfer) -> std::size_t {
            if constexpr (requires { transfer.bytes(); })
                return transfer.bytes();
            else
                return 0;
        },
        transfer_);
}

}  // namespace haarfield
