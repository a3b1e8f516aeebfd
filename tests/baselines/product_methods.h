#pragma once
/// A common interface to all methods for the product integrals of the shipped scene, to verify, time and
/// compare them.

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "shading/walk/product_integral.h"
#include "tests/baselines/paper_product_integral.h"
#include "tests/baselines/scene_integrals.h"

namespace haarfield::baseline {

/// The largest number of vertices that are evaluated together.
inline constexpr std::size_t largest_batch = 16;

struct Method {
    std::string title;
    bool of_trees = true;     ///< True if it multiplies the truncated trees, otherwise all texels.
    double tolerance = 1e-5;  ///< Allowed relative RMSE against the texel sums of its input.
    std::size_t batch = 1;    ///< Vertices per evaluation, up to largest_batch.

    /// Computes the radiance of vertices from `first` on, at most a batch.
    std::function<void(std::size_t first, std::span<Rgb> radiance)> evaluate;
};

/// The library's product integral: in wide nodes, one vertex or many at a time, and in quadtrees. depth: as
/// in the library.
Method haarfield_method(const TreeIntegrals& trees, int depth = 32);
Method haarfield_batch_method(const TreeIntegrals& trees);
Method narrow_method(const TreeIntegrals& trees, int depth = 32);

/// The paper's algorithm in float for each colour channel, with the table of section 5.4 or the recursion of
/// section 5.3. Line 9 is corrected (PaperCumulation), because the printed one gives different results.
Method paper_method(const TreeIntegrals& trees, int depth = full_depth,
                    reference::PaperFold fold = reference::PaperFold::table);

/// Products of two functions at a time, in trees and in spherical harmonics. The latter have no tolerance.
Method pairwise_method(const TreeIntegrals& trees);
Method harmonics_method(const TexelIntegrals& texels, int functions, int order);

/// Pixel domain; see dense_product.h.
Method dense_scalar_method(const TexelIntegrals& texels, int functions);
Method dense_method(const TexelIntegrals& texels, int functions);
Method dense_open_method(const TexelIntegrals& texels, int functions);
Method dense_bytes_method(const TexelIntegrals& texels, int functions);
Method dense_bits_method(const TexelIntegrals& texels, int functions);

/// The factors of all vertices in the library's representation, with contiguous nodes.
class WideVertices {
public:
    explicit WideVertices(const TreeIntegrals& trees);
    WideVertices(const WideVertices&) = delete;
    WideVertices& operator=(const WideVertices&) = delete;

    using Factors = std::span<const WeightedTrees<float>>;
    std::span<const Factors> factors() const { return factors_; }  ///< Indexed by vertex.

private:
    std::vector<WideNode<float>> nodes_;
    std::vector<WideCubemap<float>> trees_;  ///< Indexed by vertex and factor, like all members below.
    std::vector<WeightedTrees<float>::Part> parts_;
    std::vector<WeightedTrees<float>> weighted_;
    std::vector<Factors> factors_;
};

/// The input of the methods: the same vertices as texels and as trees of `functions` functions.
struct MethodInputs {
    const TexelIntegrals& texels;
    const TreeIntegrals& trees;
    int functions;
};

/// All of the methods above, by short names.
struct NamedMethod {
    const char* name;
    Method (*make)(const MethodInputs& inputs);
};
std::span<const NamedMethod> all_methods();

/// Computes the radiance of the first `count` vertices.
std::vector<Rgb> radiance_by(const Method& method, std::size_t count);

/// The location of the functions of a vertex when a method reads them.
enum class DataPlace {
    cache,   ///< Each batch of vertices is evaluated several times in a row.
    memory,  ///< Each vertex is evaluated once, in turn.
};
inline constexpr int cache_repeats = 8;

/// Evaluates `count` vertices, from the first of a batch on, cache_repeats times or once. Returns the number
/// of evaluations.
std::size_t evaluate_all(const Method& method, std::size_t first, std::size_t count, DataPlace place);

/// Returns the CPU seconds of this thread, which exclude other programs on the machine.
double thread_seconds();

/// Returns the minimum time per vertex of each method over `rounds` rounds, which alternate between the
/// methods so that disturbances affect all of them. Data shared by all vertices, such as the lighting, are in
/// the cache. [us]
std::vector<double> least_microseconds(std::span<const Method> methods, std::size_t count, DataPlace place,
                                       int rounds);

}  // namespace haarfield::baseline
