#pragma once
/// All ways to compute the product integrals of the shipped scene, in one form: to check, to time and to
/// compare.

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "shading/wide_product.h"
#include "tests/paper_product_integral.h"
#include "tests/scene_integrals.h"

namespace haarfield::baseline {

struct Method {
    std::string title;
    bool of_trees = true;     ///< Multiplies the truncated trees; otherwise all texels.
    double tolerance = 1e-5;  ///< Relative RMSE that is allowed against the texel sums of what it multiplies.
    std::size_t batch = 1;    ///< So many vertices at a time.

    /// Radiance of the vertices from `first` on, at most a batch.
    std::function<void(std::size_t first, std::span<Rgb> radiance)> evaluate;
};

/// The library's product integral in wide nodes, and in quadtrees as they are. depth as there.
Method haarfield_method(const TreeIntegrals& trees, int depth = 32);
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

/// The factors of all vertices in wide nodes, by vertex; and those of one vertex as the library takes them.
using WideVertices = std::vector<std::vector<WideCubemapTree>>;
std::shared_ptr<const WideVertices> wide_trees(const TreeIntegrals& trees);
class WideFactors {
public:
    explicit WideFactors(const std::vector<WideCubemapTree>& trees);
    WideFactors(const WideFactors&) = delete;
    WideFactors& operator=(const WideFactors&) = delete;

    std::span<const WeightedTrees<float>> span() const { return std::span(weighted_).first(count_); }

private:
    std::size_t count_;
    std::array<WeightedTrees<float>::Part, 16> parts_;
    std::array<WeightedTrees<float>, 16> weighted_;
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

/// Evaluates all batches, cache_repeats times or once; the number of vertices evaluated.
std::size_t evaluate_all(const Method& method, std::size_t count, DataPlace place);

/// CPU seconds of this thread: other programs on the machine do not count.
double thread_seconds();

/// Least time per vertex of each method, in `rounds` turns, so that all of them meet the same weather. [us]
std::vector<double> least_microseconds(std::span<const Method> methods, std::size_t count, DataPlace place,
                                       int rounds);

}  // namespace haarfield::baseline
