#include "tools/view/live_scene.h"

#include "scenes/entity_surfaces.h"
#include "scenes/scene_shading.h"
#include "tools/session_error.h"
#include "tools/view/message_writer.h"
#include "tools/view/visible_vertices.h"

#include <Imath/half.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

namespace haarfield {
namespace {

/// Stores the colours of chosen vertices, or of all if `chosen` is null, as half floats.
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
            for (int c = 0; c < 3; ++c) halves[3 * v + std::size_t(c)] = half_bits(colours[v][c] * gain);
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
      emitters_(entities_->entities.size()),
      settings_(settings),
      transfer_settings_(transfer),
      lights_(settings) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        described_by_[entities_->entity_of_instance[i]] = scene.instances[i].entity;
    for (const auto& entity : entities_->entities) file_surfaces_.push_back(entity->surfaces);
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
        entity.surfaces = with_scene_materials(design.scene, design.scene.entities[described_by_[e]],
                                               entity.mesh.fine.material_names, file_surfaces_[e]);
        entity.materials = materials_of(entity.surfaces);
        emitters_[e].clear();
        if (std::ranges::any_of(entity.surfaces, &Surface::emits))
            emitters_[e] = emitters_of(visible_surface(entity.mesh), entity.surfaces);
    }
    material_stamp_ = design.material_stamp;
}

bool LiveScene::has_emitters() const {
    return std::ranges::any_of(entities_->entities, [](const auto& entity) {
        return std::ranges::any_of(entity->surfaces, &Surface::emits);
    });
}

bool LiveScene::has_specular() const {
    return std::ranges::any_of(entities_->entities, [](const auto& entity) {
        return std::ranges::any_of(entity->materials,
                                   [](const Material& material) { return material.specular != Rgb(0.0f); });
    });
}

bool LiveScene::has_own_light(const Design& design) const {
    return !design.scene.lamps.empty() || has_emitters();
}

void LiveScene::bring_objects(const Design& design, const Variation& varying) {
    for (std::size_t i = ids_.size(); i-- > 0;)
        if (!place_of(design, ids_[i])) {
            session_->remove(i);
            ids_.erase(ids_.begin() + static_cast<std::ptrdiff_t>(i));
        }
    for (std::size_t i = 0; i < design.ids.size(); ++i) {
        const Placement& placement = design.scene.instances[i].placement;
        const auto known = std::ranges::find(ids_, design.ids[i]);
        const auto at = static_cast<std::size_t>(known - ids_.begin());
        if (known == ids_.end()) {
            session_->add(ShadedInstance{design.entities[i], placement});
            ids_.push_back(design.ids[i]);
        } else if (varying.of != Variation::Of::object || varying.object != design.ids[i] ||
                   session_->instances()[at].placement.rotate != placement.rotate) {
            session_->place(at, placement);
        }
    }
}

void LiveScene::bring_own_light(const Design& design) {
    const float gain = std::exp2(exposure(design));
    for (std::size_t e = 0; e < emitters_.size(); ++e) {
        std::vector<Emitter> emitters = emitters_[e];
        for (Emitter& emitter : emitters) emitter.radiance *= 1 / gain;
        session_->set_emitters(e, emitters);
    }
    std::vector<Lamp> lamps = lamps_of(design.scene.lamps);
    for (Lamp& lamp : lamps) {
        lamp.colour *= 1 / gain;
        if (lamp.looks_like)
            lamp.looks_like = static_cast<std::size_t>(std::ranges::find(ids_, design.ids[*lamp.looks_like]) -
                                                       ids_.begin());
    }
    session_->set_lamps(lamps);
}

void LiveScene::bring(const Design& design, const Variation& varying) {
    take_materials(design);
    const std::pair environment(design.light_stamp, second_share(design));
    if (!session_) {
        entities_->entity_of_instance = design.entities;
        session_.emplace(shaded_scene(design.scene, *entities_, lights_.mixed(design)), settings_,
                         transfer_settings_);
        ids_ = design.ids;
        environment_ = environment;
    }
    for (std::size_t e = 0; e < entities_->entities.size(); ++e)
        session_->set_materials(e, entities_->entities[e]->materials);
    session_->separate_components(has_separate_specular(*entities_));
    bring_objects(design, varying);
    bring_own_light(design);
    session_->set_eye(design.scene.camera.position);
    if (varying.of == Variation::Of::light) return;
    if (environment_ != environment) {
        session_->set_environment(lights_.mixed(design));
        environment_ = environment;
    }
    session_->turn_environment(design.scene.environment.turn);
}

void LiveScene::show_light(const Design& design, FrameQuality quality) {
    const GivenLight light = lights_.momentary(design, quality == FrameQuality::moving);
    session_->show_light(light.smooth, light.lights);
}

bool LiveScene::follows(const Design& design, const Variation& variation) const {
    if (varied_ != variation || !varied_of_ || !session_->has_vectors()) return false;
    const bool by_light = variation.of == Variation::Of::light, by_eye = variation.of == Variation::Of::eye;
    const DesignDifference found = difference(*varied_of_, design, variation.object);
    return !found.materials && !found.lamps && !found.objects && (by_eye || !found.eye) &&
           (by_light || !(found.environment || found.rotation));
}

Result<Done> LiveScene::vary(const Design& design, const Variation& variation, const Progress& progress) {
    varied_ = {};
    is_whole_ = false;
    // A varying object is moved later, because indirect light at rest is that of the last commit.
    bring(design, variation);
    session_->set_occlusion(Occlusion::fields);
    Result<Done> done = Done{};
    if (variation.of == Variation::Of::light) {
        show_light(design, FrameQuality::still);
        done = session_->vary_light(progress);
    } else if (variation.of == Variation::Of::eye) {
        done = session_->vary_eye(progress);
    } else {
        const auto known = std::ranges::find(ids_, variation.object);
        assert(known != ids_.end());
        done = session_->vary_instance(static_cast<std::size_t>(known - ids_.begin()), progress);
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
    bring(design, by_light ? varied_ : Variation());
    session_->set_occlusion(Occlusion::fields);
    if (by_light) show_light(design, quality);
    if (varied_.of == Variation::Of::eye && is_whole_) {
        const VertexMask visible = visible_vertices(design, window, *entities_, ids_);
        HF_TRY_DONE(session_->frame_of(visible, quality, progress));
        take_colours(design, &visible);
        return Done{};
    }
    HF_TRY_DONE(session_->frame(quality, progress));
    take_colours(design);
    is_whole_ = true;
    return Done{};
}

Result<Done> LiveScene::shade(const Design& design, const Progress& progress) {
    varied_ = {};
    bring(design, {});
    session_->set_occlusion(Occlusion::fields);
    HF_TRY_DONE(session_->commit(progress));
    take_colours(design);
    return Done{};
}

Result<Done> LiveScene::commit(const Design& design, const Progress& progress) {
    committed_.reset();
    bring(design, {});
    session_->set_occlusion(settings_.occlusion);
    HF_TRY_DONE(session_->commit(progress));
    committed_ = design;
    is_whole_ = false;
    take_colours(design);
    return Done{};
}

Result<BakeError> LiveScene::error(const Design& design, const Camera& window, Preview& preview,
                                   const Progress& progress) {
    bring(design, {});
    session_->set_occlusion(settings_.occlusion);
    return session_error(*session_, *entities_, window, preview, progress);
}

bool LiveScene::commits_fast(const Design& design) const {
    if (!committed_) return false;
    const DesignDifference found = difference(*committed_, design);
    return !found.objects && !found.environment;
}

void LiveScene::expose(const Design& design) {
    if (session_) take_colours(design);
}

void LiveScene::take_colours(const Design& design, const VertexMask* chosen) {
    shown_ids_ = ids_;
    const float gain = std::exp2(exposure(design));
    const SceneColours& radiance = session_->radiance();
    std::erase_if(colours_,
                  [&](const auto& known) { return std::ranges::find(ids_, known.first) == ids_.end(); });
    for (std::size_t i = 0; i < ids_.size() && i < radiance.size(); ++i) {
        VertexColours& colours = colours_[ids_[i]];
        const SceneEntity& entity = *entities_->entities[session_->instances()[i].entity];
        const std::vector<std::uint8_t>* mask = chosen ? &(*chosen)[i] : nullptr;
        if (all_plain(entity.surfaces)) {
            store_halves(radiance[i], gain, mask, colours.textured);
            colours.added.clear();
            continue;
        }
        std::vector<Outgoing> all = session_->outgoing(i);
        for (Outgoing& value : all) value = value * gain;
        const LayeredRadiance layered = layered_radiance(entity.mesh.fine, entity.surfaces, all);
        store_halves(layered.textured, 1, mask, colours.textured);
        if (layered.added.empty())
            colours.added.clear();
        else
            store_halves(layered.added, 1, mask, colours.added);
    }
}

Image LiveScene::picture(const Design& design, Preview& preview) {
    std::vector<BakedInstance> instances;
    std::vector<std::vector<Rgb>> textured, added_light;
    for (const std::uint32_t id : design.ids) {
        const auto known = colours_.find(id);
        assert(known != colours_.end());
        textured.push_back(colours_of(known->second.textured));
        added_light.push_back(colours_of(known->second.added));
    }
    for (std::size_t i = 0; i < design.ids.size(); ++i) {
        const SceneEntity& entity = *entities_->entities[design.entities[i]];
        BakedInstance& added = instances.emplace_back(
            BakedInstance{"", &entity.mesh.fine, design.scene.instances[i].placement, textured[i]});
        if (all_plain(entity.surfaces)) continue;
        added.added = added_light[i];
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
