#pragma once
/// All ways to compute the product integrals of the shipped scene, in one form: to check, to time and to
/// compare.

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "shading/walk/product_integral.h"
#include "tests/baselines/paper_product_integral.h"
#include "tests/baselines/scene_integrals.h"

namespace haarfield::baseline {

/// So many vertices are evaluated at a time, at most.
inline constexpr std::size_t largest_batch = 16;

struct Method {
    std::string title;
    bool of_trees = true;     ///< Multiplies the truncated trees; otherwise all texels.
    double tolerance = 1e-5;  ///< Relative RMSE that is allowed against the texel sums of what it multiplies.
    std::size_t batch = 1;    ///< So many vertices at a time, up to largest_batch.

    /// Radiance of the vertices from `first` on, at most a batch.
    std::function<void(std::size_t first, std::span<Rgb> radiance)> evaluate;
};

/// The library's product integral in wide nodes, one by one and many at a time; and in quadtrees as they are.
/// depth as there.
Method haarfield_method(const TreeIntegrals& trees, int depth = 32);
Method haarfield_batch_method(const TreeIntegrals& trees);
Method narrow_method(const TreeIntegrals& trees, int depth = 32);

/// The paper's algorithm in float for each colour channel: with the table of its section 5.4 or the recursion
/// of 5.3, and with line 9 corrected (PaperCumulation), since the printed one gives other results.
Method paper_method(const TreeIntegrals& trees, int depth = full_depth,
                    reference::PaperFold fold = reference::PaperFold::table);

/// Two functions at a time, in trees and in spherical harmonics (whose error is what it is: no tolerance).
Method pairwise_method(const TreeIntegrals& trees);
Method harmonics_method(const TexelIntegrals& texels, int functions, int order);

/// Pixel domain; see dense_product.h.
Method dense_scalar_method(const TexelIntegrals& texels, int functions);
Method dense_method(const TexelIntegrals& texels, int functions);
Method dense_open_method(const TexelIntegrals& texels, int functions);
Method dense_bytes_method(const TexelIntegrals& texels, int functions);
Method dense_bits_method(const TexelIntegrals& texels, int functions);

/// The factors of all vertices as the library takes them, their nodes in one piece.
class WideVertices {
public:
    explicit WideVertices(const TreeIntegrals& trees);
    WideVertices(const WideVertices&) = delete;
    WideVertices& operator=(const WideVertices&) = delete;

    using Factors = std::span<const WeightedTrees<float>>;
    std::span<const Factors> factors() const { return factors_; }  ///< By vertex.

private:
    std::vector<WideNode<float>> nodes_;
    std::vector<WideCubemap<float>> trees_;  ///< By vertex and factor, as all that follows.
    std::vector<WeightedTrees<float>::Part> parts_;
    std::vector<WeightedTrees<float>> weighted_;
    std::vector<Factors> factors_;
};

/// What the methods multiply: the same vertices as texels and as trees of so many functions.
struct MethodInputs {
    const TexelIntegrals& texels;
    const TreeIntegrals& trees;
    int functions;
};

/// All of the above, by short names.
struct NamedMethod {
    const char* name;
    Method (*make)(const MethodInputs& inputs);
};
std::span<const NamedMethod> all_methods();

/// Of the first `count` vertices.
std::vector<Rgb> radiance_by(const Method& method, std::size_t count);

/// Where the functions of a vertex are when they are wanted.
enum class DataPlace {
    cache,   ///< Each batch of vertices is evaluated several times in a row.
    memory,  ///< Each vertex once, in turn.
};
inline constexpr int cache_repeats = 8;

/// Evaluates so many vertices, from the first of a batch on, cache_repeats times or once. Returns how many
/// evaluations that was.
std::size_t evaluate_all(const Method& method, std::size_t first, std::size_t count, DataPlace place);

/// CPU seconds of this thread: other programs on the machine do not count.
double thread_seconds();

/// Least time per vertex of each method, in `rounds` turns, so that all of them meet the same weather. What
/// all vertices share, such as the lighting, is in the cache. [us]
std::vector<double> least_microseconds(std::span<const Method> methods, std::size_t count, DataPlace place,
                                       int rounds);

}  // namespace haarfield::baseline
