#include "shading/scene/shared_shading.h"

#include <algorithm>

namespace haarfield {
namespace {

/// Numbers of the vertices of a scene.
class VertexNumbers {
public:
    VertexNumbers(const ShadedScene& scene, std::span<const std::span<const std::uint32_t>> orders)
        : scene_(scene), orders_(orders) {
        for (const ShadedInstance& instance : scene.instances)
            first_.push_back(first_.back() + orders[instance.entity].size());
    }
    std::size_t count() const { return first_.back(); }

    /// Calls `visit(instance, vertices)` for runs of the vertices with numbers in [begin, end).
    template <class Visit>
    void visit(std::size_t begin, std::size_t end, const Visit& visit) const {
        auto instance =
            static_cast<std::size_t>(std::ranges::upper_bound(first_, begin) - first_.begin()) - 1;
        for (; begin < end; ++instance) {
            const std::size_t stop = std::min(end, first_[instance + 1]);
            visit(instance,
                  orders_[scene_.instances[instance].entity].subspan(begin - first_[instance], stop - begin));
            begin = stop;
        }
    }

private:
    const ShadedScene& scene_;
    std::span<const std::span<const std::uint32_t>> orders_;
    std::vector<std::size_t> first_{0};  // by instance; the last value is the count
};

}  // namespace

Result<Done> share_points(const PointSharing* sharing, std::span<Outgoing> radiance,
                          const std::function<Result<Done>(std::size_t begin, std::size_t end)>& shade) {
    if (!sharing) return shade(0, radiance.size());
    return sharing->run({radiance.size(),
                         [&](std::size_t begin, std::size_t end) -> Result<std::vector<Outgoing>> {
                             HF_TRY_DONE(shade(begin, end));
                             const std::span<const Outgoing> made = radiance.subspan(begin, end - begin);
                             return std::vector<Outgoing>(made.begin(), made.end());
                         },
                         [&](std::size_t begin, std::span<const Outgoing> values) {
                             std::ranges::copy(values, radiance.subspan(begin).begin());
                         }});
}

Result<Done> share_vertices(const PointSharing* sharing, const ShadedScene& scene,
                            std::span<const std::span<const std::uint32_t>> orders, SceneRadiance& radiance,
                            const std::function<Result<Done>(const VertexMask* wanted)>& shade) {
    radiance.resize(scene.instances.size());
    const auto make_room = [&](std::size_t instance) {
        const std::size_t vertices = scene.entities[scene.instances[instance].entity].mesh->positions.size();
        if (radiance[instance].size() != vertices) radiance[instance].assign(vertices, Outgoing());
    };
    if (!sharing) {
        for (std::size_t i = 0; i < radiance.size(); ++i) make_room(i);
        return shade(nullptr);
    }
    const VertexNumbers numbers(scene, orders);
    return sharing->run(
        {numbers.count(),
         [&](std::size_t begin, std::size_t end) -> Result<std::vector<Outgoing>> {
             VertexMask wanted(scene.instances.size());
             numbers.visit(begin, end, [&](std::size_t instance, std::span<const std::uint32_t> vertices) {
                 make_room(instance);
                 wanted[instance].resize(radiance[instance].size(), 0);
                 for (const std::uint32_t vertex : vertices) wanted[instance][vertex] = 1;
             });
             HF_TRY_DONE(shade(&wanted));
             std::vector<Outgoing> made;
             made.reserve(end - begin);
             numbers.visit(begin, end, [&](std::size_t instance, std::span<const std::uint32_t> vertices) {
                 for (const std::uint32_t vertex : vertices) made.push_back(radiance[instance][vertex]);
             });
             return made;
         },
         [&](std::size_t begin, std::span<const Outgoing> values) {
             numbers.visit(begin, begin + values.size(),
                           [&](std::size_t instance, std::span<const std::uint32_t> vertices) {
                               make_room(instance);
                               for (const std::uint32_t vertex : vertices) {
                                   radiance[instance][vertex] = values.front();
                                   values = values.subspan(1);
                               }
                           });
         }});
}

Result<Done> visit_wanted_runs(const ShadedScene& scene,
                               std::span<const std::span<const std::uint32_t>> orders,
                               const VertexMask* wanted,
                               const std::function<VertexRunVisitor()>& make_visitor, std::string_view stage,
                               const Progress& progress) {
    if (!wanted) return visit_vertex_runs(scene, orders, make_visitor, stage, progress);
    ShadedScene some{scene.entities, {}, {}, scene.eye};
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        if ((*wanted)[i].empty()) continue;
        some.instances.push_back(scene.instances[i]);
        numbers.push_back(i);
    }
    return visit_vertex_runs(
        some, orders,
        [&]() -> VertexRunVisitor {
            return [&, visit = make_visitor()](std::size_t instance,
                                               std::span<const std::uint32_t> vertices) {
                const std::vector<std::uint8_t>& mask = (*wanted)[numbers[instance]];
                if (std::ranges::any_of(vertices, [&](std::uint32_t vertex) { return mask[vertex] != 0; }))
                    visit(numbers[instance], vertices);
            };
        },
        stage, progress);
}

}  // namespace haarfield
