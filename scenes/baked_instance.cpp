#include "scenes/baked_instance.h"

namespace haarfield {

BakedInstance baked_instance(const Instance& instance, const SceneEntity& entity, const Mesh& mesh,
                             std::span<const Outgoing> radiance, LayeredRadiance& layers) {
    if (!radiance.empty()) layers = layered_radiance(mesh, entity.surfaces, radiance);
    BakedInstance result{instance.name, &mesh, instance.placement, layers.textured, layers.added};
    if (!all_plain(entity.surfaces) || any_reflects(entity.surfaces)) result.surfaces = entity.surfaces;
    result.left_handed = entity.left_handed;
    return result;
}

Rgb displayed_radiance(const BakedInstance& instance, std::size_t vertex) {
    if (instance.surfaces.empty()) return instance.radiance[vertex];
    const Texture* texture = instance.surfaces[instance.mesh->vertex_materials[vertex]].texture.get();
    if (!texture) return instance.radiance[vertex];
    const Rgb textured = instance.radiance[vertex] * texture->colour_at(instance.mesh->uvs[vertex]);
    return instance.added.empty() ? textured : textured + instance.added[vertex];
}

}  // namespace haarfield
