#include "scenes/baked_instance.h"

namespace haarfield {

Rgb seen_at(const BakedInstance& instance, std::size_t vertex) {
    if (instance.surfaces.empty()) return instance.radiance[vertex];
    const Texture* texture = instance.surfaces[instance.mesh->vertex_materials[vertex]].texture.get();
    if (!texture) return instance.radiance[vertex];
    const Rgb under = instance.radiance[vertex] * texture->colour_at(instance.mesh->uvs[vertex]);
    return instance.over.empty() ? under : under + instance.over[vertex];
}

}  // namespace haarfield
