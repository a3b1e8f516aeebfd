#include "tools/view/live_scene.h"

#include "scenes/scene_shading.h"
#include "tools/view/seen_vertices.h"

#include <Imath/half.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

namespace haarfield {
namespace {

constexpr float largest_half = 65000;

float share_of(const Design& design) {
    return design.scene.environment.blend ? design.scene.environment.blend->share : 0;
}

/// Whether the designs have the same objects in the same places, but for where `free` is and how large.
bool same_objects(const Design& a, const Design& b, std::uint32_t free = 0) {
    if (a.ids != b.ids || a.entities != b.entities) return false;
    for (std::size_t i = 0; i < a.ids.size(); ++i) {
        const Placement &one = a.scene.instances[i].placement, &other = b.scene.instances[i].placement;
        if (a.ids[i] == free ? one.rotate != other.rotate : one != other) return false;
    }
    return true;
}

bool same_light(const Design& a, const Design& b) {
    return a.light_stamp == b.light_stamp && share_of(a) == share_of(b) &&
           a.scene.environment.turn == b.scene.environment.turn;
}

bool same_eye(const Design& a, const Design& b) {
    return a.scene.camera.position == b.scene.camera.position;
}

/// Half floats of some vertices' colours; all, if none are chosen.
void store_halves(std::span<const Rgb> colours, float gain, const std::vector<std::uint8_t>* chosen,
                  std::vector<std::uint16_t>& halves) {
    constexpr std::size_t grain = 16384;
    if (halves.size() != 3 * colours.size()) {
        halves.assign(3 * colours.size(), 0);
        chosen = nullptr;
    }
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, colours.size(), grain), [&](const auto& range) {
        for (std::size_t v = range.begin(); v < range.end(); ++v) {
            if (chosen && !(*chosen)[v]) continue;
            for (int c = 0; c < 3; ++c)
                halves[3 * v + std::size_t(c)] =
                    imath_float_to_half(std::min(colours[v][c] * gain, largest_half));
        }
    });
}

std::vector<Rgb> colours_of(std::span<const std::uint16_t> halves) {
    std::vector<Rgb> colours(halves.size() / 3);
    for (std::size_t v = 0; v < colours.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) colours[v][int(c)] = imath_half_to_float(halves[3 * v + c]);
    return colours;
}

}  // namespace

LiveScene::LiveScene(const Scene& scene, SceneEntities entities, const RenderSettings& settings,
                     const TransferSettings& transfer)
    : entities_(std::make_unique<SceneEntities>(std::move(entities))),
      described_by_(entities_->entities.size()),
      transfer_settings_(transfer),
      lights_(settings) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        described_by_[entities_->entity_of_instance[i]] = scene.instances[i].entity;
    for (const auto& entity : entities_->entities) file_surfaces_.push_back(entity->surfaces);
    exact_.settings = quick_.settings = settings;
    quick_.settings.occlusion = Occlusion::fields;
    quick_.settings.kept_bytes = 0;
}

Result<Done> LiveScene::take_light(const Design& design) {
    return lights_.take(design);
}

float LiveScene::exposure(const Design& design) const {
    return lights_.exposure(design);
}

void LiveScene::take_materials(const Design& design) {
    if (material_stamp_ == design.material_stamp) return;
    for (std::size_t e = 0; e < described_by_.size(); ++e) {
        SceneEntity& entity = *entities_->entities[e];
        const Entity& description = design.scene.entities[described_by_[e]];
        for (std::size_t m = 0; m < entity.surfaces.size(); ++m) {
            const auto named = description.materials.find(entity.mesh.fine.material_names[m]);
            const std::string& name =
                named != description.materials.end() ? named->second : description.material;
            Surface& surface = entity.surfaces[m];
            if (name.empty()) {
                surface = file_surfaces_[e][m];
                continue;
            }
            const SceneMaterial& material = design.scene.materials.at(name);
            surface.material = material;
            surface.emission = material.emission;
            surface.tinted_highlights =
                surface.texture && material.convention == LobeConvention::povray ? material.metallic : 0;
        }
        entity.materials = materials_of(entity.surfaces);
    }
    material_stamp_ = design.material_stamp;
}

bool LiveScene::has_emitters() const {
    return std::ranges::any_of(entities_->entities, [](const auto& entity) {
        return std::ranges::any_of(entity->surfaces, &Surface::glows);
    });
}

bool LiveScene::has_own_light(const Design& design) const {
    return !design.scene.lamps.empty() || has_emitters();
}

void LiveScene::open(Stage& stage, const Design& design) {
    entities_->entity_of_instance = design.entities;
    ShadedScene scene = shaded_scene(design.scene, *entities_, lights_.mixed(design));
    stage.ids = design.ids;
    scene.lamps = lamps_for(stage, design);
    for (ShadedEntity& entity : scene.entities)
        for (Emitter& emitter : entity.emitters) emitter.radiance *= 1 / stage.gain;
    stage.session.emplace(std::move(scene), *entities_, stage.settings, transfer_settings_);
    stage.light_stamp = design.light_stamp;
    stage.share = share_of(design);
    stage.turn = {};
    stage.has_mixture = false;
    stage.material_stamp = design.material_stamp;
}

void LiveScene::bring_objects(Stage& stage, const Design& design) {
    SeenSession& session = *stage.session;
    for (std::size_t i = stage.ids.size(); i-- > 0;)
        if (!place_of(design, stage.ids[i])) {
            session.remove(i);
            stage.ids.erase(stage.ids.begin() + static_cast<std::ptrdiff_t>(i));
        }
    for (std::size_t i = 0; i < design.ids.size(); ++i) {
        const Placement& placement = design.scene.instances[i].placement;
        const auto known = std::ranges::find(stage.ids, design.ids[i]);
        if (known == stage.ids.end()) {
            session.add({design.entities[i], placement});
            stage.ids.push_back(design.ids[i]);
        } else if (const auto at = static_cast<std::size_t>(known - stage.ids.begin());
                   session.instances()[at].placement != placement) {
            session.place(at, placement);
        }
    }
    // What they look like may have come back, and the exposure may have changed.
    session.set_lamps(lamps_for(stage, design));
}

std::vector<Lamp> LiveScene::lamps_for(const Stage& stage, const Design& design) const {
    std::vector<Lamp> lamps = lamps_of(design.scene.lamps);
    for (Lamp& lamp : lamps) {
        lamp.colour *= 1 / stage.gain;
        if (lamp.looks_like)
            lamp.looks_like = static_cast<std::size_t>(
                std::ranges::find(stage.ids, design.ids[*lamp.looks_like]) - stage.ids.begin());
    }
    return lamps;
}

void LiveScene::bring(Stage& stage, const Design& design, bool with_light) {
    stage.is_touched = true;
    take_materials(design);
    if (stage.session && stage.material_stamp != design.material_stamp) {
        if (!stage.session->set_materials(*entities_)) stage.session.reset();
        stage.material_stamp = design.material_stamp;
    }
    const float gain = std::exp2(exposure(design));
    // What glows is divided by the gain as a scene is opened.
    if (has_emitters() && stage.gain != gain) stage.session.reset();
    stage.gain = gain;
    if (!stage.session) open(stage, design);
    bring_objects(stage, design);
    SeenSession& session = *stage.session;
    if (session.eye() != design.scene.camera.position) session.set_eye(design.scene.camera.position);
    if (!with_light) return;
    const float share = share_of(design);
    if (stage.light_stamp != design.light_stamp || stage.share != share) {
        session.set_environment(lights_.mixed(design));
        stage.light_stamp = design.light_stamp;
        stage.share = share;
        stage.turn = {};
        stage.has_mixture = false;
    }
    if (stage.has_mixture || stage.turn != design.scene.environment.turn) {
        session.turn_environment(design.scene.environment.turn);
        stage.turn = design.scene.environment.turn;
        stage.has_mixture = false;
    }
}

void LiveScene::show_light(const Design& design, FrameQuality quality) {
    const MomentaryLight light = lights_.momentary(design, quality == FrameQuality::moving);
    quick_.session->show_light(light.smooth, light.lights);
    quick_.has_mixture = true;
}

bool LiveScene::follows(const Design& design, const Variation& variation) const {
    if (variation.of == Variation::Of::nothing || varied_ != variation || !varied_of_) return false;
    const Design& of = *varied_of_;
    const bool by_light = variation.of == Variation::Of::light, by_eye = variation.of == Variation::Of::eye,
               by_object = variation.of == Variation::Of::object;
    const bool same_emitters = !has_emitters() || exposure(of) == exposure(design);
    return of.material_stamp == design.material_stamp && of.lamp_stamp == design.lamp_stamp &&
           same_emitters && (by_light || same_light(of, design)) && (by_eye || same_eye(of, design)) &&
           same_objects(of, design, by_object ? variation.object : 0);
}

Result<Done> LiveScene::vary(const Design& design, const Variation& variation, const Progress& progress) {
    varied_ = {};
    is_whole_ = false;
    const bool by_light = variation.of == Variation::Of::light;
    bring(quick_, design, !by_light);
    if (by_light) show_light(design, FrameQuality::still);
    SeenSession& session = *quick_.session;
    Result<Done> done = Done{};
    if (by_light) {
        done = session.vary_light(progress);
    } else if (variation.of == Variation::Of::eye) {
        done = session.vary_eye(progress);
    } else {
        const auto known = std::ranges::find(quick_.ids, variation.object);
        assert(known != quick_.ids.end());
        // While it moves, what bounces stays as it was at rest.
        if (committed_ && committed_->material_stamp == design.material_stamp &&
            same_light(*committed_, design) && same_objects(*committed_, design, variation.object) &&
            quick_.ids == exact_.ids)
            session.rest_as(*exact_.session);
        done = session.vary_instance(static_cast<std::size_t>(known - quick_.ids.begin()), progress);
    }
    if (!done) return done;
    varied_ = variation;
    varied_of_ = design;
    return Done{};
}

Result<Done> LiveScene::show(const Design& design, const Camera& window, FrameQuality quality,
                             const Progress& progress) {
    assert(follows(design, varied_));
    const bool by_light = varied_.of == Variation::Of::light;
    bring(quick_, design, !by_light);
    if (by_light) show_light(design, quality);
    if (varied_.of == Variation::Of::eye && is_whole_) {
        const VertexMask seen = seen_vertices(design, window, *entities_, quick_.ids);
        if (const Result<Done> done = quick_.session->frame_of(seen, quality, progress); !done) return done;
        take_colours(quick_, design, &seen);
        return Done{};
    }
    if (const Result<Done> done = quick_.session->frame(quality, progress); !done) return done;
    take_colours(quick_, design);
    is_whole_ = true;
    return Done{};
}

Result<Done> LiveScene::shade(const Design& design, const Progress& progress) {
    varied_ = {};
    bring(quick_, design, true);
    if (const Result<Done> done = quick_.session->commit(progress); !done) return done;
    take_colours(quick_, design);
    return Done{};
}

Result<Done> LiveScene::commit(const Design& design, const Progress& progress) {
    committed_.reset();
    bring(exact_, design, true);
    if (const Result<Done> done = exact_.session->commit(progress); !done) return done;
    committed_ = design;
    is_whole_ = false;
    take_colours(exact_, design);
    return Done{};
}

bool LiveScene::commits_fast(const Design& design) const {
    return committed_ && same_objects(*committed_, design) && committed_->light_stamp == design.light_stamp &&
           share_of(*committed_) == share_of(design);
}

void LiveScene::expose(const Design& design) {
    if (last_) take_colours(*last_, design);
}

void LiveScene::take_colours(Stage& stage, const Design& design, const VertexMask* chosen) {
    last_ = &stage;
    stage.is_touched = false;
    const float gain = std::exp2(exposure(design));
    const SceneColours& radiance = stage.session->radiance();
    std::erase_if(colours_, [&](const auto& known) {
        return std::ranges::find(stage.ids, known.first) == stage.ids.end();
    });
    for (std::size_t i = 0; i < stage.ids.size() && i < radiance.size(); ++i) {
        VertexColours& colours = colours_[stage.ids[i]];
        const SceneEntity& entity = *entities_->entities[stage.session->instances()[i].entity];
        const std::vector<std::uint8_t>* mask = chosen ? &(*chosen)[i] : nullptr;
        if (all_plain(entity.surfaces)) {
            store_halves(radiance[i], gain, mask, colours.under);
            colours.over.clear();
            continue;
        }
        std::vector<Outgoing> all = stage.session->outgoing(i);
        for (Outgoing& value : all) value = value * gain;
        const SeenRadiance seen = seen_radiance(entity.mesh.fine, entity.surfaces, all);
        store_halves(seen.under, 1, mask, colours.under);
        if (seen.over.empty())
            colours.over.clear();
        else
            store_halves(seen.over, 1, mask, colours.over);
    }
}

Image LiveScene::picture(const Design& design, Preview& preview) {
    std::vector<BakedInstance> instances;
    std::vector<std::vector<Rgb>> under, over;
    for (const std::uint32_t id : design.ids) {
        const auto known = colours_.find(id);
        assert(known != colours_.end());
        under.push_back(colours_of(known->second.under));
        over.push_back(colours_of(known->second.over));
    }
    for (std::size_t i = 0; i < design.ids.size(); ++i) {
        const SceneEntity& entity = *entities_->entities[design.entities[i]];
        BakedInstance& added = instances.emplace_back(
            BakedInstance{"", &entity.mesh.fine, design.scene.instances[i].placement, under[i]});
        if (all_plain(entity.surfaces)) continue;
        added.over = over[i];
        added.surfaces = entity.surfaces;
    }
    const LatLongImage behind = image_with_suns(lights_.mixed(design));
    const Rotation back = design.scene.environment.turn.inverse();
    const float gain = std::exp2(exposure(design));
    return preview.draw(design.scene.camera, instances, [&](const Vec3f& direction) {
        return radiance_from(behind, back(Vec3d(direction))) * gain;
    });
}

}  // namespace haarfield
