// The walk down the trees of all factors. Included once per instruction set, inside Highway's foreach_target.

#if defined(HAARFIELD_WIDE_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_WIDE_WALK_INL_H
#undef HAARFIELD_WIDE_WALK_INL_H
#else
#define HAARFIELD_WIDE_WALK_INL_H
#endif

#include <type_traits>

#include "shading/walk/cells-inl.h"
#include "shading/walk/wide_walk.h"

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

inline constexpr unsigned all_sixteen = 0xffff;

template <class Action>
HWY_INLINE void for_each_bit(unsigned cells, const Action& action) {
    for (unsigned left = cells; left != 0; left &= left - 1)
        action(static_cast<unsigned>(std::countr_zero(left)));
}

/// The mean over a block's cells of the functions that are not trees: lighting, BRDF and cosine of a vertex.
template <int channel_count>
struct HeadCells {
    static constexpr int channels = channel_count;

    struct Ahead {};
    Ahead ahead(unsigned) const { return {}; }

    Cells value[channels];  ///< Per channel.
    unsigned once = 0;      ///< Cells on which at least one of its functions varies.
    unsigned twice = 0;     ///< Cells on which at least two vary.
    unsigned zero = 0;      ///< Cells on which it is zero.
    int used = channels;    ///< Channels from this one on are zero.
};

template <class Cell>
HWY_INLINE Cells factor_cells(const VaryingFactor& factor, const WeightedNode<Cell>* nodes) {
    Cells value = all_cells(factor.constant);
    for (std::uint32_t i = 0; i < factor.nodes; ++i)
        value = multiply_add(all_cells(nodes[i].weight), load_cells(nodes[i].node->mean.data()), value);
    return value;
}

/// Bounds on a head f within each cell, summed over the channels; c is its HeadCells::value.
struct HeadErrors {
    Cells deviation;         ///< An upper bound on the root mean square of f - c.
    unsigned unbounded = 0;  ///< Cells without a bound.
};

/// A bound on the deviation within a cell of the product w of the factors that vary on it, each in [0, 1].
///
/// A function in [0, 1] with mean v has a deviation of at most t = sqrt(v (1 - v)), because v^2 <= v under
/// the integral. Multiplying w by such a factor gives a deviation of at most t + v deviation(w): the first
/// term bounds w (factor - v), as w <= 1, and the second one w v.
struct ProductErrors {
    Cells deviation;

    ProductErrors() : deviation(all_cells(0)) {}

    HWY_INLINE void add(unsigned varying, const Cells& value) {
        const Cells zero = all_cells(0), one = all_cells(1);
        const Cells v = choose(varying, larger(smaller(value, one), zero), one);
        deviation = smaller(square_root(v * (one - v)) + deviation * v, all_cells(0.5f));
    }
    /// Bounds the root mean square of f w - mean(f w) in the cells, f the head with values c. It is at most
    /// that of (f - c) w plus |c| times the deviation of w: w <= 1, and a function deviates least from its
    /// mean.
    template <int channels>
    HWY_INLINE Cells deviation_bound(const HeadCells<channels>& head, const HeadErrors& errors) const {
        Cells size = magnitude(head.value[0]);
        for (int c = 1; c < channels; ++c) size = size + magnitude(head.value[c]);
        return errors.deviation + size * deviation;
    }
};

/// Passes blocks of the last level to a sink that treats them like all others.
template <class Sink>
struct LeavesOf {
    Sink& sink;

    explicit LeavesOf(Sink& of) : sink(of) {}
    template <class HeadValue>
    HWY_INLINE void add(int level, std::size_t face, std::size_t block, const Cells& product,
                        const HeadValue& head) {
        sink.add(level, face, block, all_sixteen, product, head);
    }
};

/// A sink that sums over all cells, by channel: an integral.
template <int channels>
struct ChannelSums {
    static constexpr unsigned needed = 2;
    static constexpr bool is_sum = true, may_blur = false;
    static constexpr float cell_share = 1.0f / wide_cells;

    Cells sum[channels];

    ChannelSums() {
        for (Cells& channel : sum) channel = all_cells(0);
    }
    auto total() const {
        if constexpr (channels == 1)
            return sum_of(sum[0]);
        else
            return Rgb(sum_of(sum[0]), sum_of(sum[1]), sum_of(sum[2]));
    }
    HWY_INLINE void add(int, std::size_t, std::size_t, unsigned done, const Cells& product,
                        const HeadCells<channels>& head) {
        const Cells share = only(done, product);
        for (int c = 0; c < channels; ++c) sum[c] = multiply_add(share, head.value[c], sum[c]);
    }
    HWY_INLINE void open(int level, std::size_t face, std::size_t block, unsigned done, const Cells& product,
                         const HeadCells<channels>& head) {
        add(level, face, block, done, product, head);
    }
    void close(int, std::size_t) {}

    /// Separate sums, which stay in registers.
    struct Leaves {
        ChannelSums& whole;
        Cells sum[channels];

        HWY_INLINE explicit Leaves(ChannelSums& to) : whole(to) {
            for (Cells& channel : sum) channel = all_cells(0);
        }
        HWY_INLINE ~Leaves() {
            for (int c = 0; c < channels; ++c) whole.sum[c] = whole.sum[c] + sum[c];
        }
        HWY_INLINE void add(int, std::size_t, std::size_t, const Cells& product,
                            const HeadCells<channels>& head) {
            for (int c = 0; c < channels; ++c) sum[c] = multiply_add(product, head.value[c], sum[c]);
        }
    };
};

/// Walks down a face, cell by cell, while at least Sink::needed functions vary and no constant factor is
/// zero.
///
/// Where fewer than two functions vary, the mean of the product is the product of the means: the mean of a
/// function times constants is its mean times the constants. Constants are passed down as one number.
///
/// Head  Ahead: properties of a block that are known from its parent.
///       HeadCells operator()(int level, std::size_t face, std::size_t block, Ahead): the result has
///       Ahead ahead(unsigned cell)  for the block in a cell.
///       last(level, face, block, Ahead): for blocks of the last level, where only values and zeros are used.
/// Sink  receives each block, parents first. A block with descendants calls open(level, face, block,
///       completed cells, product of the constants and trees, head), and close(level, block) when the other
///       cells are complete. A block without calls add(...), on the last level through Sink::Leaves.
///       `constant` of the root multiplies that product, as does Sink::cell_share on each level.
///       may_blur: variation within some cells may be omitted, except for their means. set_blurred receives
///       these cells; below them the walk continues only where two functions vary.
///       is_sum: only the sum over the cells of all blocks is used.
template <class Cell, class Head, class Sink>
class Walk {
    using Ahead = typename Head::Ahead;
    using HeadValue = std::invoke_result_t<const Head&, int, std::size_t, std::size_t, const Ahead&>;

public:
    Walk(const Head& head, Sink& sink, WalkMemory<Cell>& memory, const Depth& depth)
        : head_(head), sink_(sink), memory_(memory), last_level_(depth.levels - 1), average_(depth.average) {}

    /// Visits a block. memory.varying[level] holds the factors that vary on it.
    void visit(int level, std::size_t face, std::size_t block, float constant, const Ahead& ahead) {
        if (level == last_level_) return finish(level, face, block, constant, ahead);
        const HeadValue head = head_(level, face, block, ahead);
        if (head.zero != all_sixteen) descend(level, face, block, constant, head, ahead);
    }

private:
    void finish(int level, std::size_t face, std::size_t block, float constant, const Ahead& ahead) {
        auto head = head_.last(level, face, block, ahead);
        if (head.zero == all_sixteen) return;
        const VaryingFactors<Cell>& varying = memory_.varying[std::size_t(level)];
        average_head(head);
        Cells product = all_cells(constant);
        const WeightedNode<Cell>* nodes = varying.nodes.data();
        for (std::size_t f = 0; f < varying.factor_count; ++f) {
            Cells value = factor_cells(varying.factors[f], nodes);
            if (average_ > 1) value = means_of(value, average_);
            product = product * value;
            nodes += varying.factors[f].nodes;
        }
        sink_.add(level, face, block, all_sixteen, product, head);
    }

    void descend(int level, std::size_t face, std::size_t block, float constant, const HeadValue& head,
                 [[maybe_unused]] const Ahead& ahead) {
        const VaryingFactors<Cell>& varying = memory_.varying[std::size_t(level)];
        auto* evaluated = memory_.evaluated[std::size_t(level)].data();
        Cells product = all_cells(constant), constants = product;
        unsigned once = head.once, twice = head.twice;
        [[maybe_unused]] ProductErrors errors;
        const WeightedNode<Cell>* nodes = varying.nodes.data();
        for (std::size_t f = 0; f < varying.factor_count; ++f) {
            Cells value = all_cells(varying.factors[f].constant), constant_part = value;
            unsigned cells = 0;
            for (std::uint32_t i = 0; i < varying.factors[f].nodes; ++i, ++nodes) {
                const WideNode<Cell>& node = *nodes->node;
                const Cells share = all_cells(nodes->weight) * load_cells(node.mean.data());
                value = value + share;
                constant_part = constant_part + only(~unsigned(node.varying), share);
                cells |= node.varying;
            }
            store_cells(constant_part, evaluated[f].constant.data());
            evaluated[f].varying = cells;
            product = product * value;
            constants = constants * choose(cells, all_cells(1), value);
            twice |= once & cells;
            once |= cells;
            if constexpr (Sink::may_blur)
                if (sink_.needs_bounds()) errors.add(cells, value);
        }
        const unsigned zero = head.zero | cells_that_are_zero(constants);
        unsigned more = (Sink::needed == 2 ? twice : once) & ~zero;
        if constexpr (Sink::may_blur) {
            unsigned blurred = sink_.is_blurred(level, block) ? all_sixteen : 0;
            if (blurred == 0 && sink_.needs_bounds() && more != 0) {
                const HeadErrors of_head = head_.errors(level, face, block, ahead);
                const Cells bound = magnitude(constants) * errors.deviation_bound(head, of_head);
                blurred = more & ~(of_head.unbounded | cells_above(bound, sink_.negligible(level)));
                if (blurred != 0) sink_.add_blurred(level, sum_of(only(blurred, bound * bound)));
            }
            sink_.set_blurred(level, blurred);
            more &= ~blurred | twice;
        }
        const unsigned done = all_sixteen & ~(more | zero);
        if (more == 0) return sink_.add(level, face, block, done, product, head);
        sink_.open(level, face, block, done, product, head);
        if (level + 1 == last_level_) {
            finish_cells(level, face, block, constants, more, head);
        } else {
            alignas(64) float cell_constants[wide_cells];
            store_cells(constants, cell_constants);
            for_each_bit(more, [&](unsigned cell) {
                list_children(level, cell);
                visit(level + 1, face, block * wide_cells + cell, cell_constants[cell] * Sink::cell_share,
                      head.ahead(cell));
            });
        }
        sink_.close(level, block);
    }

    /// Does the same as `finish` for the blocks of these cells, factor by factor instead of block by block.
    /// This needs no lists and keeps many loads in flight.
    void finish_cells(int level, std::size_t face, std::size_t block, const Cells& constants, unsigned cells,
                      const HeadValue& above) {
        const VaryingFactors<Cell>& varying = memory_.varying[std::size_t(level)];
        const auto* evaluated = memory_.evaluated[std::size_t(level)].data();
        alignas(64) float cell_constants[wide_cells];
        store_cells(constants, cell_constants);
        Cells product[wide_cells];
        for_each_bit(cells, [&](unsigned cell) {
            product[cell] = all_cells(cell_constants[cell] * Sink::cell_share);
        });
        const WeightedNode<Cell>* node = varying.nodes.data();
        for (std::size_t f = 0; f < varying.factor_count; ++f) {
            const unsigned varying_cells = evaluated[f].varying & cells;
            const std::uint32_t count = varying.factors[f].nodes;
            if (varying_cells != 0) {
                Cells value[wide_cells];
                for_each_bit(varying_cells,
                             [&](unsigned cell) { value[cell] = all_cells(evaluated[f].constant[cell]); });
                for (std::uint32_t i = 0; i < count; ++i) {
                    const Cells weight = all_cells(node[i].weight);
                    const WideNode<Cell>* parent = node[i].node;
                    for_each_bit(parent->varying & cells, [&](unsigned cell) {
                        value[cell] = multiply_add(weight, load_cells(child_of(parent, cell)->mean.data()),
                                                   value[cell]);
                    });
                }
                for_each_bit(varying_cells, [&](unsigned cell) {
                    if (average_ > 1) value[cell] = means_of(value[cell], average_);
                    product[cell] = product[cell] * value[cell];
                });
            }
            node += count;
        }
        typename Sink::Leaves leaves(sink_);
        for (unsigned left = cells; left != 0; left &= left - 1) {
            const auto cell = static_cast<unsigned>(std::countr_zero(left));
            const std::size_t leaf = block * wide_cells + cell;
            auto head = head_.last(level + 1, face, leaf, above.ahead(cell));
            if (head.zero == all_sixteen) continue;
            average_head(head);
            leaves.add(level + 1, face, leaf, product[cell], head);
        }
    }

    /// Averages the head for sinks that use single cells. For a sum, averaging the trees is sufficient.
    template <class Values>
    HWY_INLINE void average_head(Values& head) const {
        if constexpr (!Sink::is_sum)
            if (average_ > 1)
                for (Cells& channel : head.value) channel = means_of(channel, average_);
    }

    /// Lists the factors that vary on a cell.
    void list_children(int level, unsigned cell) {
        const VaryingFactors<Cell>& varying = memory_.varying[std::size_t(level)];
        const auto* evaluated = memory_.evaluated[std::size_t(level)].data();
        VaryingFactors<Cell>& below = memory_.varying[std::size_t(level) + 1];
        VaryingFactor* factor = below.factors.data();
        WeightedNode<Cell>* end = below.nodes.data();
        const WeightedNode<Cell>* node = varying.nodes.data();
        for (std::size_t f = 0; f < varying.factor_count; ++f) {
            const std::uint32_t count = varying.factors[f].nodes;
            if (evaluated[f].varying >> cell & 1u) {
                const WeightedNode<Cell>* first = end;
                for (std::uint32_t i = 0; i < count; ++i) {
                    // Written unconditionally, kept if it varies.
                    *end = {child_of(node[i].node, cell), node[i].weight};
                    end += node[i].node->varying >> cell & 1u;
                }
                *factor++ = {evaluated[f].constant[cell], static_cast<std::uint32_t>(end - first)};
            }
            node += count;
        }
        below.factor_count = std::size_t(factor - below.factors.data());
    }

    const Head& head_;
    Sink& sink_;
    WalkMemory<Cell>& memory_;
    const int last_level_;
    const int average_;
};

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
