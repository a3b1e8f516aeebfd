#include "shading/transfer/relight_session.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

#include "shading/bake/renderer.h"
#include "shading/scene/lighting.h"

namespace haarfield {
namespace {

constexpr int lights_while_moving = 4;     ///< A source.
constexpr float frame_tolerance = 0.01f;   ///< Of bounces.
constexpr int frame_smoothing = 4;         ///< Steps.
constexpr double step = 0.03, leap = 0.1;  ///< Changes of direct light from one frame to the next.

/// How much of its whole radiance by row differs from another's: of some rows where there are many, of which
/// neighbours are much alike. Infinite if there is none.
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

/// Acts on all numbers below a count, in parallel.
template <class Act>
void for_rows(std::size_t count, const Act& act) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096), [&](const auto& range) {
        for (std::size_t row = range.begin(); row != range.end(); ++row) act(row);
    });
}

}  // namespace

RelightSession::RelightSession(ShadedScene scene, const RenderSettings& settings,
                               const TransferSettings& transfer)
    : settings_(settings),
      transfer_settings_(transfer),
      scene_(std::move(scene)),
      environment_(scene_.environment) {}

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

Environment RelightSession::shown_environment(const std::stop_token& stop) const {
    return is_identity(rotation_) ? environment_ : turned_environment(environment_, rotation_, stop);
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
    const bool is_automatic = settings_.occlusion == Occlusion::automatic;
    if (is_automatic && !unevenness_) unevenness_ = unevenness(split().smooth);
    if (!geometry_) {
        Result<ShadingGeometry> made =
            shading_geometry(scene_, settings_, is_automatic ? *unevenness_ : 1, progress);
        if (!made) return made.error();
        geometry_ = std::move(*made);
    } else {
        if (!is_placed_)
            if (const Result<Done> placed = place_instances(scene_, *geometry_, progress); !placed)
                return placed.error();
        if (is_automatic) adapt_to_light(scene_, settings_, *unevenness_, *geometry_);
    }
    is_placed_ = true;
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
    std::optional<LightTransport> refined;
    if (settings_.bounces.most > 0) {
        const Result<const BounceRays*> rays = current_rays(progress);
        if (!rays) return rays.error();
        std::vector<Rgb> radiance, diffuse;
        const Result<Done> shaded =
            shade_rows(*made, (*geometry)->rays, **typical, source_lights(FrameQuality::still),
                       FrameQuality::still, radiance, &diffuse, progress);
        if (!shaded) return shaded;
        diffuse = tinted_rows(scene_, VertexRows(scene_, **geometry), std::move(diffuse));
        std::vector<Rgb> reflectances = row_reflectances(scene_, **geometry);
        refined = (*rays)->transport;
        Result<BouncedLight> bounced =
            bounced_light(*refined, reflectances, diffuse, settings_.bounces, progress);
        if (!bounced) return bounced.error();
        const Result<Done> done =
            refined->refine(scene_, **geometry, *(*rays)->surface, bounced->radiance, reflectances, progress);
        if (!done) return done;
        reflectances_ = std::move(reflectances);
        last_ = {std::move(diffuse), std::move(bounced->irradiance), 0};
    }
    refined_ = std::move(refined);
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
    if (settings_.bounces.most > 0) {
        const Result<const BounceRays*> rays = current_rays(progress);
        if (!rays) return rays.error();
        Result<SceneRadiance> bounced =
            bounced_radiance((*rays)->transport, made->diffuse, settings_.bounces, progress);
        if (!bounced) return bounced.error();
        bounced_ = std::move(*bounced);
    }
    transfer_ = std::move(*made);
    return Done{};
}

Result<Done> RelightSession::vary_instance(std::size_t instance, const Progress& progress) {
    assert(instance < scene_.instances.size());
    const Result<const ShadingGeometry*> geometry = current_geometry(progress);
    if (!geometry) return geometry.error();
    const Result<const RgbCubemapTree*> light = light_tree(progress);
    if (!light) return light.error();
    Result<MotionTransfer> made = motion_transfer(scene_, **geometry, settings_, transfer_settings_, **light,
                                                  all_lights(turned_sources()), instance, progress);
    if (!made) return made.error();
    if (settings_.bounces.most > 0) {
        if (!resting_) {
            const SceneLight now = scene_light(shown_environment(progress.stop), settings_, progress.stop);
            const Result<RadianceParts> parts =
                radiance_parts({scene_, **geometry, now, settings_}, progress);
            if (!parts) return parts.error();
            const Result<IndirectLight> indirect = indirect_at_rest(parts->diffuse, now, progress);
            if (!indirect) return indirect.error();
            resting_ = radiance_by(row_values(VertexRows(scene_, **geometry), indirect->irradiance));
        }
        if (const Result<Done> lamps = update_lamps(progress); !lamps) return lamps;
        bounced_ = *resting_;
    }
    transfer_ = std::move(*made);
    return Done{};
}

Result<Done> RelightSession::vary_lamps(const Progress& progress) {
    Result<SceneRadiance> steady =
        full_radiance(scene_light(shown_environment(progress.stop), settings_, progress.stop), progress);
    if (!steady) return steady.error();
    if (const Result<Done> made = update_lamps(progress); !made) return made;
    transfer_ = SteadyLight{std::move(*steady)};
    return Done{};
}

void RelightSession::light_changes() {
    shown_lights_.reset();
    light_tree_.reset();
    light_.reset();
    resting_.reset();
    if (!std::holds_alternative<LightTransfer>(transfer_)) transfer_ = {};
}

void RelightSession::instances_change() {
    are_rays_current_ = false;
    is_placed_ = false;
    transfer_ = {};
    resting_.reset();
    kept_.reset();
    lamp_frames_.forget();
}

void RelightSession::set_environment(Environment environment) {
    environment_ = std::move(environment);
    split_.reset();
    unevenness_.reset();
    // How far out vertices see exactly may change with the light.
    if (settings_.occlusion == Occlusion::automatic) kept_.reset();
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

void RelightSession::set_lamps(std::vector<Lamp> lamps) {
    assert(std::ranges::all_of(
        lamps, [&](const Lamp& lamp) { return lamp.looks_like.value_or(0) < scene_.instances.size(); }));
    scene_.lamps = std::move(lamps);
}

void RelightSession::set_eye(const Vec3f& eye) {
    scene_.eye = eye;
    if (!std::holds_alternative<ViewTransfer>(transfer_)) transfer_ = {};
}

void RelightSession::place(std::size_t instance, const Placement& placement) {
    assert(instance < scene_.instances.size() && placement.scale > 0);
    ShadedInstance& placed = scene_.instances[instance];
    const auto* motion = std::get_if<MotionTransfer>(&transfer_);
    if (!motion || motion->instance != instance || placed.placement.rotate != placement.rotate)
        transfer_ = {};
    are_rays_current_ = false;
    is_placed_ = false;
    resting_.reset();
    kept_.reset();
    lamp_frames_.forget();
    placed.placement = placement;
}

void RelightSession::set_materials(std::size_t entity, std::vector<Material> materials) {
    assert(materials.size() == scene_.entities[entity].materials.size());
    scene_.entities[entity].materials = std::move(materials);
    transfer_ = {};
    resting_.reset();
    lamp_frames_.forget();
}

std::size_t RelightSession::add(const ShadedInstance& instance) {
    assert(instance.entity < scene_.entities.size());
    instances_change();
    scene_.instances.push_back(instance);
    return scene_.instances.size() - 1;
}

std::size_t RelightSession::clone(std::size_t instance) {
    assert(instance < scene_.instances.size());
    return add(ShadedInstance(scene_.instances[instance]));
}

void RelightSession::remove(std::size_t instance) {
    assert(instance < scene_.instances.size());
    instances_change();
    for (Lamp& lamp : scene_.lamps) {
        if (lamp.looks_like == instance) lamp.looks_like.reset();
        if (lamp.looks_like && *lamp.looks_like > instance) --*lamp.looks_like;
    }
    scene_.instances.erase(scene_.instances.begin() + static_cast<std::ptrdiff_t>(instance));
}

void RelightSession::rotate(std::size_t instance, const Vec3d& axis, double angle) {
    assert(instance < scene_.instances.size());
    constexpr double not_turned = 1e-9;
    Placement placement = scene_.instances[instance].placement;
    placement.rotate = rotation_about(axis, angle) * placement.rotate;
    double largest = 0;
    for (std::size_t i = 0; i < 3; ++i)
        largest = std::max(largest, (placement.rotate.row[i] - Rotation().row[i]).length());
    if (largest <= not_turned) placement.rotate = {};
    place(instance, placement);
}

Result<Done> RelightSession::frame(FrameQuality quality, const Progress& progress) {
    return transferred(quality, nullptr, progress);
}

Result<Done> RelightSession::frame_of(VertexMask vertices, FrameQuality quality, const Progress& progress) {
    assert(vertices.size() == scene_.instances.size());
    if (geometry_)
        for (std::size_t i = 0; i < vertices.size(); ++i)
            geometry_->entities[scene_.instances[i].entity].fill.add_sources(vertices[i]);
    return transferred(quality, &vertices, progress);
}

Result<Done> RelightSession::transferred(FrameQuality quality, const VertexMask* vertices,
                                         const Progress& progress) {
    if (std::holds_alternative<std::monostate>(transfer_))
        return Error{"",
                     "found no transfer vectors for the current scene; expected a call that computes them "
                     "(vary_light, vary_eye, vary_instance) first"};
    if (std::holds_alternative<MotionTransfer>(transfer_)) geometry_->rays.place(scene_);
    if (const Result<Done> lamps = update_lamps(progress); !lamps) return lamps;
    if (const Result<Done> shaded = shaded_without_lamps(quality, vertices, progress); !shaded) return shaded;
    lamp_frames_.add_to(radiance_, vertices);
    add_to_radiance(lamps_bounced_, vertices);
    return Done{};
}

Result<Done> RelightSession::shaded_without_lamps(FrameQuality quality, const VertexMask* vertices,
                                                  const Progress& progress) {
    if (const auto* by_light = std::get_if<LightTransfer>(&transfer_)) {
        const Result<const DenseCoefficients*> now = light(progress);
        if (!now) return now.error();
        if (settings_.bounces.most == 0)
            return shade_frame(*by_light, scene_, *geometry_, **now, source_lights(quality), quality,
                               radiance_, progress);
        auto& radiance = scratch_.radiance;
        auto& direct = scratch_.direct;
        auto& irradiance = scratch_.irradiance;
        const Result<Done> shaded = shade_rows(*by_light, geometry_->rays, **now, source_lights(quality),
                                               quality, radiance, &direct, progress);
        if (!shaded) return shaded;
        direct = tinted_rows(scene_, VertexRows(scene_, *geometry_), std::move(direct));
        if (const Result<Done> found = find_irradiance(quality, progress); !found) return found;
        for_rows(radiance.size(), [&](std::size_t row) {
            const Rgb reflected = by_light->colours[by_light->colour_of_row[row]][0] * irradiance[row];
            radiance[row] = without_negative(radiance[row]) + reflected;
        });
        store_radiance(scene_, *geometry_, radiance, radiance_);
        return Done{};
    }
    if (const auto* by_eye = std::get_if<ViewTransfer>(&transfer_)) {
        const Result<Done> shaded = shade_frame(*by_eye, scene_, *geometry_, radiance_, vertices, progress);
        if (shaded) add_to_radiance(bounced_, vertices);
        return shaded;
    }
    if (const auto* by_motion = std::get_if<MotionTransfer>(&transfer_)) {
        const Result<Done> shaded =
            shade_frame(*by_motion, scene_, *geometry_, settings_, quality, radiance_, progress);
        if (shaded) add_to_radiance(bounced_, nullptr);
        return shaded;
    }
    radiance_ = std::get<SteadyLight>(transfer_).radiance;
    return Done{};
}

Result<SceneRadiance> RelightSession::full_radiance(const SceneLight& light, const Progress& progress) {
    const Result<const ShadingGeometry*> geometry = current_geometry(progress);
    if (!geometry) return geometry.error();
    if (progress.stop.stop_requested()) return Error{"", interrupted};
    if (!kept_ && settings_.kept_bytes > 0) {
        Result<KeptVisibility> made =
            KeptVisibility::make(scene_, **geometry, settings_.kept_bytes, progress);
        if (!made) return made.error();
        kept_ = std::move(*made);
    }
    PointShading shading{scene_, **geometry, light, settings_, kept_ ? &*kept_ : nullptr};
    if (settings_.bounces.most == 0) return scene_radiance(shading, progress);
    Result<RadianceParts> parts = radiance_parts(shading, progress);
    if (!parts) return parts.error();
    const Result<IndirectLight> indirect = indirect_at_rest(parts->diffuse, light, progress);
    if (!indirect) return indirect.error();
    if (light.lamps.empty() && light.emitters.empty())
        resting_ = radiance_by(row_values(VertexRows(scene_, **geometry), indirect->irradiance));
    shading.indirect = &*indirect;
    if (const Result<Done> added = add_indirect_radiance(shading, parts->full, progress); !added)
        return added.error();
    return std::move(parts->full);
}

Result<Done> RelightSession::commit(const Progress& progress) {
    Environment environment = shown_environment(progress.stop);
    Result<SceneRadiance> full =
        full_radiance(scene_light(scene_, environment, settings_, progress.stop), progress);
    if (!full) return full.error();
    scene_.environment = std::move(environment);
    keep(std::move(*full));
    return Done{};
}

void RelightSession::keep(SceneRadiance radiance) {
    radiance_.resize(radiance.size());
    for (std::size_t i = 0; i < radiance.size(); ++i)
        if (radiance_[i].size() == radiance[i].size())
            std::ranges::copy(radiance[i], radiance_[i].begin());
        else
            radiance_[i] = std::move(radiance[i]);
}

Result<const BounceRays*> RelightSession::current_rays(const Progress& progress) {
    if (!are_rays_current_) {
        Result<BounceRays> made =
            bounce_rays(scene_, *geometry_, settings_, progress, rays_ ? &*rays_ : nullptr);
        if (!made) return made.error();
        rays_ = std::move(*made);
        are_rays_current_ = true;
    }
    return &*rays_;
}

Result<IndirectLight> RelightSession::indirect_at_rest(const SceneRadiance& diffuse, const SceneLight& light,
                                                       const Progress& progress) {
    const Result<const BounceRays*> rays = current_rays(progress);
    if (!rays) return rays.error();
    return scene_indirect_light({scene_, *geometry_, light, settings_}, diffuse, **rays, progress);
}

BounceSettings RelightSession::frame_bounces() const {
    BounceSettings settings = settings_.bounces;
    settings.tolerance = std::max(settings.tolerance, frame_tolerance);
    return settings;
}

Result<SceneRadiance> RelightSession::bounced_radiance(const LightTransport& transport,
                                                       std::vector<Rgb> diffuse,
                                                       const BounceSettings& bounces,
                                                       const Progress& progress) const {
    const std::vector<Rgb> direct = tinted_rows(scene_, VertexRows(scene_, *geometry_), std::move(diffuse));
    Result<BouncedLight> bounced =
        bounced_light(transport, row_reflectances(scene_, *geometry_), direct, bounces, progress);
    if (!bounced) return bounced.error();
    transport.smooth(bounced->irradiance);
    return radiance_by(bounced->irradiance);
}

Result<Done> RelightSession::find_irradiance(FrameQuality quality, const Progress& progress) {
    auto& direct = scratch_.direct;
    auto& sent = scratch_.sent;
    auto& irradiance = scratch_.irradiance;
    const bool may_lag = quality == FrameQuality::moving && settings_.bounces.most == any_bounces;
    if (const double change = relative_change(direct, last_.direct); may_lag && change < leap) {
        sent.resize(direct.size());
        for_rows(sent.size(), [&](std::size_t row) {
            sent[row] = direct[row] + reflectances_[row] * last_.arriving[row];
        });
        if (change < step &&
            last_.frames > 0)  // before, all was gathered by rays that have been refined since
            refined_->update_irradiance(sent, last_.frames % 2, last_.arriving);
        else
            last_.arriving = refined_->irradiance(sent);
    } else {
        Result<BouncedLight> bounced =
            bounced_light(*refined_, reflectances_, direct, frame_bounces(), progress);
        if (!bounced) return bounced.error();
        last_.arriving = std::move(bounced->irradiance);
    }
    ++last_.frames;
    irradiance = last_.arriving;
    std::swap(last_.direct, direct);
    refined_->smooth(irradiance, frame_smoothing);
    return Done{};
}

Result<Done> RelightSession::update_lamps(const Progress& progress) {
    const bool bounces = settings_.bounces.most > 0;
    const Result<bool> differ = lamp_frames_.update(scene_, *geometry_, bounces, progress);
    if (!differ) return differ.error();
    if (!bounces) return Done{};
    is_lamps_bounced_current_ = is_lamps_bounced_current_ && !*differ;
    // While an instance moves, what bounced before stays until there are rays for where it stands.
    const bool moves = std::holds_alternative<MotionTransfer>(transfer_) && !are_rays_current_;
    if (is_lamps_bounced_current_ || moves) return Done{};
    SceneRadiance by_lamps;
    if (!lamp_frames_.is_dark()) {
        const Result<const BounceRays*> rays = current_rays(progress);
        if (!rays) return rays.error();
        const VertexRows rows(scene_, *geometry_);
        Result<SceneRadiance> bounced = bounced_radiance(
            (*rays)->transport, row_values(rows, lamp_frames_.diffuse(scene_)), frame_bounces(), progress);
        if (!bounced) return bounced.error();
        by_lamps = std::move(*bounced);
    }
    lamps_bounced_ = std::move(by_lamps);
    is_lamps_bounced_current_ = true;
    return Done{};
}

SceneRadiance RelightSession::radiance_by(std::span<const Rgb> irradiance) const {
    const VertexRows rows(scene_, *geometry_);
    std::vector<Rgb> outgoing(irradiance.begin(), irradiance.end());
    for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
        const ShadedEntity& entity = scene_.entities[scene_.instances[i].entity];
        const std::span<const std::uint32_t> vertices = rows.vertices(i);
        const std::span<Rgb> values = std::span(outgoing).subspan(rows.first(i), vertices.size());
        for_rows(values.size(), [&](std::size_t k) {
            values[k] *= entity.materials[entity.mesh->vertex_materials[vertices[k]]].diffuse *
                         static_cast<float>(1 / pi);
        });
    }
    SceneRadiance radiance;
    store_radiance(scene_, *geometry_, outgoing, radiance);
    return radiance;
}

void RelightSession::add_to_radiance(const SceneRadiance& part, const VertexMask* vertices) {
    for (std::size_t i = 0; i < part.size(); ++i)
        for_rows(part[i].size(), [&](std::size_t v) {
            if (!vertices || (*vertices)[i][v]) radiance_[i][v] += part[i][v];
        });
}

std::size_t RelightSession::transfer_bytes() const {
    return lamp_frames_.bytes() + std::visit(
                                      [](const auto& transfer) -> std::size_t {
                                          if constexpr (requires { transfer.bytes(); })
                                              return transfer.bytes();
                                          else
                                              return 0;
                                      },
                                      transfer_);
}

}  // namespace haarfield
