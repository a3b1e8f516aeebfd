#include "fields/field/entity_occlusion.h"

namespace haarfield {
namespace {

/// Tests whether the original mesh occludes the entity's own vertices: see EntityOcclusion::own.
bool owns_original(const Occluder& coarse, std::size_t original_triangles) {
    constexpr std::size_t largest_original = 100000;  // triangles
    const bool is_two_sided = coarse.one_sided() < coarse.triangles().size();
    const bool is_hardly_simplified = original_triangles <= 2 * coarse.triangles().size();
    return (is_two_sided || is_hardly_simplified) && original_triangles <= largest_original;
}

Occluder original_occluder(const Occluder& coarse, const Mesh& original) {
    OccluderTriangles triangles = occluder_triangles(original);
    const bool is_own = owns_original(coarse, triangles.triangles.size());
    return Occluder(std::move(triangles), is_own ? OccluderUse::rasterized : OccluderUse::inside_tests);
}

}  // namespace

EntityOcclusion::EntityOcclusion(const PreparedMesh& mesh, KnownOcclusion known, const std::stop_token& stop)
    : coarse_(make_occluder(mesh.coarse)),
      original_(original_occluder(coarse_, blocking_surface(mesh))),
      own_(owns_original(coarse_, original_.triangles().size()) ? original_ : coarse_),
      in_coarse_(coarse_),
      in_original_(original_),
      sampler_(original_, in_original_, own_),
      samples_(known.samples ? *std::move(known.samples) : local_samples(mesh.fine, sampler_, stop)),
      coarser_(std::move(known.coarser)) {}

const std::vector<CoarserMesh>& EntityOcclusion::coarser(const Progress& progress) const {
    constexpr std::size_t fewest_triangles = 1000;
    std::call_once(coarser_made_, [&] {
        if (coarser_) return;
        if (coarse_.triangles().size() < fewest_triangles) {
            coarser_.emplace();
            return;
        }
        Mesh mesh;
        mesh.positions = coarse_.positions();
        mesh.triangles = coarse_.triangles();
        coarser_ = coarser_meshes(mesh, progress);
    });
    return *coarser_;
}

}  // namespace haarfield
