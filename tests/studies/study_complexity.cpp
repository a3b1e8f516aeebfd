#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "fields/wavelets/haar_transform.h"
#include "tests/baselines/general_basis.h"
#include "tests/baselines/product_methods.h"
#include "tests/studies/study.h"

namespace haarfield::baseline {
namespace {

enum Parameter : std::size_t { texels_m, wavelets_m, functions_n, parameters };

/// A method's times for each parameter, with the others fixed. [us per vertex]
struct Growth {
    std::string title;
    const char* claimed;  ///< Complexity stated in the paper.
    int colour;
    std::array<std::vector<std::pair<double, double>>, parameters> times;
    bool exponential = false;  ///< In n.
};

/// Returns the slope of the regression line in logarithmic coordinates.
double exponent(const std::vector<std::pair<double, double>>& points) {
    const auto count = static_cast<double>(points.size());
    double x = 0, y = 0, xx = 0, xy = 0;
    for (const auto& [value, time] : points) {
        x += std::log(value) / count;
        y += std::log(time) / count;
    }
    for (const auto& [value, time] : points) {
        xx += (std::log(value) - x) * (std::log(value) - x);
        xy += (std::log(value) - x) * (std::log(time) - y);
    }
    return xy / xx;
}

/// The methods that process the actual scene.
class SceneGrowth {
public:
    explicit SceneGrowth(std::size_t vertices) {
        for (const int size : {16, 32, 64, 128, 256})
            add(texels_m, size * size, texel_integrals(size, vertices), 6, {40, 40});
        const TexelIntegrals texels = texel_integrals(64, vertices);
        for (const int kept : {10, 20, 40, 80, 160, 320, 640}) add(wavelets_m, kept, texels, 6, {kept, kept});
        for (int functions = 3; functions <= 7; ++functions)
            add(functions_n, functions, texels, functions, {200, 70});
        for (const int order : {2, 3, 4, 5, 6, 8, 10})
            add_point(harmonics_, wavelets_m, order * order, harmonics_method(texels, 6, order));
        for (int functions = 3; functions <= 7; ++functions)
            add_point(harmonics_, functions_n, functions, harmonics_method(texels, functions, 10));

        const std::vector<double> times = least_microseconds(methods_, vertices, DataPlace::cache, 10);
        for (std::size_t i = 0; i < times.size(); ++i)
            points_[i].growth->times[points_[i].parameter].emplace_back(points_[i].value, times[i]);
    }
    SceneGrowth(const SceneGrowth&) = delete;
    SceneGrowth& operator=(const SceneGrowth&) = delete;

    std::vector<Growth> result() const {
        return {scalar_, vectors_, harmonics_, pairwise_, paper_, haarfield_};
    }

private:
    void add(Parameter parameter, double value, const TexelIntegrals& texels, int functions,
             const KeptWavelets& kept) {
        const TreeIntegrals trees = tree_integrals(texels, functions, kept);
        add_point(haarfield_, parameter, value, haarfield_method(trees));
        add_point(paper_, parameter, value, paper_method(trees));
        add_point(pairwise_, parameter, value, pairwise_method(trees));
        if (parameter == wavelets_m) return;  // texels are not truncated
        add_point(scalar_, parameter, value, dense_scalar_method(texels, functions));
        add_point(vectors_, parameter, value, dense_method(texels, functions));
    }

    void add_point(Growth& growth, Parameter parameter, double value, Method method) {
        points_.push_back({&growth, parameter, value});
        methods_.push_back(std::move(method));
    }

    /// A point at which each method is measured.
    struct Point {
        Growth* growth;
        Parameter parameter;
        double value;
    };
    std::vector<Point> points_;
    std::vector<Method> methods_;
    Growth scalar_{"texels, scalar", "M n", 7, {}}, vectors_{"texels, vectors", "M n", 6, {}},
        harmonics_{"two at a time, harmonics", "m^5/2 n", 3, {}},
        pairwise_{"two at a time, Haar", "M n", 5, {}}, paper_{"paper's algorithm", "m n", 2, {}},
        haarfield_{"haarfield", "m n", 1, {}};
};

/// The functions of the first vertex, for one face and red light: the largest problem that is feasible with a
/// general basis. The cost does not depend on the values, so six faces and three channels take 18 times as
/// long.
constexpr double faces_and_channels = 18;

std::vector<Quadtree> small_functions(int levels, int functions) {
    const TexelIntegrals texels = texel_integrals(1 << levels, 1);
    const TreeIntegrals trees = tree_integrals(texels, functions, {0, 0});
    std::vector<float> red;
    for (std::size_t i = 0; i < texels.light.size() / cubemap_faces; ++i) red.push_back(texels.light[i].x);
    std::vector<Quadtree> result{haar_quadtree<float>(red, texels.face_size)};
    for (const CubemapTree& factor : trees.vertices[0]) result.push_back(factor.faces[0]);
    return result;
}

/// Returns the minimum of three calls.
template <class Work>
double microseconds(const Work& work) {
    double least = INFINITY;
    for (int i = 0; i < 3; ++i) {
        const double start = thread_seconds();
        volatile double kept = static_cast<double>(work());
        static_cast<void>(kept);
        least = std::min(least, 1e6 * (thread_seconds() - start));
    }
    return least * faces_and_channels;
}

double general_time(int levels, int functions) {
    const std::vector<Quadtree> trees = small_functions(levels, functions);
    std::vector<const Quadtree*> pointers;
    for (const Quadtree& tree : trees) pointers.push_back(&tree);
    return microseconds([&] { return general_basis_integral(pointers, levels); });
}

double recursive_time(const RecursiveGeneralBasis& basis, int levels, int functions) {
    std::vector<std::vector<float>> coefficients;
    for (const Quadtree& tree : small_functions(levels, functions)) {
        const std::vector<double> exact = basis_coefficients(tree, levels);
        coefficients.emplace_back(exact.begin(), exact.end());
    }
    return microseconds([&] { return basis(coefficients); });
}

std::vector<Growth> general_growth() {
    Growth general{"general basis", "M^n", 0, {}, true}, recursive{"recursive general basis", "M^3 n", 4, {}};
    for (int levels = 2; levels <= 4; ++levels)
        general.times[texels_m].emplace_back(1 << (2 * levels), general_time(levels, 3));
    for (int functions = 3; functions <= 5; ++functions)
        general.times[functions_n].emplace_back(functions, general_time(2, functions));
    for (int levels = 2; levels <= 4; ++levels) {
        const RecursiveGeneralBasis basis(levels);
        recursive.times[texels_m].emplace_back(1 << (2 * levels), recursive_time(basis, levels, 6));
        if (levels != 3) continue;
        for (int functions = 3; functions <= 7; ++functions)
            recursive.times[functions_n].emplace_back(functions, recursive_time(basis, levels, functions));
    }
    return {general, recursive};
}

/// For methods that are exponential in n: the factor per additional function, to the power of n.
std::string exponent_text(const Growth& growth, Parameter parameter) {
    const auto& points = growth.times[parameter];
    if (points.empty()) return "-";
    if (parameter != functions_n || !growth.exponential) return fmt::format("{:.2f}", exponent(points));
    const auto& [first, first_time] = points.front();
    const auto& [last, last_time] = points.back();
    return fmt::format("{:.1f}^n", std::pow(last_time / first_time, 1 / (last - first)));
}

/// Prints a table of times for one parameter.
void print_times(const std::vector<Growth>& all, Parameter parameter, const char* heading) {
    std::set<double> values;
    for (const Growth& growth : all)
        for (const auto& [value, time] : growth.times[parameter]) values.insert(value);
    fmt::print("\n{:<26}", heading);
    for (const double value : values) fmt::print(" {:>8g}", value);
    fmt::print("\n");
    for (const Growth& growth : all) {
        if (growth.times[parameter].empty()) continue;
        fmt::print("{:<26}", growth.title);
        const std::map<double, double> times(growth.times[parameter].begin(), growth.times[parameter].end());
        for (const double value : values)
            fmt::print(" {:>8}", times.contains(value) ? fmt::format("{:.3g}", times.at(value)) : "");
        fmt::print("\n");
    }
}

void print_tables(const std::vector<Growth>& all, std::size_t vertices) {
    fmt::print(
        "How the time grows with M (texels a face), m (wavelets kept a face; of harmonics: coefficients\n"
        "in all) and n (functions): exponents by least squares in logarithms over the points below.\n"
        "us per vertex, RGB, one thread, {} vertices of the shipped scene.\n"
        "By M: m = 40, n = 6 (general basis: m = M, n = 3). By m: M = 4096, n = 6.\n"
        "By n: M = 4096, m = 70, of the lighting 200 (general basis: M = 16, recursive: 64;\n"
        "harmonics: m = 100).\n\n",
        vertices);
    fmt::print("{:<26} {:<9} {:>6} {:>6} {:>6}\n", "method", "paper", "in M", "in m", "in n");
    for (const Growth& growth : all) {
        fmt::print("{:<26} {:<9}", growth.title, growth.claimed);
        for (const Parameter parameter : {texels_m, wavelets_m, functions_n})
            fmt::print(" {:>6}", exponent_text(growth, parameter));
        fmt::print("\n");
    }
    print_times(all, texels_m, "us by M");
    print_times(all, wavelets_m, "us by m");
    print_times(all, functions_n, "us by n");
}

}  // namespace

std::vector<PlotPanel> study_complexity(std::size_t vertices) {
    std::vector<Growth> all = general_growth();
    for (Growth& growth : SceneGrowth(vertices).result()) all.push_back(std::move(growth));
    print_tables(all, vertices);
    const char* const titles[parameters] = {"Texels", "Kept wavelets", "Functions"};
    const PlotAxis axes[parameters] = {{"M, texels a face", true, {16, 256, 4096, 65536}},
                                       {"m, coefficients", true, {4, 10, 20, 40, 80, 160, 320, 640}},
                                       {"n, functions", true, {3, 4, 5, 6, 7}}};
    std::vector<PlotPanel> panels;
    for (std::size_t parameter = 0; parameter < parameters; ++parameter) {
        PlotPanel panel{titles[parameter], axes[parameter], {"µs per vertex, RGB", true, {}}, {}};
        for (const Growth& growth : all)
            if (!growth.times[parameter].empty())
                panel.series.push_back({growth.title, growth.times[parameter], growth.colour});
        panels.push_back(std::move(panel));
    }
    return panels;
}

}  // namespace haarfield::baseline
