#include "tests/oracles/pixel_reference.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace haarfield::reference {
namespace {

double channel_of(float value, int) {
    return double(value);
}
double channel_of(const Rgb& value, int channel) {
    return double(value[channel]);
}

template <class Value>
Texels any_texels_of(const BasicQuadtree<Value>& tree, int channel, int size, int depth) {
    Texels texels;
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column) {
            double value = channel_of(tree.scaling, channel);
            std::int64_t index = tree.nodes.empty() ? -1 : 0;
            int level = 0;
            for (int side = size; side > 1 && index >= 0 && level < depth; side /= 2, ++level) {
                const auto& node = tree.nodes[std::size_t(index)];
                const bool right = column % side >= side / 2, low = row % side >= side / 2;
                value += channel_of(node.wavelet[0], channel) * (right ? -1 : 1);
                value += channel_of(node.wavelet[1], channel) * (low ? -1 : 1);
                value += channel_of(node.wavelet[2], channel) * (right != low ? -1 : 1);
                const unsigned quadrant = (low ? 2u : 0u) + (right ? 1u : 0u);
                std::int64_t next = node.children >> 4;
                for (unsigned before = 0; before < quadrant; ++before) next += node.children >> before & 1u;
                index = (node.children >> quadrant & 1u) ? next : -1;
            }
            texels.push_back(value);
        }
    return texels;
}

class Random {
public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}
    /// Returns a number in [0, 1), the same on every platform.
    double uniform() { return engine_() / 4294967296.0; }
    float value(float scale) { return float((2 * uniform() - 1)) * scale; }

private:
    std::mt19937 engine_;
};

void fill(float& value, Random& random, float scale) {
    value = random.value(scale);
}
void fill(Rgb& value, Random& random, float scale) {
    for (int channel = 0; channel < 3; ++channel) value[channel] = random.value(scale);
}

template <class Value>
BasicQuadtree<Value> any_random_quadtree(std::uint32_t seed, int levels, double density) {
    Random random(seed);
    BasicQuadtree<Value> tree;
    tree.scaling = Value(float(0.7 + 0.6 * random.uniform()));
    std::size_t in_row = levels > 0 ? 1 : 0;
    float scale = 0.5f;
    for (int level = 0; level < levels && in_row > 0; ++level, scale *= 0.7f) {
        std::size_t next = 0;
        const std::size_t next_first = tree.nodes.size() + in_row;
        for (std::size_t i = 0; i < in_row; ++i) {
            typename BasicQuadtree<Value>::Node node;
            for (Value& wavelet : node.wavelet) fill(wavelet, random, scale);
            std::uint32_t mask = 0;
            for (unsigned quadrant = 0; quadrant < 4 && level + 1 < levels; ++quadrant)
                if (random.uniform() < density) mask |= 1u << quadrant;
            if (mask) node.children = std::uint32_t(next_first + next) << 4 | mask;
            next += std::size_t(std::popcount(mask));
            tree.nodes.push_back(node);
        }
        in_row = next;
    }
    return tree;
}

}  // namespace

Texels texels_of(const Quadtree& tree, int size, int depth) {
    return any_texels_of(tree, 0, size, depth);
}

Texels texels_of(const RgbQuadtree& tree, int channel, int size, int depth) {
    return any_texels_of(tree, channel, size, depth);
}

Texels product(std::span<const Texels> factors) {
    Texels result(factors[0].size(), 1.0);
    for (const Texels& factor : factors)
        for (std::size_t i = 0; i < result.size(); ++i) result[i] *= factor[i];
    return result;
}

double mean(const Texels& texels) {
    double sum = 0;
    for (const double value : texels) sum += value;
    return sum / double(texels.size());
}

double absolute_mean(const Texels& texels) {
    double sum = 0;
    for (const double value : texels) sum += std::abs(value);
    return sum / double(texels.size());
}

double wavelet_amplitude(const Texels& texels, int size, int level, int x, int y, int kind) {
    const int side = size >> level;
    double sum = 0;
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            const bool right = column >= side / 2, low = row >= side / 2;
            const bool minus = kind == 0 ? right : kind == 1 ? low : right != low;
            sum += texels[std::size_t((y * side + row) * size + x * side + column)] * (minus ? -1 : 1);
        }
    return sum / (side * side);
}

Quadtree random_quadtree(std::uint32_t seed, int levels, double density) {
    return any_random_quadtree<float>(seed, levels, density);
}

RgbQuadtree random_rgb_quadtree(std::uint32_t seed, int levels, double density) {
    return any_random_quadtree<Rgb>(seed, levels, density);
}

std::vector<Quadtree> random_trees(std::uint32_t seed, int count, int levels, double density) {
    std::vector<Quadtree> trees;
    for (int i = 0; i < count; ++i)
        trees.push_back(random_quadtree(100 * seed + std::uint32_t(i), i % 4 == 2 ? 0 : levels, density));
    return trees;
}

std::vector<const Quadtree*> pointers(const std::vector<Quadtree>& trees) {
    std::vector<const Quadtree*> result;
    for (const Quadtree& tree : trees) result.push_back(&tree);
    return result;
}

std::vector<float> half_plane_texels(std::uint32_t seed, int size) {
    Random random(seed);
    const double angle = 2 * pi * random.uniform(), offset = 0.6 * (random.uniform() - 0.5);
    std::vector<float> texels;
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column) {
            const double x = (column + 0.5) / size - 0.5, y = (row + 0.5) / size - 0.5;
            const double distance = (x * std::cos(angle) + y * std::sin(angle) - offset) * size;
            texels.push_back(float(std::clamp(distance + 0.5, 0.0, 1.0)));
        }
    return texels;
}

std::vector<float> noise_texels(std::uint32_t seed, std::size_t count) {
    Random random(seed);
    std::vector<float> texels(count);
    for (float& texel : texels) texel = float(random.uniform());
    return texels;
}

}  // namespace haarfield::reference
