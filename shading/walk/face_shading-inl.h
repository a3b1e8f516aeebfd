// Evaluates a vertex's BRDF, cosine and nearby occluders over the cells of the walk. Included once per
// instruction set, inside Highway's foreach_target.

#if defined(HAARFIELD_FACE_SHADING_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_FACE_SHADING_INL_H
#undef HAARFIELD_FACE_SHADING_INL_H
#else
#define HAARFIELD_FACE_SHADING_INL_H
#endif

#include "shading/walk/prepared_vertex.h"
#include "shading/walk/wide_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// The directions of a block, in vectors.
struct BlockDirections {
    const DirectionBlock& block;
    Cells x, y, z;

    explicit BlockDirections(const DirectionBlock& of_block)
        : block(of_block),
          x(load_cells(block.x.data())),
          y(load_cells(block.y.data())),
          z(load_cells(block.z.data())) {}

    HWY_INLINE Cells extent() const { return load_cells(block.extent.data()); }
    HWY_INLINE Cells inverse_extent() const { return load_cells(block.inverse_extent.data()); }

    /// Returns 1 minus the length of the mean direction.
    HWY_INLINE Cells spread() const { return extent() * extent() * all_cells(1.0f / 3); }

    /// Uses no fused operations, so that decisions based on the result are the same for all instruction sets.
    HWY_INLINE Cells dot(const Vec3f& v) const {
        return all_cells(v.x) * x + all_cells(v.y) * y + all_cells(v.z) * z;
    }
};

HWY_INLINE Cells power(const Cells& base, const Cells& exponent) {
    return exponential(exponent * logarithm_near_one(base));
}

#include "shading/walk/lobe_mean-inl.h"

/// The cells of a block with their cosines; see lobe_mean.
struct CellsOfLobe {
    const BlockDirections& directions;
    const Cells &cosine, &aligned;
    const Vec3f &to_eye, &across_plane, &axis;

    static HWY_INLINE Cells all(float x) { return all_cells(x); }
    HWY_INLINE const Cells& mirror() const { return aligned; }
    HWY_INLINE Cells eye_square() const { return all_cells(2) + all_cells(2) * directions.dot(to_eye); }
    HWY_INLINE Cells eye_normal() const { return cosine + all_cells(axis.dot(to_eye)); }
    HWY_INLINE Cells across() const { return directions.dot(across_plane); }
    HWY_INLINE Cells spread() const { return directions.spread(); }
};

/// Properties of a block, known from the cell of its parent.
struct BlockAhead {
    bool at_horizon = true;         ///< The horizon may cross the block; else the block lies above it.
    bool may_be_covered = true;     ///< Nearby occluders may cover it partly.
    unsigned specular_lobes = ~0u;  ///< Bit mask of the lobes that may be nonzero in it.
    float held_cosine = 0;          ///< See Reflected::holds_cosine; for blocks below level 1.

    bool is_plain() const { return !at_horizon && !may_be_covered && specular_lobes == 0; }
};

/// The properties of all blocks in the cells of a block.
struct CellsAhead {
    unsigned at_horizon = 0, may_be_covered = 0;
    std::array<unsigned, most_lobes> specular_lobes{};
};

/// A BRDF over a block's cells, without its colours.
struct ReflectedCells {
    Cells cosine;          ///< Clamped.
    Cells diffuse;         ///< The cosine used for diffuse reflection: see Reflected::holds_cosine.
    Cells specular_lobes;  ///< Specular lobes with their weights, if any.
    Cells loss;            ///< Fraction that a metal absorbs from them.
    bool has_specular = false;
    unsigned open_above = 0;  ///< Cells above the horizon that nearby occluders do not cover partly.

    ReflectedCells() : cosine(all_cells(0)), diffuse(cosine), specular_lobes(cosine), loss(cosine) {}
};

/// The cells of a block on which the light varies. Of these, the cells where the variation matters for
/// cosines (LightPyramid::uneven) and for specular lobes.
struct LitCells {
    unsigned varying = 0, uneven = 0, beside_specular = 0;
};

/// Colours of the specular component, next to those of the diffuse component.
struct SeparateColours : HeadCells<3> {
    Cells diffuse[3];
};

/// The light, times the diffuse and specular terms of the BRDF with their colours.
///
/// separate  the values are those of the specular component, with the diffuse one next to them; else their
///           sum.
template <bool separate>
struct LitColours {
    using Values = std::conditional_t<separate, SeparateColours, HeadCells<3>>;
    static constexpr bool holds_cosine = false, is_separate = separate;

    const LightPyramid& light;

    template <bool last>
    HWY_INLINE LitCells write(const PreparedVertex& vertex, const ReflectedCells& cells, int level,
                              std::size_t face, std::size_t block, Values& head) const {
        const std::size_t index = light.numbers()(level, face, block);
        const LightBlock& lit = light.block(index);
        const Cells colours[] = {load_cells(lit.red.data()), load_cells(lit.green.data()),
                                 load_cells(lit.blue.data())};
        Cells* diffuse = head.value;
        if constexpr (separate) diffuse = head.diffuse;
        for (int c = 0; c < 3; ++c)
            diffuse[c] = colours[c] * (all_cells(vertex.brdf.diffuse[c]) * cells.diffuse);
        if (cells.has_specular)
            for (int c = 0; c < 3; ++c) {
                Cells colour = all_cells(vertex.brdf.specular[c]);
                if (vertex.is_metallic)
                    colour = colour - colour * all_cells(vertex.brdf.metallic[c]) * cells.loss;
                const Cells specular = colours[c] * (colour * cells.specular_lobes);
                head.value[c] = separate ? specular : head.value[c] + specular;
            }
        else if constexpr (separate) {
            for (Cells& channel : head.value) channel = all_cells(0);
            head.used = 0;
        }
        if constexpr (last) return {};
        const unsigned varying = light.varying(index), uneven = light.uneven(index);
        if ((uneven & cells.open_above) != 0)
            add_unevenness(vertex, cells, index, uneven & cells.open_above, colours, diffuse);
        if (level == 0 || varying == 0) return {varying, uneven, varying};
        LitCells result{varying, uneven, 0};
        if (cells.has_specular)
            result.beside_specular =
                varying & cells_above(cells.specular_lobes * load_cells(light.deviation(index).data()),
                                      vertex.negligible[std::size_t(level)] * light.mean_size());
        return result;
    }

private:
    /// Replaces the product of the means of light and cosine by the mean of their product.
    HWY_INLINE void add_unevenness(const PreparedVertex& vertex, const ReflectedCells& cells,
                                   std::size_t index, unsigned uneven, const Cells* means,
                                   Cells* diffuse) const {
        const LightMoments& moments = light.moments(index);
        const Vec3f& normal = vertex.brdf.normal;
        for (std::size_t c = 0; c < 3; ++c) {
            const LightMoments::Channel& moment = moments.channel[c];
            const Cells mean = all_cells(normal.x) * load_cells(moment.x.data()) +
                               all_cells(normal.y) * load_cells(moment.y.data()) +
                               all_cells(normal.z) * load_cells(moment.z.data());
            const Cells lacking = mean - means[c] * cells.diffuse;
            diffuse[c] =
                multiply_add(all_cells(vertex.brdf.diffuse[int(c)]), only(uneven, lacking), diffuse[c]);
        }
    }
};

/// The terms of the BRDF without colours and light: see transfer_terms.
template <int term_count>
struct PlainTerms {
    using Values = HeadCells<term_count>;
    static constexpr bool holds_cosine = true;

    template <bool last>
    HWY_INLINE LitCells write(const PreparedVertex& vertex, const ReflectedCells& cells, int, std::size_t,
                              std::size_t, Values& head) const {
        head.value[0] = cells.diffuse;
        head.used = 1;
        for (int term = 1; term < term_count; ++term) head.value[term] = all_cells(0);
        if (!cells.has_specular) return {};
        head.value[1] = cells.specular_lobes;
        head.used = 2;
        if constexpr (term_count == 3)
            if (vertex.is_metallic) {
                head.value[2] = cells.specular_lobes - cells.specular_lobes * cells.loss;
                head.used = 3;
            }
        return {};
    }
};

/// The BRDF, times the visibility around the near occluders, on one face.
///
/// Reflected  LitCells write<last>(vertex, cells, level, face, block, values): writes its channels. The
///            result is not used for the last level.
///            holds_cosine: the cosine of diffuse light is constant over the cells of level 1.
///            is_separate: the diffuse component is not among the channels. Needed for errors() only.
///            Values: HeadCells, and other values that its sink uses.
template <class Reflected>
class FaceShading {
public:
    using Ahead = BlockAhead;

    /// The values of a block above the last level.
    struct Head : Reflected::Values {
        CellsAhead below;
        /// By cell: BlockAhead::held_cosine.
        alignas(64) std::array<float, Reflected::holds_cosine ? wide_cells : 0> held;

        BlockAhead ahead(unsigned cell) const {
            BlockAhead result{(below.at_horizon >> cell & 1u) != 0, (below.may_be_covered >> cell & 1u) != 0,
                              0};
            for (std::size_t i = 0; i < most_lobes; ++i)
                result.specular_lobes |= (below.specular_lobes[i] >> cell & 1u) << i;
            if constexpr (Reflected::holds_cosine) result.held_cosine = held[cell];
            return result;
        }
    };

    FaceShading(const Reflected& reflected, const PreparedVertex& vertex, std::size_t face,
                std::vector<Vec3f>& sides)
        : reflected_(reflected),
          vertex_(vertex),
          normal_(in_face_frame(vertex.brdf.normal, int(face))),
          mirror_(in_face_frame(vertex.brdf.mirror, int(face))),
          to_eye_(in_face_frame(vertex.to_eye, int(face))),
          across_(in_face_frame(vertex.across, int(face))),
          sides_(sides) {
        sides.clear();
        for (const Vec3f& side : vertex.visibility.cones.sides)
            sides.push_back(in_face_frame(side, int(face)));
    }

    /// Tests whether a face lies below a horizon.
    static bool is_dark(const Vec3f& normal, std::size_t face) {
        const Vec3f n = in_face_frame(normal, int(face));
        return n.z + std::abs(n.x) + std::abs(n.y) <= 0;
    }

    BlockAhead root() const {
        return {true, !vertex_.visibility.cones.end.empty(), (1u << vertex_.specular_lobes().size()) - 1u, 0};
    }

    HWY_INLINE Head operator()(int level, std::size_t face, std::size_t block, const Ahead& ahead) const {
        Head head;
        evaluate(level, face, block, ahead, head);
        return head;
    }

    /// Evaluates a block of the last level: only its values.
    HWY_INLINE typename Reflected::Values last(int level, std::size_t face, std::size_t block,
                                               const Ahead& ahead) const {
        typename Reflected::Values values;
        evaluate(level, face, block, ahead, values);
        return values;
    }

    /// Bounds the deviation of the head from its value within each cell of a block above the last level. The
    /// deviation of lighting is stored in the pyramid. The cosine of unit vectors with a mean of length l has
    /// a variance of at most 1 - l^2, and clamping does not increase it. Where the horizon crosses a cell,
    /// the mean may err by the extent. A lobe that is not curved lies below PreparedVertex::varies and below
    /// its value at the cell.
    HWY_INLINE HeadErrors errors(int level, std::size_t face, std::size_t block, const Ahead& ahead) const {
        const auto at = std::size_t(level);
        const BlockDirections d(vertex_.directions.block(level, block));
        const Cells cosine = d.dot(normal_), aligned = d.dot(mirror_);
        const unsigned horizon = ahead.at_horizon ? cells_above(cosine, -vertex_.margin[at]) &
                                                        ~cells_above(cosine, vertex_.margin[at])
                                                  : 0;
        const Rgb diffuse = Reflected::is_separate ? Rgb(0.0f) : vertex_.brdf.diffuse;
        const Rgb& specular = vertex_.brdf.specular;
        const Cells diffuse_peak = all_cells(std::max({diffuse.x, diffuse.y, diffuse.z}));
        const Cells spread = d.spread(), at_horizon = only(horizon, d.extent());
        const Cells cosine_deviation = square_root(spread * (all_cells(2) - spread)) + at_horizon;
        HeadErrors result;
        Cells bound = all_cells(0);
        const float specular_peak = std::max({specular.x, specular.y, specular.z});
        float constant = 0;  // Sum of the lobes with exponent 0.
        for (std::size_t i = 0; i < vertex_.specular_lobes().size(); ++i) {
            const SpecularLobe& lobe = vertex_.specular_lobes()[i];
            if (lobe.exponent == 0) {
                constant += specular_peak * lobe.weight;
                continue;
            }
            Cells most = all_cells(vertex_.varies);
            if (ahead.specular_lobes >> i & 1u) {
                most = larger(lobe_cells(lobe, d, cosine, aligned), most);
                result.unbounded |= cells_above(aligned, lobe.curved[at]);
            }
            bound = multiply_add(all_cells(specular_peak * lobe.weight), most, bound);
        }
        if (ahead.may_be_covered) {
            Cells open = all_cells(1);
            unsigned wholly = 0;
            block_near(d, level, block, open, result.unbounded, wholly);
        }
        const LightPyramid& lighting = reflected_.light;
        const std::size_t index = lighting.numbers()(level, face, block);
        const LightBlock& light = lighting.block(index);
        const Cells light_deviation = load_cells(lighting.deviation(index).data());
        const Cells light_size = magnitude(load_cells(light.red.data())) +
                                 magnitude(load_cells(light.green.data())) +
                                 magnitude(load_cells(light.blue.data()));
        const Cells largest =
            diffuse_peak * (larger(cosine, all_cells(0)) + all_cells(2 * vertex_.margin[at])) + bound +
            all_cells(constant);
        // An indicator function deviates by at most a half; its product with smaller weights deviates by
        // less.
        const Cells constant_deviation = vertex_.brdf.cosine_weighted ? all_cells(constant) * cosine_deviation
                                                                      : only(horizon, all_cells(constant));
        const Cells deviation = diffuse_peak * cosine_deviation + bound + constant_deviation;
        result.deviation = light_deviation * largest + light_size * deviation;
        return result;
    }

private:
    /// True for the last level, which evaluates Reflected::Values instead of a complete Head.
    template <class Result>
    static constexpr bool is_last = !std::is_same_v<Result, Head>;

    template <class Result>
    HWY_INLINE void evaluate(int level, std::size_t face, std::size_t block, const Ahead& ahead,
                             Result& result) const {
        if constexpr (Reflected::holds_cosine)
            if (level > 1 && !ahead.may_be_covered && ahead.specular_lobes == 0) {
                if constexpr (!is_last<Result>) {
                    result.held.fill(ahead.held_cosine);
                    result.below.at_horizon = all_sixteen;
                }
                ReflectedCells cells;
                cells.diffuse = all_cells(ahead.held_cosine);
                reflected_.template write<is_last<Result>>(vertex_, cells, level, face, block, result);
                return;
            }
        const BlockDirections d(vertex_.directions.block(level, block));
        if constexpr (is_last<Result>)
            if (ahead.is_plain()) {
                ReflectedCells cells;
                const Cells cosine = d.dot(normal_);
                cells.diffuse = cosine - cosine * d.spread();
                reflected_.template write<true>(vertex_, cells, level, face, block, result);
                return;
            }
        evaluate_fully(level, face, block, d, ahead, result);
    }

    template <class Result>
    HWY_INLINE void evaluate_fully(int level, std::size_t face, std::size_t block, const BlockDirections& d,
                                   const Ahead& ahead, Result& result) const {
        const auto at = std::size_t(level);
        Cells open = all_cells(1);
        unsigned half_blocked = 0;
        const bool has_cones =
            ahead.may_be_covered && block_near(d, level, block, open, half_blocked, result.zero);
        if (result.zero == all_sixteen) return;

        const Cells cosine = d.dot(normal_);
        unsigned not_below = all_sixteen, horizon = 0;
        if (ahead.at_horizon) {
            not_below = cells_above(cosine, -vertex_.margin[at]);
            horizon = not_below & ~cells_above(cosine, vertex_.margin[at]);
            result.zero |= ~not_below & all_sixteen;
        }
        ReflectedCells cells;
        cells.cosine = cells.diffuse = clamped_cosine(d, cosine, horizon);
        if constexpr (Reflected::holds_cosine) {
            if (level > 1) cells.diffuse = all_cells(ahead.held_cosine);
            if constexpr (!is_last<Result>) store_cells(cells.diffuse, result.held.data());
        }
        unsigned curved = 0;
        if (ahead.specular_lobes != 0) {
            CellsAhead below;
            cells.has_specular =
                add_specular(level, d, cosine, ahead.specular_lobes, cells.specular_lobes, curved, below);
            if constexpr (!is_last<Result>) result.below = below;
        }
        if (cells.has_specular) {
            cells.specular_lobes =
                cells.specular_lobes *
                (vertex_.brdf.cosine_weighted ? cells.cosine : share_above(d, cosine, horizon));
            if (vertex_.is_metallic) cells.loss = metallic_loss(cosine);
        }
        if (has_cones) {
            cells.diffuse = cells.diffuse * open;
            cells.specular_lobes = cells.specular_lobes * open;
        }
        if constexpr (!is_last<Result>)
            cells.open_above = not_below & ~(horizon | half_blocked | result.zero);
        const LitCells lit =
            reflected_.template write<is_last<Result>>(vertex_, cells, level, face, block, result);
        if constexpr (!is_last<Result>) {
            // Below the root the cosine is almost constant, or close to zero. That does not suffice where the
            // light is concentrated; there, the light's moments contain the cosine, except at the horizon.
            const unsigned steep = not_below & (level == 0 ? all_sixteen : lit.uneven);
            curved &= not_below;
            const unsigned reflecting = steep | curved;
            result.once = lit.varying | reflecting | half_blocked;
            result.twice = (lit.uneven & not_below & ~cells.open_above) | (lit.beside_specular & curved) |
                           ((lit.varying | reflecting) & half_blocked);
            result.below.at_horizon = horizon;
            result.below.may_be_covered = half_blocked;
        }
    }

    /// Returns the centre of a block below the root.
    HWY_INLINE Vec3f middle(int level, std::size_t block) const {
        const DirectionBlock& above = vertex_.directions.block(level - 1, block / wide_cells);
        const std::size_t cell = block % wide_cells;
        return {above.x[cell], above.y[cell], above.z[cell]};
    }

    /// Adds the specular lobes where they may be nonzero. Returns false if all are zero in the whole block.
    /// `curved`: the cells in which a lobe varies.
    HWY_INLINE bool add_specular(int level, const BlockDirections& d, const Cells& cosine, unsigned may_be_in,
                                 Cells& sum, unsigned& curved, CellsAhead& below) const {
        const auto at = std::size_t(level);
        const Cells aligned = d.dot(mirror_);
        bool found = false;
        for (std::size_t i = 0; i < vertex_.specular_lobes().size(); ++i) {
            if ((may_be_in >> i & 1u) == 0) continue;
            const SpecularLobe& lobe = vertex_.specular_lobes()[i];
            const unsigned near = cells_above(aligned, lobe.near[at]);
            if (near == 0) continue;
            below.specular_lobes[i] = near;
            sum = multiply_add(all_cells(lobe.weight), lobe_cells(lobe, d, cosine, aligned), sum);
            curved |= cells_above(aligned, lobe.curved[at]);
            found = true;
        }
        return found;
    }

    /// Computes the mean of max(0, N.w) over the cells. Where the horizon crosses a cell, the cosine is
    /// assumed uniformly distributed within +-extent of its mean.
    HWY_INLINE Cells clamped_cosine(const BlockDirections& d, const Cells& cosine, unsigned horizon) const {
        const Cells zero = all_cells(0);
        Cells value = larger(cosine, zero);
        if (horizon != 0) {
            const Cells extent = d.extent(), over = larger(cosine + extent, zero);
            const Cells crossed = over * over * all_cells(0.25f) * d.inverse_extent();
            // For cells entirely above, the parabola is beyond its tangent point.
            value = choose(cells_above(extent - cosine, 0), crossed, value);
        }
        return value - value * d.spread();
    }

    /// Returns the fraction of each cell above a plane through the vertex: mean of [cosine > 0].
    static HWY_INLINE Cells share_above(const BlockDirections& d, const Cells& cosine, unsigned crossed) {
        const Cells one = all_cells(1);
        if (crossed == 0) return only(cells_above(cosine, 0), one);
        const Cells half = all_cells(0.5f);
        return smaller(larger(half * cosine * d.inverse_extent() + half, all_cells(0)), one);
    }

    /// Computes the mean of a lobe over the cells.
    HWY_INLINE Cells lobe_cells(const SpecularLobe& lobe, const BlockDirections& d, const Cells& cosine,
                                const Cells& aligned) const {
        return lobe_mean<Cells>(lobe, CellsOfLobe{d, cosine, aligned, to_eye_, across_, normal_});
    }

    /// Computes 1 - F of a metal, metallic_fresnel: within 2e-4.
    static HWY_INLINE Cells metallic_loss(const Cells& cosine) {
        // Angle of incidence by Abramowitz and Stegun 4.4.45.
        const Cells one = all_cells(1), c = smaller(larger(cosine, all_cells(0)), one);
        Cells root = all_cells(-0.0187293f);
        for (const float term : {0.0742610f, -0.2121144f, 1.5707288f})
            root = multiply_add(root, c, all_cells(term));
        const Cells from_pole = all_cells(1.12f) - square_root(one - c) * root * all_cells(float(2 / pi));
        const Cells fresnel = all_cells(0.014567225f) / (from_pole * from_pole) - all_cells(0.011612903f);
        return one - smaller(larger(fresnel, all_cells(0)), one);
    }

    /// Computes the fraction of each cell that nearby occluders leave unoccluded, the cells that they cover
    /// partly, and those that they cover entirely. Returns false if no occluder is near the block.
    HWY_INLINE bool block_near(const BlockDirections& d, int level, std::size_t block, Cells& open,
                               unsigned& partly, unsigned& wholly) const {
        const float margin = vertex_.margin[std::size_t(level)];
        bool found = false;
        Cells blocked = all_cells(0);
        std::uint32_t first = 0;
        for (const std::uint32_t end : vertex_.visibility.cones.end) {
            const std::span<const Vec3f> sides(sides_.data() + first, end - first);
            first = end;
            if (level > 0) {
                const CellsCovered whole =
                    covered(middle(level, block), vertex_.margin[std::size_t(level) - 1], sides);
                if (whole == CellsCovered::none) continue;
                if (whole == CellsCovered::all) {
                    wholly = all_sixteen;
                    return true;
                }
            }
            found = true;
            Cells share = all_cells(1);
            unsigned inside = all_sixteen, outside = 0;
            for (const Vec3f& side : sides) {
                const Cells height = d.dot(side);
                const unsigned in = cells_above(height, margin), touched = cells_above(height, -margin);
                inside &= in;
                outside |= ~touched & all_sixteen;
                share = share * share_above(d, height, touched & ~in);
            }
            blocked = blocked + share;
            wholly |= inside;
            partly |= all_sixteen & ~(inside | outside);
        }
        partly &= ~wholly;
        open = larger(all_cells(1) - blocked, all_cells(0));
        return found;
    }

    enum class CellsCovered { none, some, all };

    /// Tests a whole block against one cone.
    static CellsCovered covered(const Vec3f& middle, float margin, std::span<const Vec3f> sides) {
        bool all = true;
        for (const Vec3f& side : sides) {
            const float height = side.dot(middle);
            if (height < -margin) return CellsCovered::none;
            all &= height > margin;
        }
        return all ? CellsCovered::all : CellsCovered::some;
    }

    const Reflected& reflected_;
    const PreparedVertex& vertex_;
    const Vec3f normal_, mirror_, to_eye_;
    const Vec3f across_;         ///< Normal of the plane of incidence.
    std::vector<Vec3f>& sides_;  ///< Sides of the cones, in the face's frame.
};

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
