#include "tests/baselines/product_methods.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>

#include "tests/baselines/dense_product.h"
#include "tests/baselines/harmonics_product.h"
#include "tests/baselines/pairwise_product.h"
#include "tests/baselines/scalar_product_integral.h"

namespace haarfield::baseline {
namespace {

using reference::AugmentedQuadtree;

/// One element per face.
template <class T>
using ByFace = std::array<T, cubemap_faces>;

/// Converts the trees of all vertices to a method's representation, by vertex, face and factor.
template <class Tree, class Conversion>
std::vector<ByFace<std::vector<Tree>>> converted(const TreeIntegrals& trees, const Conversion& conversion) {
    std::vector<ByFace<std::vector<Tree>>> result(trees.vertices.size());
    for (std::size_t v = 0; v < result.size(); ++v)
        for (std::size_t face = 0; face < cubemap_faces; ++face)
            for (const CubemapTree& factor : trees.vertices[v])
                result[v][face].push_back(conversion(factor.faces[face]));
    return result;
}

constexpr std::size_t most_factors = 16;

/// Pointers to converted trees, without allocation.
template <class Tree>
struct Pointers {
    std::array<const Tree*, most_factors> tree;
    std::size_t count = 0;

    void add(const Tree& added) { tree[count++] = &added; }
    std::span<const Tree* const> span() const { return {tree.data(), count}; }
};

Quadtree channel_of(const RgbQuadtree& light, int channel) {
    Quadtree tree{light.scaling[channel], {}};
    for (const RgbQuadtree::Node& node : light.nodes)
        tree.nodes.push_back(
            {{node.wavelet[0][channel], node.wavelet[1][channel], node.wavelet[2][channel]}, node.children});
    return tree;
}

/// Makes a method that processes one vertex at a time. radiance(data of the vertex) returns its radiance.
template <class Vertex, class Radiance>
Method method_by_vertex(std::string title, std::shared_ptr<const std::vector<Vertex>> vertices,
                        Radiance radiance) {
    Method method;
    method.title = std::move(title);
    method.evaluate = [vertices = std::move(vertices), radiance = std::move(radiance)](
                          std::size_t first, std::span<Rgb> result) {
        for (std::size_t i = 0; i < result.size(); ++i) result[i] = radiance((*vertices)[first + i]);
    };
    return method;
}

template <class Vertex, class Radiance>
Method method_by_vertex(std::string title, std::vector<Vertex> vertices, Radiance radiance) {
    return method_by_vertex(std::move(title),
                            std::make_shared<const std::vector<Vertex>>(std::move(vertices)),
                            std::move(radiance));
}

template <class Vertex, class Conversion, class Product>
Method dense(std::string title, const TexelIntegrals& texels, int functions, double tolerance,
             const Conversion& conversion, Product product) {
    std::vector<Vertex> vertices;
    for (const VertexTexels& vertex : texels.vertices)
        vertices.push_back(
            conversion(std::span(vertex.factors).first(static_cast<std::size_t>(functions - 1))));
    Method method = method_by_vertex(std::move(title), std::move(vertices),
                                     [light = std::make_shared<DenseLight>(dense_light(texels.light)),
                                      product](const Vertex& vertex) { return product(*light, vertex); });
    method.of_trees = false;
    method.tolerance = tolerance;
    return method;
}

}  // namespace

WideVertices::WideVertices(const TreeIntegrals& trees) {
    std::vector<std::size_t> root;
    for (const auto& factors : trees.vertices)
        for (const CubemapTree& factor : factors)
            for (const Quadtree& face : factor.faces) {
                root.push_back(nodes_.size());
                append_wide_nodes(face, nodes_);
            }
    root.push_back(nodes_.size());
    auto next = root.begin();
    for (const auto& factors : trees.vertices)
        for (const CubemapTree& factor : factors) {
            WideCubemap<float>& tree = trees_.emplace_back();
            for (std::size_t face = 0; face < cubemap_faces; ++face, ++next) {
                tree[face].mean = factor.faces[face].scaling;
                tree[face].nodes = static_cast<std::uint32_t>(next[1] - next[0]);
                if (tree[face].nodes > 0) tree[face].root = &nodes_[*next];
            }
        }
    for (const WideCubemap<float>& tree : trees_) parts_.push_back({&tree, 1});
    for (const auto& part : parts_) weighted_.push_back({0, {&part, 1}});
    std::size_t first = 0;
    for (const auto& factors : trees.vertices) {
        factors_.push_back(std::span(weighted_).subspan(first, factors.size()));
        first += factors.size();
    }
}

Method haarfield_method(const TreeIntegrals& trees, int depth) {
    Method method;
    method.title = "haarfield";
    method.evaluate = [light = std::make_shared<LightPyramid>(trees.light, trees.face_size),
                       vertices = std::make_shared<WideVertices>(trees),
                       memory = std::make_shared<WalkMemory<float>>(),
                       depth](std::size_t first, std::span<Rgb> radiance) {
        radiance[0] = product_integral(*light, vertices->factors()[first], depth, *memory);
    };
    return method;
}

Method haarfield_batch_method(const TreeIntegrals& trees) {
    Method method;
    method.title = "haarfield, many at a time";
    method.batch = largest_batch;
    method.evaluate = [light = std::make_shared<LightPyramid>(trees.light, trees.face_size),
                       vertices = std::make_shared<WideVertices>(trees),
                       memory = std::make_shared<WalkMemory<float>>()](std::size_t first,
                                                                       std::span<Rgb> radiance) {
        product_integrals(*light, vertices->factors().subspan(first, radiance.size()), full_depth, *memory,
                          radiance);
    };
    return method;
}

Method narrow_method(const TreeIntegrals& trees, int depth) {
    return method_by_vertex("haarfield, quadtrees as they are", trees.vertices,
                            [light = trees.light, depth](const std::vector<CubemapTree>& factors) {
                                Pointers<CubemapTree> pointers;
                                for (const CubemapTree& factor : factors) pointers.add(factor);
                                return reference::scalar_product_integral(light, pointers.span(), depth);
                            });
}

Method paper_method(const TreeIntegrals& trees, int depth, reference::PaperFold fold) {
    using Tree = AugmentedQuadtree<float>;
    ByFace<std::array<Tree, 3>> light;
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        for (std::size_t c = 0; c < 3; ++c)
            light[face][c] = reference::augmented_quadtree<float>(
                channel_of(trees.light.faces[face], static_cast<int>(c)));
    const reference::PaperVariant variant{.fold = fold, .depth = depth};
    return method_by_vertex(
        fold == reference::PaperFold::table ? "paper's algorithm" : "paper's algorithm, recursion of its 5.3",
        converted<Tree>(trees, reference::augmented_quadtree<float>),
        [light = std::move(light), variant](const ByFace<std::vector<Tree>>& factors) {
            Rgb sum(0.0f);
            for (std::size_t face = 0; face < cubemap_faces; ++face)
                for (std::size_t c = 0; c < 3; ++c) {
                    Pointers<Tree> pointers;
                    pointers.add(light[face][c]);
                    for (const Tree& factor : factors[face]) pointers.add(factor);
                    sum[static_cast<int>(c)] +=
                        reference::paper_product_integral<float>(pointers.span(), variant);
                }
            return sum;
        });
}

Method pairwise_method(const TreeIntegrals& trees) {
    return method_by_vertex("two functions at a time, Haar",
                            converted<LinkedQuadtree>(trees, linked_quadtree),
                            [light = trees.light, recursive = std::make_shared<RecursivePairwiseProduct>()](
                                const ByFace<std::vector<LinkedQuadtree>>& factors) {
                                Rgb sum(0.0f);
                                for (std::size_t face = 0; face < cubemap_faces; ++face) {
                                    Pointers<LinkedQuadtree> pointers;
                                    for (const LinkedQuadtree& factor : factors[face]) pointers.add(factor);
                                    sum += (*recursive)(light.faces[face], pointers.span());
                                }
                                return sum;
                            });
}

Method harmonics_method(const TexelIntegrals& texels, int functions, int order) {
    const HarmonicsProjection projection(order, texels.face_size);
    const std::size_t batches = (texels.vertices.size() + harmonics_batch - 1) / harmonics_batch;
    std::vector<std::vector<HarmonicsBatch>> data(batches);
    for (std::size_t v = 0; v < texels.vertices.size(); ++v) {
        auto& batch = data[v / harmonics_batch];
        batch.resize(static_cast<std::size_t>(functions - 1));
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const std::vector<float> coefficients = projection(texels.vertices[v].factors[i]);
            batch[i].resize(coefficients.size() * harmonics_batch);
            for (std::size_t k = 0; k < coefficients.size(); ++k)
                batch[i][k * harmonics_batch + v % harmonics_batch] = coefficients[k];
        }
    }
    Method method;
    method.title = "two functions at a time, harmonics of order " + std::to_string(order);
    method.of_trees = false;
    method.tolerance = INFINITY;
    static_assert(harmonics_batch <= largest_batch);
    method.batch = harmonics_batch;
    method.evaluate = [light = projection.of_light(texels.light),
                       data = std::make_shared<std::vector<std::vector<HarmonicsBatch>>>(std::move(data)),
                       recursive = std::make_shared<RecursiveHarmonicsProduct>(order)](
                          std::size_t first, std::span<Rgb> radiance) {
        (*recursive)(light, (*data)[first / harmonics_batch], radiance);
    };
    return method;
}

Method dense_scalar_method(const TexelIntegrals& texels, int functions) {
    return dense<DenseFloats>("texels, scalar", texels, functions, 1e-5, dense_floats, dense_product_scalar);
}

Method dense_method(const TexelIntegrals& texels, int functions) {
    return dense<DenseFloats>(
        "texels, vectors", texels, functions, 1e-5, dense_floats,
        [](const DenseLight& light, const DenseFloats& vertex) { return dense_product(light, vertex); });
}

Method dense_open_method(const TexelIntegrals& texels, int functions) {
    return dense<DenseFloats>("texels, vectors, open blocks", texels, functions, 1e-5, dense_floats,
                              dense_product_of_open);
}

Method dense_bytes_method(const TexelIntegrals& texels, int functions) {
    return dense<DenseBytes>(
        "texels, vectors, open blocks, 8 bits", texels, functions, 5e-3, dense_bytes,
        [](const DenseLight& light, const DenseBytes& vertex) { return dense_product(light, vertex); });
}

Method dense_bits_method(const TexelIntegrals& texels, int functions) {
    return dense<DenseBits>(
        "texels, vectors, open blocks, 1 bit", texels, functions, 0.2, dense_bits,
        [](const DenseLight& light, const DenseBits& vertex) { return dense_product(light, vertex); });
}

std::span<const NamedMethod> all_methods() {
    static constexpr NamedMethod methods[] = {
        {"haarfield", [](const MethodInputs& of) { return haarfield_method(of.trees); }},
        {"haarfield_batch", [](const MethodInputs& of) { return haarfield_batch_method(of.trees); }},
        {"narrow", [](const MethodInputs& of) { return narrow_method(of.trees); }},
        {"paper", [](const MethodInputs& of) { return paper_method(of.trees); }},
        {"paper_recursion",
         [](const MethodInputs& of) {
             return paper_method(of.trees, full_depth, reference::PaperFold::recursion);
         }},
        {"pairwise_haar", [](const MethodInputs& of) { return pairwise_method(of.trees); }},
        {"harmonics_5", [](const MethodInputs& of) { return harmonics_method(of.texels, of.functions, 5); }},
        {"harmonics_10",
         [](const MethodInputs& of) { return harmonics_method(of.texels, of.functions, 10); }},
        {"dense_scalar", [](const MethodInputs& of) { return dense_scalar_method(of.texels, of.functions); }},
        {"dense", [](const MethodInputs& of) { return dense_method(of.texels, of.functions); }},
        {"dense_open", [](const MethodInputs& of) { return dense_open_method(of.texels, of.functions); }},
        {"dense_bytes", [](const MethodInputs& of) { return dense_bytes_method(of.texels, of.functions); }},
        {"dense_bits", [](const MethodInputs& of) { return dense_bits_method(of.texels, of.functions); }},
    };
    return methods;
}

std::vector<Rgb> radiance_by(const Method& method, std::size_t count) {
    std::vector<Rgb> radiance(count);
    for (std::size_t first = 0; first < count; first += method.batch)
        method.evaluate(first, std::span(radiance).subspan(first, std::min(method.batch, count - first)));
    return radiance;
}

std::size_t evaluate_all(const Method& method, std::size_t first, std::size_t count, DataPlace place) {
    const int repeats = place == DataPlace::cache ? cache_repeats : 1;
    std::array<Rgb, largest_batch> radiance;
    for (std::size_t end = first + count; first < end; first += method.batch)
        for (int repeat = 0; repeat < repeats; ++repeat) {
            method.evaluate(first, std::span(radiance).first(std::min(method.batch, end - first)));
            asm volatile("" : : "r"(radiance.data()) : "memory");  // prevents elimination of the result
        }
    return count * static_cast<std::size_t>(repeats);
}

double thread_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

std::vector<double> least_microseconds(std::span<const Method> methods, std::size_t count, DataPlace place,
                                       int rounds) {
    // Before timing, this number of vertices loads shared data into the cache.
    const std::size_t shared = largest_batch < count ? largest_batch : 0;
    std::vector<double> least(methods.size(), INFINITY);
    for (int round = 0; round < rounds; ++round)
        for (std::size_t i = 0; i < methods.size(); ++i) {
            evaluate_all(methods[i], 0, shared, DataPlace::memory);
            const double start = thread_seconds();
            const std::size_t evaluated = evaluate_all(methods[i], shared, count - shared, place);
            least[i] = std::min(least[i], 1e6 * (thread_seconds() - start) / double(evaluated));
        }
    return least;
}

}  // namespace haarfield::baseline
