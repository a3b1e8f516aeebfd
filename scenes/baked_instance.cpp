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

namespace {

const Texture* texture_at(const BakedInstance& instance, std::size_t vertex) {
    if (instance.surfaces.empty()) return nullptr;
    return instance.surfaces[instance.mesh->vertex_materials[vertex]].texture.get();
}

}  // namespace

const Texture* texture_of(const BakedInstance& instance, const std::array<std::uint32_t, 3>& triangle) {
    return texture_at(instance, triangle[0]);
}

Rgb displayed_radiance(const BakedInstance& instance, std::size_t vertex) {
    const Texture* texture = texture_at(instance, vertex);
    if (!texture) return instance.radiance[vertex];
    const Rgb textured = instance.radiance[vertex] * texture->colour_at(instance.mesh->uvs[vertex]);
    return instance.added.empty() ? textured : textured + instance.added[vertex];
}

}  // namespace haarfield
