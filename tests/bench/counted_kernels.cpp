/// haarfield_counted_kernels KERNEL: verifies a kernel, then runs it for callgrind, which counts only the
/// instructions of counted_kernel(). Prints the number of vertices. Without KERNEL: prints the names of all
/// kernels.
///
/// Functions and meshes are generated here, so that counts change with the kernels only, not with the shipped
/// scenes.

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <string_view>

#include "fields/wavelets/haar_transform.h"
#include "shading/walk/product_integral.h"
#include "tests/baselines/product_methods.h"
#include "tests/bench/shipped_kernels.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield::baseline {
namespace {

constexpr int face_size = 64, factor_count = 5;
constexpr std::size_t vertex_count = 8;

/// Functions like those of tree_integrals: six, with 200 wavelets per face in the lighting and 70 in the
/// others.
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

const TreeIntegrals& integrals() {
    static const TreeIntegrals made = half_plane_integrals();
    return made;
}

double error_of(std::span<const Rgb> found) {
    return relative_rmse(found, texel_sums(integrals()));
}

/// A method for product integrals. `of` creates it on first use.
template <class Make>
bench::ShippedKernel product_integral_kernel(const char* name, const Make& of) {
    const auto method = [of]() -> const Method& {
        static const Method made = of();
        return made;
    };
    return {name, [method] { evaluate_all(method(), 0, vertex_count, DataPlace::memory); },
            [] { return vertex_count; }, [method] { return error_of(radiance_by(method(), vertex_count)); },
            1e-5};
}

/// T = lighting times all factors, as wavelets.
class FunctionProducts {
public:
    void multiply() {
        for (std::size_t vertex = 0; vertex < vertex_count; ++vertex) multiply(vertex);
    }
    double error() {
        std::vector<Rgb> integrals(vertex_count, Rgb(0.0f));
        for (std::size_t vertex = 0; vertex < vertex_count; ++vertex) {
            multiply(vertex);
            integrals[vertex] = bench::integral_of(product_);
        }
        return error_of(integrals);
    }

private:
    void multiply(std::size_t vertex) {
        function_product(light_, vertices_.factors()[vertex], full_depth, memory_, product_);
    }

    LightPyramid light_{integrals().light, face_size};
    WideVertices vertices_{integrals()};
    WalkMemory<float> memory_;
    std::vector<WaveletBlock<3>> product_;
};

FunctionProducts& function_products() {
    static FunctionProducts made;
    return made;
}

std::vector<bench::ShippedKernel> counted_kernels() {
    std::vector<bench::ShippedKernel> kernels = bench::shipped_kernels();
    kernels.push_back(
        product_integral_kernel("product_integral", [] { return haarfield_method(integrals()); }));
    kernels.push_back({"function_product", [] { function_products().multiply(); },
                       [] { return vertex_count; }, [] { return function_products().error(); }, 1e-5});
    kernels.push_back(product_integral_kernel("paper", [] { return paper_method(integrals()); }));
    return kernels;
}

}  // namespace
}  // namespace haarfield::baseline

/// callgrind identifies it by name.
extern "C" [[gnu::noinline]] void counted_kernel(const haarfield::bench::ShippedKernel& kernel) {
    kernel.run();
}

int main(int argc, char** argv) {
    using haarfield::bench::ShippedKernel;
    const std::vector<ShippedKernel> kernels = haarfield::baseline::counted_kernels();
    if (argc == 1)
        for (const ShippedKernel& kernel : kernels) fmt::print("{}\n", kernel.name);
    if (argc == 1) return 0;
    const auto kernel = std::ranges::find(kernels, std::string_view(argv[1]), &ShippedKernel::name);
    if (argc != 2 || kernel == kernels.end()) {
        fmt::print(stderr, "usage: haarfield_counted_kernels [KERNEL]\n");
        return 2;
    }
    // Runs only in this thread, whose instructions are counted.
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    const double error = kernel->error();
    if (!(error < kernel->tolerance)) {
        fmt::print(stderr, "wrong answer, so not counted: relative RMSE {}, expected < {}\n", error,
                   kernel->tolerance);
        return 1;
    }
    counted_kernel(*kernel);
    fmt::print("{}\n", kernel->vertices());
    return 0;
}
