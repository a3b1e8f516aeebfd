#include "shading/transfer/relight_session.h"

#include <algorithm>
#include <cassert>

#include "shading/bake/renderer.h"
#include "shading/bounces/row_loop.h"
#include "shading/scene/lighting.h"

namespace haarfield {
namespace {

constexpr int lights_while_moving = 4;     ///< Of a source.
constexpr float moving_tolerance = 0.01f;  ///< Of bounces.
constexpr int smoothing_while_moving = 4;  ///< Steps.
constexpr double step = 0.03, leap = 0.1;  ///< Changes of direct light from one frame to the next.

/// Returns the relative difference between two radiances by row, of a sample of the rows if there are many.
/// Infinite if one radiance does not exist.
double relative_change(std::span<const Rgb> radiance, std::span<const Rgb> other) {
    if (radiance.size() != other.size()) return INFINITY;
    constexpr std::size_t many = 1 << 16;
    const std::size_t stride = radiance.size() < many ? 1 : 8;
    double difference = 0, whole = 0;
    for (std::size_t row = 0; row < radiance.size(); row += stride) {
        difference += double(std::abs(luminance(radiance[row]) - luminance(other[row])));
        whole += double(luminance(other[row]));
    }
    return whole > 0 ? difference / whole : INFINITY;
}

/// True if instances are equal, except the translation and scale of one.
bool differ_in_place_only(std::span<const ShadedInstance> before, std::span<const ShadedInstance> now,
                          std::size_t moving) {
    if (before.size() != now.size()) return false;
    for (std::size_t i = 0; i < now.size(); ++i) {
        ShadedInstance moved = before[i];
        if (i == moving) {
            moved.placement.translate = now[i].placement.translate;
            moved.placement.scale = now[i].placement.scale;
        }
        if (moved != now[i]) return false;
    }
    return true;
}

/// Adds values at vertices, in parallel.
///
/// vertices  null: all.
/// value     returns the summand of an instance and a vertex.
template <class Value>
void add_at_vertices(SceneColours& sums, const VertexMask* vertices, const Value& value) {
    for (std::size_t i = 0; i < sums.size(); ++i)
        for_rows(sums[i].size(), [&](std::size_t v) {
            if (!vertices || (*vertices)[i][v]) sums[i][v] += value(i, v);
        });
}

/// Replaces the values without moving their memory, if their number is equal.
void replace(SceneColours& values, SceneColours by) {
    values.resize(by.size());
    for (std::size_t i = 0; i < by.size(); ++i)
        if (values[i].size() == by[i].size())
            std::ranges::copy(by[i], values[i].begin());
        else
            values[i] = std::move(by[i]);
}

bool has_specular(const ShadedScene& scene) {
    return std::ranges::any_of(scene.entities, [](const ShadedEntity& entity) {
        return std::ranges::any_of(entity.materials,
                                   [](const Material& material) { return material.specular != Rgb(0.0f); });
    });
}

}  // namespace

RelightSession::RelightSession(ShadedScene scene, const RenderSettings& settings,
                               const TransferSettings& transfer)
    : transfer_settings_(transfer), cached_occlusion_(settings.occlusion) {
    inputs_.environment = scene.environment;
    inputs_.scene = std::move(scene);
    inputs_.settings = settings;
}

Result<const DenseCoefficients*> RelightSession::light(const Progress& progress) {
    if (inputs_.shown_light) return &inputs_.shown_light->smooth;
    if (const DenseCoefficients* known = light_.find(inputs_)) return known;
    HF_TRY(const RgbCubemapTree* tree, light_tree(progress));
    return &light_.store(dense_coefficients(*tree, inputs_.settings.face_size), inputs_);
}

Result<const RgbCubemapTree*> RelightSession::light_tree(const Progress& progress) {
    if (const RgbCubemapTree* known = light_tree_.find(inputs_)) return known;
    const int face_size = inputs_.settings.face_size;
    const TurnableLight* turnable = turnable_.find(inputs_);
    if (!turnable) {
        TurnableLight made = turnable_light(split().smooth, face_size, progress.stop);
        if (progress.stop.stop_requested()) return interruption();
        turnable = &turnable_.store(std::move(made), inputs_);
    }
    return &light_tree_.store(haar_cubemap<Rgb>(turned_lighting_texels(*turnable, inputs_.rotation),
                                                face_size, Truncation{inputs_.settings.light_coefficients}),
                              inputs_);
}

Environment RelightSession::rotated_environment(const std::stop_token& stop) const {
    return is_identity(inputs_.rotation) ? inputs_.environment
                                         : turned_environment(inputs_.environment, inputs_.rotation, stop);
}

const SplitLight& RelightSession::split() {
    if (const SplitLight* known = split_.find(inputs_)) return *known;
    return split_.store(split_light(inputs_.environment, inputs_.settings.sources), inputs_);
}

double RelightSession::light_unevenness() {
    if (inputs_.settings.occlusion != Occlusion::automatic) return 1;
    if (const double* known = unevenness_.find(inputs_)) return *known;
    return unevenness_.store(unevenness(split().smooth), inputs_);
}

std::vector<LightSource> RelightSession::turned_sources() {
    std::vector<LightSource> sources = split().sources;
    for (LightSource& source : sources)
        for (auto* lights : {&source.lights, &source.parts})
            for (DirectionalLight& light : *lights) light.direction = inputs_.rotation(light.direction);
    return sources;
}

std::vector<DirectionalLight> RelightSession::source_lights(FrameQuality quality) {
    if (inputs_.shown_light) return inputs_.shown_light->lights;
    if (quality == FrameQuality::still) return all_lights(turned_sources());
    std::vector<DirectionalLight> lights;
    for (const LightSource& source : split().sources)
        for (DirectionalLight light : reduced_lights(source.lights, lights_while_moving)) {
            light.direction = inputs_.rotation(light.direction);
            lights.push_back(light);
        }
    return lights;
}

void RelightSession::adapt_geometry() {
    adapt_to_light(scene(), inputs_.settings, light_unevenness(), *geometry_);
}

Result<const ShadingGeometry*> RelightSession::current_geometry(const Progress& progress) {
    if (!geometry_) {
        HF_TRY(geometry_, shading_geometry(scene(), inputs_.settings, light_unevenness(), progress));
    } else {
        if (!placed_.find(inputs_)) HF_TRY_DONE(place_instances(scene(), *geometry_, progress));
        adapt_geometry();
    }
    placed_.store({}, inputs_);
    return &*geometry_;
}

Result<const BounceRays*> RelightSession::current_rays(const Progress& progress) {
    if (const BounceRays* known = rays_.find(inputs_)) return known;
    HF_TRY(BounceRays made, bounce_rays(scene(), *geometry_, inputs_.settings, progress, rays_.last()));
    return &rays_.store(std::move(made), inputs_);
}

Result<const SpecularHits*> RelightSession::current_hits(const Progress& progress) {
    if (const SpecularHits* known = hits_.find(inputs_)) return known;
    HF_TRY(const BounceRays* rays, current_rays(progress));
    HF_TRY(SpecularHits made, SpecularHits::make(scene(), *geometry_, *rays->surface,
                                                 rays->transport.hidden(), nullptr, progress));
    return &hits_.store(std::move(made), inputs_);
}

Result<const CachedVisibility*> RelightSession::cached_visibility(const Progress& progress) {
    const RenderSettings& settings = inputs_.settings;
    if (settings.occlusion != cached_occlusion_ || settings.kept_bytes == 0) return nullptr;
    if (const CachedVisibility* known = cached_visibility_.find(inputs_)) return known;
    HF_TRY(CachedVisibility made, CachedVisibility::make(scene(), *geometry_, settings.kept_bytes, progress));
    return &cached_visibility_.store(std::move(made), inputs_);
}

const PlacedFill& RelightSession::placed_fill() {
    if (const PlacedFill* known = placed_fill_.find(inputs_)) return *known;
    return placed_fill_.store(PlacedFill(scene()), inputs_);
}

LampFrames& RelightSession::lamp_frames() {
    if (LampFrames* known = lamp_frames_.find(inputs_)) return *known;
    return lamp_frames_.store({}, inputs_);
}

Result<Done> RelightSession::prepare(const Progress& progress) {
    HF_TRY_DONE(current_geometry(progress));
    HF_TRY_DONE(light_tree(progress));
    return Done{};
}

Result<Done> RelightSession::vary_light(const Progress& progress) {
    const RenderSettings& settings = inputs_.settings;
    HF_TRY(const ShadingGeometry* geometry, current_geometry(progress));
    HF_TRY(const DenseCoefficients* typical, light(progress));
    HF_TRY(LightTransfer made,
           light_transfer(scene(), *geometry, settings, transfer_settings_, *typical, progress));
    LightFrames frames;
    frames.transfer = std::move(made);
    if (settings.bounces.most > 0) {
        HF_TRY(const BounceRays* rays, current_rays(progress));
        std::vector<Rgb> radiance, diffuse;
        HF_TRY_DONE(shade_rows(frames.transfer, geometry->rays, *typical, source_lights(FrameQuality::still),
                               FrameQuality::still, radiance, &diffuse, progress));
        diffuse = tinted_rows(scene(), VertexRows(scene(), *geometry), std::move(diffuse));
        frames.reflectances = row_reflectances(scene(), *geometry);
        frames.transport = rays->transport;
        HF_TRY(BouncedLight bounced,
               bounced_light(*frames.transport, frames.reflectances, diffuse, settings.bounces, progress));
        HF_TRY_DONE(frames.transport->refine(scene(), *geometry, *rays->surface, bounced.radiance,
                                             frames.reflectances, progress));
        frames.coarse = frames.transport->coarse();
        HF_TRY_DONE(current_hits(progress));
        frames.last = {std::move(diffuse), std::move(bounced.irradiance), {}, 0};
    }
    transfer_.emplace<ByLight>().store(std::move(frames), inputs_);
    return Done{};
}

Result<Done> RelightSession::vary_eye(const Progress& progress) {
    HF_TRY(const ShadingGeometry* geometry, current_geometry(progress));
    HF_TRY(const RgbCubemapTree* light, light_tree(progress));
    HF_TRY(ViewTransfer made, view_transfer(scene(), *geometry, inputs_.settings, transfer_settings_, *light,
                                            turned_sources(), progress));
    Bounced indirect;
    if (inputs_.settings.bounces.most > 0) {
        HF_TRY(const BounceRays* rays, current_rays(progress));
        // As in a bake, there are more rays where this light is uncertain.
        LightTransport transport = rays->transport;
        HF_TRY(const Bounced coarse, bounced(transport, made.diffuse, inputs_.settings.bounces, progress));
        HF_TRY_DONE(transport.refine(scene(), *geometry, *rays->surface, coarse.diffuse,
                                     row_reflectances(scene(), *geometry), progress));
        HF_TRY(indirect, bounced(transport, made.diffuse, inputs_.settings.bounces, progress));
    }
    transfer_.emplace<ByEye>().store({std::move(made), std::move(indirect)}, inputs_);
    return Done{};
}

Result<Done> RelightSession::vary_instance(std::size_t instance, const Progress& progress) {
    const RenderSettings& settings = inputs_.settings;
    assert(instance < instances().size());
    HF_TRY(const ShadingGeometry* geometry, current_geometry(progress));
    HF_TRY(const RgbCubemapTree* light, light_tree(progress));
    HF_TRY(MotionTransfer made, motion_transfer(scene(), *geometry, settings, transfer_settings_, *light,
                                                all_lights(turned_sources()), instance, progress));
    std::optional<MattMotion> matt;
    if (separates_components_) {
        ShadedScene without_specular = scene();
        without_specular.environment = {};
        for (ShadedEntity& entity : without_specular.entities)
            for (Material& material : entity.materials) material.specular = Rgb(0.0f);
        HF_TRY(MotionTransfer of_matt,
               motion_transfer(without_specular, *geometry, settings, transfer_settings_, *light,
                               all_lights(turned_sources()), instance, progress));
        matt = {std::move(without_specular), std::move(of_matt)};
    }
    SceneRadiance indirect;
    if (settings.bounces.most > 0) {
        if (!resting_.find(inputs_)) {
            const SceneLight now = scene_light(rotated_environment(progress.stop), settings, progress.stop);
            HF_TRY(const SceneRadiance direct, scene_radiance({scene(), *geometry, now, settings}, progress));
            HF_TRY(const IndirectLight found, indirect_at_rest(direct, now, progress));
            HF_TRY(SceneRadiance resting, radiance_at_rest(found, now, progress));
            resting_.store(std::move(resting), inputs_);
        }
        HF_TRY_DONE(update_lamps(progress));
        indirect = *resting_.find(inputs_);
    }
    transfer_.emplace<ByMotion>().store({std::move(made), instances(), std::move(indirect), std::move(matt)},
                                        inputs_);
    return Done{};
}

Result<Done> RelightSession::vary_lamps(const Progress& progress) {
    HF_TRY(const SceneRadiance steady,
           full_radiance(scene_light(rotated_environment(progress.stop), inputs_.settings, progress.stop),
                         progress));
    HF_TRY_DONE(update_lamps(progress));
    transfer_.emplace<ByLamps>().store({total(steady), diffuse_component(steady)}, inputs_);
    return Done{};
}

void RelightSession::drop_outdated() {
    if (!has_vectors()) transfer_ = {};
    cached_visibility_.drop_outdated(inputs_);
}

void RelightSession::set_environment(Environment environment) {
    inputs_.environment = std::move(environment);
    inputs_.changed(I::environment);
    if (cached_occlusion_ == Occlusion::automatic) inputs_.changed(I::exact_distances);
    turn_environment({});
}

void RelightSession::show_light(DenseCoefficients light, std::vector<DirectionalLight> lights) {
    assert(light.face_size == inputs_.settings.face_size);
    inputs_.shown_light = {std::move(light), std::move(lights)};
    inputs_.changed(I::shown_light);
    drop_outdated();
}

void RelightSession::turn_environment(const Rotation& rotation) {
    if (inputs_.shown_light) inputs_.changed(I::shown_light);
    inputs_.shown_light.reset();
    inputs_.set(I::rotation, inputs_.rotation, rotation);
    drop_outdated();
}

void RelightSession::set_lamps(std::vector<Lamp> lamps) {
    assert(std::ranges::all_of(
        lamps, [&](const Lamp& lamp) { return lamp.looks_like.value_or(0) < instances().size(); }));
    inputs_.set(I::lamps, inputs_.scene.lamps, std::move(lamps));
}

void RelightSession::set_eye(const Vec3f& eye) {
    inputs_.set(I::eye, inputs_.scene.eye, eye);
    drop_outdated();
}

void RelightSession::place(std::size_t instance, const Placement& placement) {
    assert(instance < instances().size() && placement.scale > 0);
    inputs_.set(I::instances, inputs_.scene.instances[instance].placement, placement);
    drop_outdated();
}

void RelightSession::set_materials(std::size_t entity, std::vector<Material> materials) {
    assert(materials.size() == scene().entities[entity].materials.size());
    inputs_.set(I::materials, inputs_.scene.entities[entity].materials, std::move(materials));
    drop_outdated();
}

void RelightSession::set_emitters(std::size_t entity, std::vector<Emitter> emitters) {
    inputs_.set(I::emitters, inputs_.scene.entities[entity].emitters, std::move(emitters));
}

void RelightSession::set_occlusion(Occlusion occlusion) {
    inputs_.settings.occlusion = occlusion;
}

void RelightSession::separate_components(bool separates) {
    separates_components_ = separates;
    if (!separates) diffuse_.clear();
    drop_outdated();
}

std::size_t RelightSession::add(const ShadedInstance& instance) {
    assert(instance.entity < scene().entities.size());
    inputs_.scene.instances.push_back(instance);
    inputs_.changed(I::instances);
    drop_outdated();
    return instances().size() - 1;
}

std::size_t RelightSession::clone(std::size_t instance) {
    assert(instance < instances().size());
    return add(ShadedInstance(instances()[instance]));
}

void RelightSession::remove(std::size_t instance) {
    assert(instance < instances().size());
    std::vector<Lamp> lamps = scene().lamps;
    for (Lamp& lamp : lamps) {
        if (lamp.looks_like == instance) lamp.looks_like.reset();
        if (lamp.looks_like && *lamp.looks_like > instance) --*lamp.looks_like;
    }
    inputs_.set(I::lamps, inputs_.scene.lamps, std::move(lamps));
    inputs_.scene.instances.erase(inputs_.scene.instances.begin() + static_cast<std::ptrdiff_t>(instance));
    inputs_.changed(I::instances);
    drop_outdated();
}

void RelightSession::rotate(std::size_t instance, const Vec3d& axis, double angle) {
    assert(instance < instances().size());
    constexpr double not_turned = 1e-9;
    Placement placement = instances()[instance].placement;
    placement.rotate = rotation_about(axis, angle) * placement.rotate;
    double largest = 0;
    for (std::size_t i = 0; i < 3; ++i)
        largest = std::max(largest, (placement.rotate.row[i] - Rotation().row[i]).length());
    if (largest <= not_turned) placement.rotate = {};
    place(instance, placement);
}

bool RelightSession::has_vectors() const {
    if (std::holds_alternative<ByLight>(transfer_)) return std::get<ByLight>(transfer_).find(inputs_);
    if (std::holds_alternative<ByEye>(transfer_)) return std::get<ByEye>(transfer_).find(inputs_);
    if (std::holds_alternative<ByLamps>(transfer_)) return std::get<ByLamps>(transfer_).find(inputs_);
    const auto* by_motion = std::get_if<ByMotion>(&transfer_);
    const MotionFrames* frames = by_motion ? by_motion->find(inputs_) : nullptr;
    return frames && (frames->matt || !separates_components_) &&
           differ_in_place_only(frames->instances, instances(), frames->transfer.instance);
}

Result<Done> RelightSession::frame(FrameQuality quality, const Progress& progress) {
    return transferred(quality, nullptr, progress);
}

Result<Done> RelightSession::frame_of(VertexMask vertices, FrameQuality quality, const Progress& progress) {
    assert(vertices.size() == instances().size());
    placed_fill().add_sources(vertices);
    if (geometry_)
        for (std::size_t i = 0; i < vertices.size(); ++i)
            geometry_->entities[instances()[i].entity].fill.add_sources(vertices[i]);
    return transferred(quality, &vertices, progress);
}

Result<Done> RelightSession::transferred(FrameQuality quality, const VertexMask* vertices,
                                         const Progress& progress) {
    if (!has_vectors())
        return Error{"",
                     "found no transfer vectors for the current scene; expected a call that computes them "
                     "(vary_light, vary_eye, vary_lamps, vary_instance) first"};
    if (std::holds_alternative<ByMotion>(transfer_)) {
        geometry_->rays.place(scene());
        adapt_geometry();
    }
    HF_TRY_DONE(update_lamps(progress));
    lacks_reflections_ = false;
    HF_TRY_DONE(std::visit(
        [&](auto& memo) -> Result<Done> {
            if constexpr (requires { memo.last(); })
                return shade(*memo.last(), quality, vertices, progress);
            else
                return Done{};
        },
        transfer_));
    lamp_frames().add_to(radiance_, separates_components_ ? &diffuse_ : nullptr, vertices);
    if (const Bounced* lamps = lamps_bounced_.last()) add_diffuse(lamps->reflected, vertices);
    if (const auto* by_eye = std::get_if<ByEye>(&transfer_)) {
        HF_TRY_DONE(add_reflections(*by_eye->last(), quality, vertices, progress));
    } else if (const SceneColours* reflected = lamps_reflected_.last()) {
        add_specular(*reflected, vertices);
    }
    placed_fill()(radiance_);
    if (separates_components_) placed_fill()(diffuse_);
    return Done{};
}

Result<Done> RelightSession::shade(LightFrames& frames, FrameQuality quality, const VertexMask* /*vertices*/,
                                   const Progress& progress) {
    HF_TRY(const DenseCoefficients* now, light(progress));
    const bool bounces = inputs_.settings.bounces.most > 0, separates = separates_components_;
    std::vector<Rgb>&radiance = frames.radiance, &diffuse = frames.diffuse;
    HF_TRY_DONE(shade_rows(frames.transfer, geometry_->rays, *now, source_lights(quality), quality, radiance,
                           bounces || separates ? &frames.direct : nullptr, progress));
    if (separates) diffuse = frames.direct;
    if (bounces) {
        frames.direct = tinted_rows(scene(), VertexRows(scene(), *geometry_), std::move(frames.direct));
        HF_TRY_DONE(find_irradiance(frames, quality, progress));
        const bool reflects = !frames.last.reflected.empty();
        for_rows(radiance.size(), [&](std::size_t row) {
            const Rgb indirect =
                frames.transfer.colours[frames.transfer.colour_of_row[row]][0] * frames.irradiance[row];
            radiance[row] = without_negative(radiance[row]) + indirect;
            if (reflects) radiance[row] += frames.last.reflected[row];
            if (separates) diffuse[row] += indirect;
        });
    }
    store_radiance(scene(), *geometry_, radiance, radiance_);
    if (separates) store_radiance(scene(), *geometry_, diffuse, diffuse_);
    return Done{};
}

Result<Done> RelightSession::shade(EyeFrames& frames, FrameQuality /*quality*/, const VertexMask* vertices,
                                   const Progress& progress) {
    HF_TRY_DONE(shade_frame(frames.transfer, scene(), *geometry_, radiance_, vertices, progress));
    if (separates_components_)
        store_radiance(scene(), *geometry_, frames.transfer.diffuse, diffuse_, vertices);
    add_diffuse(frames.indirect.reflected, vertices);
    return Done{};
}

Result<Done> RelightSession::shade(MotionFrames& frames, FrameQuality quality, const VertexMask* /*vertices*/,
                                   const Progress& progress) {
    SceneColours diffuse;
    if (separates_components_) {
        frames.matt->scene.instances = instances();
        HF_TRY_DONE(shade_frame(frames.matt->transfer, frames.matt->scene, *geometry_, inputs_.settings,
                                quality, diffuse, progress));
    }
    HF_TRY_DONE(
        shade_frame(frames.transfer, scene(), *geometry_, inputs_.settings, quality, radiance_, progress));
    diffuse_ = std::move(diffuse);
    add_radiance(frames.indirect);
    return Done{};
}

Result<Done> RelightSession::shade(OtherLight& frames, FrameQuality /*quality*/,
                                   const VertexMask* /*vertices*/, const Progress& /*progress*/) {
    radiance_ = frames.radiance;
    if (separates_components_) diffuse_ = frames.diffuse;
    return Done{};
}

Result<SceneRadiance> RelightSession::full_radiance(const SceneLight& light, const Progress& progress) {
    HF_TRY(const ShadingGeometry* geometry, current_geometry(progress));
    if (progress.stop.stop_requested()) return interruption();
    HF_TRY(const CachedVisibility* visibility, cached_visibility(progress));
    const PointShading shading{scene(), *geometry, light, inputs_.settings, visibility};
    HF_TRY(SceneRadiance radiance, scene_radiance(shading, progress));
    if (inputs_.settings.bounces.most == 0) {
        placed_fill()(radiance);
        return radiance;
    }
    HF_TRY(const IndirectLight indirect, indirect_at_rest(radiance, light, progress));
    HF_TRY(SceneRadiance resting, radiance_at_rest(indirect, light, progress));
    // By component, as a bake adds them, so that the sums are bit-identical.
    for (std::size_t i = 0; i < resting.size(); ++i) {
        std::vector<Outgoing>& sums = radiance[i];
        for_rows(sums.size(), [&](std::size_t v) { sums[v] += resting[i][v]; });
        geometry->entities[instances()[i].entity].fill(sums);
    }
    if (light.lamps.empty() && light.emitters.empty()) resting_.store(std::move(resting), inputs_);
    placed_fill()(radiance);
    return radiance;
}

Result<Done> RelightSession::commit(const Progress& progress) {
    Environment environment = rotated_environment(progress.stop);
    HF_TRY(const SceneRadiance full,
           full_radiance(scene_light(scene(), environment, inputs_.settings, progress.stop), progress));
    inputs_.scene.environment = std::move(environment);
    lacks_reflections_ = false;
    replace(radiance_, total(full));
    if (separates_components_) diffuse_ = diffuse_component(full);
    return Done{};
}

Result<BakeError> RelightSession::error(const SceneRadiance& shown, std::vector<DisplayedPoint> population,
                                        double accuracy, const Progress& progress) {
    ShadedScene lit = scene();
    lit.environment = rotated_environment(progress.stop);
    const SceneLight light = scene_light(lit, inputs_.settings, progress.stop);
    HF_TRY(const ShadingGeometry* geometry, current_geometry(progress));
    if (progress.stop.stop_requested()) return interruption();
    PointShading shading{lit, *geometry, light, inputs_.settings};
    std::optional<IndirectLight> indirect;
    if (inputs_.settings.bounces.most > 0) {
        HF_TRY(shading.visibility, cached_visibility(progress));
        HF_TRY(const SceneRadiance direct, scene_radiance(shading, progress));
        HF_TRY(indirect, indirect_at_rest(direct, light, progress));
        shading.indirect = &*indirect;
    }
    return vertex_bake_error(shading, shown, std::move(population), accuracy, progress);
}

std::vector<Outgoing> RelightSession::outgoing(std::size_t instance) const {
    const std::vector<Rgb>& all = radiance_[instance];
    std::vector<Outgoing> result;
    result.reserve(all.size());
    for (std::size_t v = 0; v < all.size(); ++v) {
        const Rgb specular = diffuse_.empty() ? Rgb(0.0f) : without_negative(all[v] - diffuse_[instance][v]);
        result.push_back({all[v] - specular, specular});
    }
    return result;
}

Result<IndirectLight> RelightSession::indirect_at_rest(const SceneRadiance& direct, const SceneLight& light,
                                                       const Progress& progress) {
    HF_TRY(const BounceRays* rays, current_rays(progress));
    return scene_indirect_light({scene(), *geometry_, light, inputs_.settings}, direct, *rays, progress);
}

Result<SceneRadiance> RelightSession::radiance_at_rest(const IndirectLight& indirect, const SceneLight& light,
                                                       const Progress& progress) const {
    SceneRadiance radiance = black_vertices(scene());
    HF_TRY_DONE(add_indirect_radiance({scene(), *geometry_, light, inputs_.settings, nullptr, &indirect},
                                      radiance, progress));
    return radiance;
}

Result<RelightSession::Bounced> RelightSession::bounced(const LightTransport& transport,
                                                        std::vector<Rgb> diffuse,
                                                        const BounceSettings& bounces,
                                                        const Progress& progress) const {
    const std::vector<Rgb> direct = tinted_rows(scene(), VertexRows(scene(), *geometry_), std::move(diffuse));
    HF_TRY(BouncedLight found,
           bounced_light(transport, row_reflectances(scene(), *geometry_), direct, bounces, progress));
    transport.smooth(found.irradiance);
    return Bounced{radiance_by(found.irradiance), std::move(found.radiance)};
}

Result<Done> RelightSession::find_irradiance(LightFrames& frames, FrameQuality quality,
                                             const Progress& progress) {
    auto& last = frames.last;
    const LightTransport& transport = *frames.transport;
    const bool may_lag = quality == FrameQuality::moving && inputs_.settings.bounces.most == any_bounces;
    const double change = may_lag ? relative_change(frames.direct, last.direct) : INFINITY;
    // Before the first frame, `last` has the irradiance of fewer rays: vary_light() refines them afterwards.
    const bool by_halves = change < step && last.frames > 0;
    const auto outgoing = [&] {
        frames.sent.resize(frames.direct.size());
        for_rows(frames.sent.size(), [&](std::size_t row) {
            frames.sent[row] = frames.direct[row] + frames.reflectances[row] * last.arriving[row];
        });
    };
    if (change < leap) {
        outgoing();
        if (by_halves)
            transport.update_irradiance(frames.sent, last.frames % 2, last.arriving);
        else
            last.arriving = transport.irradiance(frames.sent);
    } else {
        BounceSettings bounces = inputs_.settings.bounces;
        if (quality == FrameQuality::moving)
            bounces.tolerance = std::max(bounces.tolerance, moving_tolerance);
        HF_TRY(BouncedLight found, bounced_light(transport, frames.coarse, frames.reflectances, frames.direct,
                                                 bounces, progress));
        last.arriving = std::move(found.irradiance);
    }
    HF_TRY(const SpecularHits* hits, current_hits(progress));
    if (!hits->is_empty()) {
        outgoing();
        last.reflected.resize(frames.sent.size(), Rgb(0.0f));
        if (by_halves)
            hits->reflect(frames.sent, last.reflected, last.frames % 2, 2);
        else
            hits->reflect(frames.sent, last.reflected);
    }
    ++last.frames;
    frames.irradiance = last.arriving;
    std::swap(last.direct, frames.direct);
    transport.smooth(frames.irradiance, quality == FrameQuality::moving ? smoothing_while_moving
                                                                        : transport.most_smoothing_steps);
    return Done{};
}

Result<Done> RelightSession::update_lamps(const Progress& progress) {
    LampFrames& lamps = lamp_frames();
    const bool bounces = inputs_.settings.bounces.most > 0;
    HF_TRY_DONE(lamps.update(scene(), *geometry_, progress));
    // While an instance moves, indirect light stays as it was.
    const bool moves = std::holds_alternative<ByMotion>(transfer_) && !rays_.find(inputs_);
    if (!bounces || moves) return Done{};
    if (!lamps_bounced_.find(inputs_)) {
        Bounced by_lamps;
        if (!lamps.is_dark()) {
            HF_TRY(const BounceRays* rays, current_rays(progress));
            const VertexRows rows(scene(), *geometry_);
            HF_TRY(by_lamps, bounced(rays->transport, row_values(rows, lamps.diffuse(scene())),
                                     inputs_.settings.bounces, progress));
        }
        lamps_bounced_.store(std::move(by_lamps), inputs_);
    }
    if (std::holds_alternative<ByEye>(transfer_) || lamps_reflected_.find(inputs_)) return Done{};
    HF_TRY(SceneColours reflected, reflections(lamps_bounced_.last()->diffuse, nullptr, progress));
    lamps_reflected_.store(std::move(reflected), inputs_);
    return Done{};
}

Result<SceneColours> RelightSession::reflections(std::span<const Rgb> diffuse, const VertexMask* vertices,
                                                 const Progress& progress) {
    SceneColours radiance;
    if (diffuse.empty() || !has_specular(scene())) return radiance;
    const SpecularHits* hits = hits_.find(inputs_);
    std::optional<SpecularHits> some;
    if (!hits && vertices) {
        HF_TRY(const BounceRays* rays, current_rays(progress));
        HF_TRY(SpecularHits made, SpecularHits::make(scene(), *geometry_, *rays->surface,
                                                     rays->transport.hidden(), vertices, progress));
        hits = &some.emplace(std::move(made));
    } else if (!hits) {
        HF_TRY(const SpecularHits* made, current_hits(progress));
        hits = made;
    }
    std::vector<Rgb> by_row(diffuse.size(), Rgb(0.0f));
    hits->reflect(diffuse, by_row);
    store_radiance(scene(), *geometry_, by_row, radiance);
    return radiance;
}

Result<Done> RelightSession::add_reflections(const EyeFrames& frames, FrameQuality quality,
                                             const VertexMask* vertices, const Progress& progress) {
    if (frames.indirect.diffuse.empty() || !has_specular(scene())) return Done{};
    lacks_reflections_ = quality == FrameQuality::moving && !hits_.find(inputs_);
    if (lacks_reflections_) return Done{};
    std::vector<Rgb> diffuse = frames.indirect.diffuse;
    if (const Bounced* lamps = lamps_bounced_.last(); lamps && !lamps->diffuse.empty())
        for_rows(diffuse.size(), [&](std::size_t row) { diffuse[row] += lamps->diffuse[row]; });
    HF_TRY(const SceneColours reflected, reflections(diffuse, vertices, progress));
    add_specular(reflected, vertices);
    return Done{};
}

SceneColours RelightSession::radiance_by(std::span<const Rgb> irradiance) const {
    const VertexRows rows(scene(), *geometry_);
    std::vector<Rgb> outgoing(irradiance.begin(), irradiance.end());
    for (std::size_t i = 0; i < instances().size(); ++i) {
        const ShadedEntity& entity = scene().entities[instances()[i].entity];
        const std::span<const std::uint32_t> vertices = rows.vertices(i);
        const std::span<Rgb> values = std::span(outgoing).subspan(rows.first(i), vertices.size());
        for_rows(values.size(), [&](std::size_t k) {
            values[k] *= entity.materials[entity.mesh->vertex_materials[vertices[k]]].diffuse *
                         static_cast<float>(1 / pi);
        });
    }
    SceneColours radiance;
    store_radiance(scene(), *geometry_, outgoing, radiance);
    return radiance;
}

void RelightSession::add_diffuse(const SceneColours& part, const VertexMask* vertices) {
    if (part.empty()) return;
    const auto value = [&](std::size_t i, std::size_t v) { return part[i][v]; };
    add_at_vertices(radiance_, vertices, value);
    if (separates_components_) add_at_vertices(diffuse_, vertices, value);
}

void RelightSession::add_specular(const SceneColours& part, const VertexMask* vertices) {
    if (!part.empty())
        add_at_vertices(radiance_, vertices, [&](std::size_t i, std::size_t v) { return part[i][v]; });
}

void RelightSession::add_radiance(const SceneRadiance& part) {
    if (part.empty()) return;
    add_at_vertices(radiance_, nullptr, [&](std::size_t i, std::size_t v) { return part[i][v].total(); });
    if (separates_components_)
        add_at_vertices(diffuse_, nullptr, [&](std::size_t i, std::size_t v) { return part[i][v].diffuse; });
}

std::size_t RelightSession::transfer_bytes() const {
    const LampFrames* lamps = lamp_frames_.find(inputs_);
    const SpecularHits* hits = hits_.find(inputs_);
    return (lamps ? lamps->bytes() : 0) + (hits ? hits->bytes() : 0) +
           std::visit(
               [](const auto& memo) -> std::size_t {
                   if constexpr (requires { memo.last(); })
                       return memo.last()->bytes();
                   else
                       return 0;
               },
               transfer_);
}

}  // namespace haarfield
