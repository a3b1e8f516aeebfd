/// haarfield_counted_kernels KERNEL: runs one kernel for callgrind, which counts the instructions of
/// counted_kernel() alone. Prints how many product integrals that was.
///
/// The functions are made here, of half planes: counts shall change with the kernels, not with the meshes.

#include <fmt/format.h>

#include <string_view>

#include "fields/wavelets/haar_transform.h"
#include "shading/walk/product_integral.h"
#include "tests/baselines/product_methods.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield::baseline {
namespace {

constexpr int face_size = 64, factor_count = 5;
constexpr std::size_t vertex_count = 8;

/// As tree_integrals makes them: six functions, 200 wavelets a face in the lighting and 70 in the others.
TreeIntegrals half_plane_integrals() {
    TreeIntegrals integrals;
    integrals.face_size = face_size;
    std::vector<Rgb> light;
    for (std::uint32_t face = 0; face < cubemap_faces; ++face) {
        const std::vector<float> noise = reference::noise_texels(face, face_size * face_size),
                                 bright = reference::half_plane_texels(face, face_size);
        for (std::size_t i = 0; i < noise.size(); ++i)
            light.emplace_back(noise[i] + bright[i], noise[i], 2 * bright[i]);
    }
    integrals.light = haar_cubemap<Rgb>(light, face_size, {200});
    integrals.vertices.resize(vertex_count, std::vector<CubemapTree>(factor_count));
    std::uint32_t seed = 0;
    for (auto& vertex : integrals.vertices)
        for (CubemapTree& factor : vertex)
            for (Quadtree& face : factor.faces)
                face = haar_quadtree<float>(reference::half_plane_texels(seed++, face_size), face_size, {70});
    return integrals;
}

/// T = lighting times all factors, again in wavelets: what just-in-time radiance transfer is set up with.
Method function_product_method(const TreeIntegrals& trees) {
    Method method;
    method.evaluate =
        [light = std::make_shared<LightPyramid>(trees.light, face_size),
         vertices = std::make_shared<WideVertices>(trees), memory = std::make_shared<WalkMemory<float>>(),
         product = std::make_shared<std::vector<WaveletBlock<3>>>()](std::size_t first, std::span<Rgb>) {
            function_product(*light, vertices->factors()[first], full_depth, *memory, *product);
        };
    return method;
}

}  // namespace
}  // namespace haarfield::baseline

/// Known to callgrind by its name.
extern "C" [[gnu::noinline]] void counted_kernel(const haarfield::baseline::Method& method) {
    haarfield::baseline::evaluate_all(method, 0, haarfield::baseline::vertex_count,
                                      haarfield::baseline::DataPlace::memory);
}

int main(int argc, char** argv) {
    using namespace haarfield::baseline;
    const std::string_view kernel = argc == 2 ? argv[1] : "";
    const TreeIntegrals trees = half_plane_integrals();
    if (kernel == "product_integral")
        counted_kernel(haarfield_method(trees));
    else if (kernel == "function_product")
        counted_kernel(function_product_method(trees));
    else if (kernel == "paper")
        counted_kernel(paper_method(trees));
    else {
        fmt::print(stderr, "usage: haarfield_counted_kernels product_integral|function_product|paper\n");
        return 2;
    }
    fmt::print("{}\n", vertex_count);
    return 0;
}
