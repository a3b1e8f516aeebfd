#include "shading/scene/shared_shading.h"

#include <cassert>
#include <utility>

namespace haarfield {
namespace {

PointSharing& process_sharing() {
    static PointSharing sharing;
    return sharing;
}

bool& process_has_all() {
    static bool has_all = true;
    return has_all;
}

/// Calls `visit(number, instance, vertex)` for all in their order.
template <class Visit>
void visit_in_order(const ShadedScene& scene, std::span<const std::span<const std::uint32_t>> orders,
                    const Visit& visit) {
    std::size_t number = 0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        for (const std::uint32_t vertex : orders[scene.instances[i].entity]) visit(number++, i, vertex);
}

}  // namespace

SharedShading::SharedShading(PointSharing sharing, bool has_all) {
    assert(!process_sharing());
    process_sharing() = std::move(sharing);
    process_has_all() = has_all;
}

bool has_share_alone() {
    return process_sharing() && !process_has_all();
}

SharedShading::~SharedShading() {
    process_sharing() = {};
}

Result<Done> share_points(std::span<Rgb> radiance, const ShadeRange& shade) {
    const PointSharing& sharing = process_sharing();
    return sharing ? sharing(radiance, shade) : shade(0, radiance.size());
}

Result<Done> share_vertices(const ShadedScene& scene, std::span<const std::span<const std::uint32_t>> orders,
                            SceneRadiance& radiance,
                            const std::function<Result<Done>(const VertexMask* wanted)>& shade) {
    if (!process_sharing()) return shade(nullptr);
    std::size_t count = 0;
    for (const ShadedInstance& instance : scene.instances) count += orders[instance.entity].size();
    std::vector<Rgb> in_order(count, Rgb(0.0f));
    const auto shade_range = [&](std::size_t begin, std::size_t end) -> Result<Done> {
        VertexMask wanted;
        for (const std::vector<Rgb>& vertices : radiance) wanted.emplace_back(vertices.size(), 0);
        visit_in_order(scene, orders, [&](std::size_t number, std::size_t instance, std::uint32_t vertex) {
            wanted[instance][vertex] = number >= begin && number < end;
        });
        if (Result<Done> shaded = shade(&wanted); !shaded) return shaded;
        visit_in_order(scene, orders, [&](std::size_t number, std::size_t instance, std::uint32_t vertex) {
            if (wanted[instance][vertex] != 0) in_order[number] = radiance[instance][vertex];
        });
        return Done{};
    };
    if (Result<Done> shared = share_points(in_order, shade_range); !shared) return shared;
    visit_in_order(scene, orders, [&](std::size_t number, std::size_t instance, std::uint32_t vertex) {
        radiance[instance][vertex] = in_order[number];
    });
    return Done{};
}

}  // namespace haarfield
