#include "tests/baselines/general_basis.h"

#include <cassert>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace haarfield::baseline {

std::vector<HaarBasisFunction> haar_basis(int levels) {
    std::vector<HaarBasisFunction> basis{{}};
    for (int level = 0; level < levels; ++level)
        for (std::uint32_t y = 0; y < 1u << level; ++y)
            for (std::uint32_t x = 0; x < 1u << level; ++x)
                for (std::uint8_t kind = 1; kind <= 3; ++kind)
                    basis.push_back({HaarBasisFunction::Kind(kind), level, x, y});
    return basis;
}

std::vector<double> basis_coefficients(const Quadtree& tree, int levels) {
    std::vector<double> coefficients(std::size_t(1) << (2 * levels), 0.0);
    coefficients[0] = double(tree.scaling);
    struct Square {
        std::int32_t node;
        int level;
        std::size_t x, y;
    };
    std::vector<Square> squares;
    if (!tree.nodes.empty()) squares.push_back({0, 0, 0, 0});
    for (std::size_t i = 0; i < squares.size(); ++i) {
        const auto [index, level, x, y] = squares[i];
        assert(level < levels);
        const Quadtree::Node& node = tree.nodes[std::size_t(index)];
        // Level l begins after the 4^l functions of coarser levels.
        const std::size_t first = (std::size_t(1) << (2 * level)) + 3 * ((y << level) + x);
        for (std::size_t a = 0; a < 3; ++a)
            coefficients[first + a] = std::ldexp(double(node.wavelet[a]), -level);
        for (unsigned q = 0; q < 4; ++q)
            if (const std::int32_t child = child_of(node, q); child != no_node)
                squares.push_back({child, level + 1, 2 * x + q % 2, 2 * y + q / 2});
    }
    return coefficients;
}

double general_basis_integral(std::span<const Quadtree* const> trees, int levels) {
    const std::vector<HaarBasisFunction> basis = haar_basis(levels);
    std::vector<std::vector<double>> coefficients;
    for (const Quadtree* tree : trees) coefficients.push_back(basis_coefficients(*tree, levels));
    std::vector<HaarBasisFunction> functions(trees.size());
    double sum = 0;
    const auto add_tuples = [&](const auto& self, std::size_t chosen, double product) -> void {
        if (chosen == trees.size()) {
            sum += product * integral_coefficient(functions);
            return;
        }
        for (std::size_t i = 0; i < basis.size(); ++i) {
            functions[chosen] = basis[i];
            self(self, chosen + 1, product * coefficients[chosen][i]);
        }
    };
    add_tuples(add_tuples, 0, 1);
    return sum;
}

RecursiveGeneralBasis::RecursiveGeneralBasis(int levels) {
    const std::vector<HaarBasisFunction> basis = haar_basis(levels);
    count_ = basis.size();
    for (const HaarBasisFunction& i : basis)
        for (const HaarBasisFunction& j : basis)
            for (const HaarBasisFunction& k : basis)
                coefficients_.push_back(
                    static_cast<float>(integral_coefficient(std::array<HaarBasisFunction, 3>{i, j, k})));
}

float RecursiveGeneralBasis::operator()(std::span<const std::vector<float>> functions) const {
    assert(functions.size() >= 2);
    std::vector<float> product = functions[0], next(count_);
    for (const std::vector<float>& factor : functions.subspan(1, functions.size() - 2)) {
        std::fill(next.begin(), next.end(), 0.0f);
        for (std::size_t i = 0; i < count_; ++i)
            for (std::size_t j = 0; j < count_; ++j) {
                const float pair = product[i] * factor[j];
                const float* const row = &coefficients_[(i * count_ + j) * count_];
                for (std::size_t k = 0; k < count_; ++k) next[k] += pair * row[k];
            }
        product.swap(next);
    }
    return std::inner_product(product.begin(), product.end(), functions.back().begin(), 0.0f);
}

}  // namespace haarfield::baseline
