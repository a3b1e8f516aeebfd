#include "fields/field/entity_occlusion.h"

namespace haarfield {
namespace {

const Occluder& own_occluder(const Occluder& coarse, const Occluder& original) {
    constexpr std::size_t largest_original = 100000;  // triangles
    const std::size_t triangles = original.triangles().size();
    const bool is_two_sided = coarse.one_sided() < coarse.triangles().size();
    const bool is_hardly_simplified = triangles <= 2 * coarse.triangles().size();
    return (is_two_sided || is_hardly_simplified) && triangles <= largest_original ? original : coarse;
}

}  // namespace

EntityOcclusion::EntityOcclusion(const PreparedMesh& mesh, const std::stop_token& stop)
    : coarse_(make_occluder(mesh.coarse)),
      original_(make_occluder(blocking_surface(mesh))),
      own_(own_occluder(coarse_, original_)),
      in_coarse_(coarse_),
      in_original_(original_),
      sampler_(original_, in_original_, own_),
      samples_(local_samples(mesh.fine, sampler_, stop)) {}

}  // namespace haarfield
