#include "shading/transfer/lamp_frames.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "shading/bake/emitter_light.h"
#include "shading/bake/lamp_light.h"
#include "shading/bake/renderer.h"
#include "shading/scene/scene_light.h"

namespace haarfield {
namespace {

Lamp in_white(Lamp lamp) {
    lamp.colour = Rgb(1.0f);
    return lamp;
}

}  // namespace

void LampFrames::forget() {
    lamps_.clear();
    emitters_.reset();
}

template <class Act>
void LampFrames::for_each_light(const Act& act) const {
    for (const Kept& kept : lamps_)
        if (kept.unit && kept.lamp.colour != Rgb(0.0f)) act(*kept.unit, kept.lamp.colour);
    if (emitters_ && !emitters_->empty()) act(*emitters_, Rgb(1.0f));
}

Result<bool> LampFrames::update(const ShadedScene& scene, const ShadingGeometry& geometry,
                                const Progress& progress) {
    const bool is_displayed_again = eye_ != scene.eye;
    bool differs = emitters_ == std::nullopt || lamps_.size() != scene.lamps.size();
    std::vector<Kept> lamps;
    std::vector<PlacedLamp> missing;
    std::vector<SceneRadiance> made;
    std::vector<std::size_t> made_of;
    for (const Lamp& lamp : scene.lamps) {
        const auto same = std::ranges::find_if(
            lamps_, [&](const Kept& kept) { return kept.unit && in_white(kept.lamp) == in_white(lamp); });
        differs = differs || lamps_[lamps.size()].lamp != lamp;
        lamps.push_back({lamp, nullptr});
        if (!is_displayed_again && same != lamps_.end()) {
            lamps.back().unit = same->unit;
        } else if (lamp.colour != Rgb(0.0f)) {
            missing.push_back({in_white(lamp), lamp_places(lamp.area)});
            made.push_back(black_vertices(scene));
            made_of.push_back(lamps.size() - 1);
        }
    }
    std::optional<SceneRadiance> emitters;
    EmitterTree tree;
    if (is_displayed_again || !emitters_) {
        tree = scene_emitters(scene);
        emitters = tree.empty() ? SceneRadiance() : black_vertices(scene);
    }
    if (!missing.empty() || !tree.empty()) {
        HF_TRY_DONE(visit_vertex_runs(
            scene, geometry.orders(),
            [&]() -> VertexRunVisitor {
                return [&, receivers = std::vector<ShadingPoint>(), found = std::vector<Outgoing>()](
                           std::size_t instance, std::span<const std::uint32_t> vertices) mutable {
                    if (progress.stop.stop_requested()) return;
                    receivers.clear();
                    for (const std::uint32_t vertex : vertices)
                        receivers.push_back(shading_point(scene, scene.instances[instance], vertex));
                    const auto store = [&](SceneRadiance& radiance) {
                        for (std::size_t k = 0; k < vertices.size(); ++k)
                            radiance[instance][vertices[k]] = std::exchange(found[k], {});
                    };
                    found.assign(vertices.size(), {});
                    for (std::size_t l = 0; l < missing.size(); ++l) {
                        add_lamp_light(geometry.rays, {&missing[l], 1}, receivers, found);
                        store(made[l]);
                    }
                    if (tree.empty()) return;
                    add_emitter_light(geometry.rays, tree, receivers, found);
                    store(*emitters);
                };
            },
            "lamps", progress));
    }
    const auto fill = [&](SceneRadiance& radiance) {
        for (std::size_t i = 0; i < radiance.size(); ++i)
            geometry.entities[scene.instances[i].entity].fill(radiance[i]);
    };
    for (std::size_t l = 0; l < made.size(); ++l) {
        fill(made[l]);
        lamps[made_of[l]].unit = std::make_shared<const SceneRadiance>(std::move(made[l]));
    }
    if (emitters) {
        fill(*emitters);
        emitters_ = std::move(emitters);
    }
    lamps_ = std::move(lamps);
    eye_ = scene.eye;
    return differs;
}

bool LampFrames::is_dark() const {
    bool is_dark = true;
    for_each_light([&](const SceneRadiance&, const Rgb&) { is_dark = false; });
    return is_dark;
}

SceneColours LampFrames::diffuse(const ShadedScene& scene) const {
    SceneColours sum = diffuse_component(black_vertices(scene));
    for_each_light([&](const SceneRadiance& unit, const Rgb& colour) {
        for (std::size_t i = 0; i < sum.size(); ++i)
            for (std::size_t v = 0; v < sum[i].size(); ++v) sum[i][v] += unit[i][v].diffuse * colour;
    });
    return sum;
}

void LampFrames::add_to(SceneColours& radiance, SceneColours* diffuse, const VertexMask* vertices) const {
    std::vector<std::pair<const SceneRadiance*, Rgb>> units;
    for_each_light([&](const SceneRadiance& unit, const Rgb& colour) { units.emplace_back(&unit, colour); });
    if (units.empty()) return;
    for (std::size_t i = 0; i < radiance.size(); ++i)
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, radiance[i].size(), 1024),
                          [&](const tbb::blocked_range<std::size_t>& some) {
                              for (std::size_t v = some.begin(); v != some.end(); ++v) {
                                  if (vertices && !(*vertices)[i][v]) continue;
                                  for (const auto& [unit, colour] : units) {
                                      radiance[i][v] += (*unit)[i][v].total() * colour;
                                      if (diffuse) (*diffuse)[i][v] += (*unit)[i][v].diffuse * colour;
                                  }
                              }
                          });
}

std::size_t LampFrames::bytes() const {
    std::size_t sum = 0;
    const auto add = [&](const SceneRadiance& radiance) {
        for (const std::vector<Outgoing>& values : radiance) sum += values.size() * sizeof(Outgoing);
    };
    for (const Kept& kept : lamps_)
        if (kept.unit) add(*kept.unit);
    if (emitters_) add(*emitters_);
    return sum;
}

}  // namespace haarfield
