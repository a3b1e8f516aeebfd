#include "scenes/baked_instance.h"

namespace haarfield {

BakedInstance baked_instance(const Instance& instance, const SceneEntity& entity, const Mesh& mesh,
                             std::span<const Outgoing> radiance, SeenRadiance& layers) {
    if (!radiance.empty()) layers = seen_radiance(mesh, entity.surfaces, radiance);
    BakedInstance result{instance.name, &mesh, instance.placement, layers.under, layers.over};
    if (!all_plain(entity.surfaces)) result.surfaces = entity.surfaces;
    result.left_handed = entity.left_handed;
    return result;
}

Rgb seen_at(const BakedInstance& instance, std::size_t vertex) {
    if (instance.surfaces.empty()) return instance.radiance[vertex];
    const Texture* texture = instance.surfaces[instance.mesh->vertex_materials[vertex]].texture.get();
    if (!texture) return instance.radiance[vertex];
    const Rgb under = instance.radiance[vertex] * texture->colour_at(instance.mesh->uvs[vertex]);
    return instance.over.empty() ? under : under + instance.over[vertex];
}

}  // namespace haarfield
