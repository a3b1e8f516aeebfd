#include "shading/vertex_shading.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/vertex_shading.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/wavelet_blocks-inl.h"

#ifndef HAARFIELD_VERTEX_SHADING_ONCE
#define HAARFIELD_VERTEX_SHADING_ONCE

namespace haarfield {

/// Below this share of its peak a lobe is zero;
inline constexpr float lobe_zero = 1e-3f;
/// and from this on it varies where its cell is not the finest,
inline constexpr float lobe_varies = 4e-3f;
/// or, of terms that are to be pruned, from this on.
inline constexpr float lobe_of_terms_varies = 0.03f;

/// One of a vertex's highlights, and where it has to be looked for.
struct Highlight {
    float weight = 0, exponent = 1;  ///< To the power of zero it is 1 everywhere.
    bool about_half_vector = false;
    /// By level: the cosines, between mirror and middle of a cell, above which the lobe is not zero somewhere
    /// in it, and above which it varies.
    std::array<float, 4> near{}, curved{};

    Highlight() = default;
    Highlight(float of_weight, float to_power, bool of_half_vector, const DirectionPyramid& directions,
              int last_level, float varies)
        : weight(of_weight), exponent(to_power), about_half_vector(of_half_vector) {
        near.fill(exponent == 0 ? -2.0f : 0.0f);
        curved.fill(2);
        if (exponent == 0) return;
        // The mirror direction turns twice as far as the half vector.
        const float turn = about_half_vector ? 2 : 1;
        const float zero_at = turn * std::acos(std::pow(lobe_zero, 1 / exponent)),
                    curved_at = turn * std::acos(std::pow(varies, 1 / exponent));
        for (int level = 0; level <= last_level; ++level) {
            const float radius = directions.radius(level);
            near[std::size_t(level)] = std::cos(std::min(zero_at + radius, float(pi)));
            curved[std::size_t(level)] = std::cos(std::min(curved_at + radius, float(pi)));
        }
    }
};

/// What all faces and blocks of a vertex share.
struct VertexTerms {
    const DirectionPyramid& directions;
    const VertexBrdf& brdf;
    const BlockedCones& near;
    int last_level;
    bool is_metallic;
    Vec3f to_eye;
    std::array<float, 4>
        margin{};  ///< By level: sine of the largest angle from a cell's middle to its border.
    /// By level: a highlight times the light's deviation in a cell, over the mean of the light. What is less
    /// changes less than a thousandth of what the highlights reflect of even light.
    std::array<float, 4> negligible{};

    VertexTerms(const DirectionPyramid& pyramid, const VertexBrdf& what, const BlockedCones& cones, int last,
                float varies = lobe_varies)
        : directions(pyramid),
          brdf(what),
          near(cones),
          last_level(last),
          is_metallic(what.metallic != Rgb(0.0f)),
          to_eye(what.normal * (2 * what.normal.dot(what.mirror)) - what.mirror) {
        if (what.specular != Rgb(0.0f)) {
            if (what.phong > 0)
                highlights_[highlight_count_++] = {what.phong, what.shininess, false, pyramid, last, varies};
            if (what.blinn > 0)
                highlights_[highlight_count_++] = {what.blinn, what.blinn_exponent, true, pyramid, last,
                                                   varies};
        }
        float energy = 0;  // mean over the sphere; the half vector turns half as far
        for (const Highlight& highlight : highlights())
            energy += highlight.weight * (highlight.about_half_vector ? 4.0f : 1.0f) /
                      (2 * (highlight.exponent + 1));
        for (int level = 0; level <= last; ++level) {
            margin[std::size_t(level)] = std::sin(directions.radius(level));
            const auto cells = static_cast<float>(cubemap_faces << (4 * (level + 1)));
            negligible[std::size_t(level)] = 1e-3f * energy * cells;
        }
    }

    std::span<const Highlight> highlights() const { return {highlights_.data(), highlight_count_}; }

private:
    std::array<Highlight, 2> highlights_;
    std::size_t highlight_count_ = 0;
};

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// The directions of a block, at hand.
struct BlockDirections {
    Cells x, y, z, extent, inverse_extent;

    explicit BlockDirections(const DirectionBlock& block)
        : x(load_cells(block.x.data())),
          y(load_cells(block.y.data())),
          z(load_cells(block.z.data())),
          extent(load_cells(block.extent.data())),
          inverse_extent(load_cells(block.inverse_extent.data())) {}

    /// What the mean direction lacks of unit length.
    HWY_INLINE Cells spread() const { return extent * extent * all_cells(1.0f / 3); }

    /// Products and sums, not fused: what is decided by them is the same for all instruction sets.
    HWY_INLINE Cells dot(const Vec3f& v) const {
        return all_cells(v.x) * x + all_cells(v.y) * y + all_cells(v.z) * z;
    }
};

/// A BRDF over a block's cells, without its colours.
struct ReflectedCells {
    Cells cosine;      ///< Clamped.
    Cells diffuse;     ///< The cosine, as diffuse light takes it: see Reflected::holds_cosine.
    Cells highlights;  ///< With what they are weighted by; if there are any.
    Cells loss;        ///< What a metal takes from them, if it is one.
    bool has_highlights = false;
};

/// The cells of a block on which the light varies; and of these those where that matters for highlights.
struct LitCells {
    unsigned varying = 0, beside_highlights = 0;
};

/// What reflects light: with the materials' colours, times the lighting.
struct LitColours {
    using Head = HeadCells<3>;
    static constexpr bool holds_cosine = false;

    const LightPyramid& light;

    HWY_INLINE LitCells write(const VertexTerms& terms, const ReflectedCells& cells, int level,
                              std::size_t face, std::size_t block, Head& head) const {
        const Rgb &diffuse = terms.brdf.diffuse, &specular = terms.brdf.specular;
        Cells reflected[3];
        for (int c = 0; c < 3; ++c) reflected[c] = all_cells(diffuse[c]) * cells.diffuse;
        if (cells.has_highlights)
            for (int c = 0; c < 3; ++c) {
                Cells colour = all_cells(specular[c]);
                if (terms.is_metallic)
                    colour = colour - colour * all_cells(terms.brdf.metallic[c]) * cells.loss;
                reflected[c] = multiply_add(colour, cells.highlights, reflected[c]);
            }
        const std::size_t index = light.numbers()(level, face, block);
        const LightBlock& lit = light.block(index);
        head.value[0] = load_cells(lit.red.data()) * reflected[0];
        head.value[1] = load_cells(lit.green.data()) * reflected[1];
        head.value[2] = load_cells(lit.blue.data()) * reflected[2];
        const unsigned varying = light.varying(index);
        if (level == 0 || varying == 0) return {varying, varying};
        LitCells result{varying, 0};
        if (cells.has_highlights)
            result.beside_highlights =
                varying & cells_above(cells.highlights * load_cells(light.deviation(index).data()),
                                      terms.negligible[std::size_t(level)] * light.mean_size());
        return result;
    }
    unsigned uneven(int level, std::size_t face, std::size_t block) const {
        return light.uneven(light.numbers()(level, face, block));
    }
};

/// The same of the highlights, and aside of them what is reflected diffusely.
struct LitHighlights : LitColours {
    struct Head : HeadCells<3> {
        Cells diffuse[3];
    };

    Rgb diffuse;

    HWY_INLINE LitCells write(const VertexTerms& terms, const ReflectedCells& cells, int level,
                              std::size_t face, std::size_t block, Head& head) const {
        const LightBlock& lit = light.block(light.numbers()(level, face, block));
        head.diffuse[0] = load_cells(lit.red.data()) * (all_cells(diffuse.x) * cells.diffuse);
        head.diffuse[1] = load_cells(lit.green.data()) * (all_cells(diffuse.y) * cells.diffuse);
        head.diffuse[2] = load_cells(lit.blue.data()) * (all_cells(diffuse.z) * cells.diffuse);
        return LitColours::write(terms, cells, level, face, block, head);
    }
};

/// What reflects light: by term, see vertex_terms.
template <int term_count>
struct PlainTerms {
    using Head = HeadCells<term_count>;
    static constexpr bool holds_cosine = true;

    HWY_INLINE LitCells write(const VertexTerms& terms, const ReflectedCells& cells, int, std::size_t,
                              std::size_t, Head& head) const {
        head.value[0] = cells.diffuse;
        for (int term = 1; term < term_count; ++term)
            head.value[term] = cells.has_highlights ? cells.highlights : all_cells(0);
        if constexpr (term_count == 3) {
            if (!terms.is_metallic) head.value[2] = all_cells(0);
            if (cells.has_highlights && terms.is_metallic)
                head.value[2] = cells.highlights - cells.highlights * cells.loss;
        }
        return {};
    }
    unsigned uneven(int, std::size_t, std::size_t) const { return 0; }
};

/// What reflects light, times what is seen past the near occluders, on one face.
///
/// Reflected  LitCells write(terms, cells, level, face, block, head): writes its channels.
///            unsigned uneven(level, face, block): see LightPyramid.
///            holds_cosine: whether the cosine of diffuse light is constant over the cells of level 1.
///            Head: HeadCells, and what else its sink wants.
template <class Reflected>
class FaceShading {
public:
    using Head = typename Reflected::Head;

    FaceShading(const Reflected& reflected, const VertexTerms& terms, std::size_t face,
                std::vector<Vec3f>& sides)
        : reflected_(reflected),
          terms_(terms),
          normal_(in_face_frame(terms.brdf.normal, int(face))),
          mirror_(in_face_frame(terms.brdf.mirror, int(face))),
          to_eye_(in_face_frame(terms.to_eye, int(face))),
          across_(normal_.cross(to_eye_).normalized()),
          sides_(sides) {
        sides.clear();
        for (const Vec3f& side : terms.near.sides) sides.push_back(in_face_frame(side, int(face)));
    }

    /// Whether the face lies below the horizon.
    bool is_dark() const { return normal_.z + std::abs(normal_.x) + std::abs(normal_.y) <= 0; }

    HWY_INLINE Head operator()(int level, std::size_t face, std::size_t block) const {
        const auto at = std::size_t(level);
        const bool last = level == terms_.last_level;
        Head head;
        if constexpr (Reflected::holds_cosine)
            if (level > 1 && terms_.near.end.empty() && !may_have_highlights(level, block)) {
                head.value[0] = all_cells(held_cosine(level, block));
                for (int c = 1; c < Head::channels; ++c) head.value[c] = all_cells(0);
                return head;
            }
        Cells open = all_cells(1);
        unsigned half_blocked = 0;
        const BlockDirections d(terms_.directions.block(level, block));
        const bool has_cones =
            !terms_.near.end.empty() && block_near(d, level, block, open, half_blocked, head.zero);
        if (head.zero == all_sixteen) return head;

        const Cells cosine = d.dot(normal_);
        const unsigned above = cells_above(cosine, terms_.margin[at]),
                       not_below = cells_above(cosine, -terms_.margin[at]);
        const unsigned horizon = not_below & ~above;
        head.zero |= ~not_below & all_sixteen;
        // Below the root the cosine hardly varies, or is next to nothing; which matters where all the light
        // is.
        const unsigned steep = last         ? 0
                               : level == 0 ? not_below
                                            : not_below & reflected_.uneven(level, face, block);
        ReflectedCells cells;
        cells.cosine = cells.diffuse = clamped_cosine(d, cosine, horizon);
        if constexpr (Reflected::holds_cosine)
            if (level > 1) cells.diffuse = all_cells(held_cosine(level, block));
        cells.highlights = all_cells(0);
        unsigned curved = 0;
        cells.has_highlights = add_highlights(level, block, d, cosine, cells.highlights, curved);
        if (cells.has_highlights) {
            cells.highlights = cells.highlights *
                               (terms_.brdf.cosine_weighted ? cells.cosine : share_above(d, cosine, horizon));
            if (terms_.is_metallic) cells.loss = metallic_loss(cosine);
            curved &= last ? 0 : not_below;
        }
        if (has_cones) {
            cells.diffuse = cells.diffuse * open;
            cells.highlights = cells.highlights * open;
        }
        const LitCells lit = reflected_.write(terms_, cells, level, face, block, head);
        const unsigned reflecting = steep | curved;
        head.once = lit.varying | reflecting | half_blocked;
        head.twice = (lit.varying & steep) | (lit.beside_highlights & curved) |
                     ((lit.varying | reflecting) & half_blocked);
        return head;
    }

    /// The head's deviation from its value within each cell of a block above the last level. Lighting
    /// deviates by what the pyramid says. The cosine of unit vectors whose mean has length l has the variance
    /// 1 - l^2 at most, and clamping does not add to it; where the horizon crosses a cell, its mean may be
    /// off by the extent. A lobe that is not curved lies below lobe_varies, and below what the cell says.
    HWY_INLINE HeadErrors errors(int level, std::size_t face, std::size_t block) const {
        const auto at = std::size_t(level);
        const BlockDirections d(terms_.directions.block(level, block));
        const Cells cosine = d.dot(normal_), aligned = d.dot(mirror_);
        const unsigned horizon =
            cells_above(cosine, -terms_.margin[at]) & ~cells_above(cosine, terms_.margin[at]);
        const Rgb &diffuse = terms_.brdf.diffuse, &specular = terms_.brdf.specular;
        const Cells diffuse_peak = all_cells(std::max({diffuse.x, diffuse.y, diffuse.z}));
        const Cells spread = d.spread(), at_horizon = only(horizon, d.extent);
        const Cells cosine_deviation = square_root(spread * (all_cells(2) - spread)) + at_horizon;
        HeadErrors result;
        Cells lobe = all_cells(0);
        const float specular_peak = std::max({specular.x, specular.y, specular.z});
        float constant = 0;  // the sum of lobes to the power of zero
        for (const Highlight& highlight : terms_.highlights()) {
            if (highlight.exponent == 0) {
                constant += specular_peak * highlight.weight;
                continue;
            }
            lobe =
                multiply_add(all_cells(specular_peak * highlight.weight),
                             larger(lobe_cells(highlight, d, cosine, aligned), all_cells(lobe_varies)), lobe);
            result.unbounded |= cells_above(aligned, highlight.curved[at]);
        }
        if (!terms_.near.end.empty()) {
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
            diffuse_peak * (larger(cosine, all_cells(0)) + all_cells(2 * terms_.margin[at])) + lobe +
            all_cells(constant);
        // An indicator deviates by a half at most, and so does what it is weighted with less.
        const Cells constant_deviation = terms_.brdf.cosine_weighted ? all_cells(constant) * cosine_deviation
                                                                     : only(horizon, all_cells(constant));
        const Cells deviation = diffuse_peak * cosine_deviation + lobe + constant_deviation;
        result.deviation = light_deviation * largest + light_size * deviation;
        result.mean_error = light_deviation * deviation +
                            light_size * (diffuse_peak * at_horizon + lobe + constant_deviation);
        return result;
    }

private:
    /// The middle of a block below the root.
    HWY_INLINE Vec3f middle(int level, std::size_t block) const {
        const DirectionBlock& above = terms_.directions.block(level - 1, block / wide_cells);
        const std::size_t cell = block % wide_cells;
        return {above.x[cell], above.y[cell], above.z[cell]};
    }

    /// Whether a lobe is not zero somewhere in a block below the root.
    HWY_INLINE bool may_be_in(const Highlight& highlight, int level, std::size_t block) const {
        return middle(level, block).dot(mirror_) > highlight.near[std::size_t(level) - 1];
    }
    HWY_INLINE bool may_have_highlights(int level, std::size_t block) const {
        for (const Highlight& highlight : terms_.highlights())
            if (may_be_in(highlight, level, block)) return true;
        return false;
    }

    /// Adds the lobes, where they are not zero; false if they are so in the whole block. `curved`: the cells
    /// in which one of them varies.
    HWY_INLINE bool add_highlights(int level, std::size_t block, const BlockDirections& d,
                                   const Cells& cosine, Cells& sum, unsigned& curved) const {
        const auto at = std::size_t(level);
        bool found = false;
        for (const Highlight& highlight : terms_.highlights()) {
            if (level > 0 && !may_be_in(highlight, level, block)) continue;
            const Cells aligned = d.dot(mirror_);
            if (cells_above(aligned, highlight.near[at]) == 0) continue;
            sum = multiply_add(all_cells(highlight.weight), lobe_cells(highlight, d, cosine, aligned), sum);
            curved |= cells_above(aligned, highlight.curved[at]);
            found = true;
        }
        return found;
    }

    /// Mean over the cells of max(0, N.w). Where the horizon crosses a cell the cosine is taken as uniformly
    /// distributed over -extent to extent about its mean.
    HWY_INLINE Cells clamped_cosine(const BlockDirections& d, const Cells& cosine, unsigned horizon) const {
        const Cells zero = all_cells(0);
        Cells value = larger(cosine, zero);
        if (horizon != 0) {
            const Cells over = larger(cosine + d.extent, zero);
            const Cells crossed = over * over * all_cells(0.25f) * d.inverse_extent;
            // Where it lies wholly above, the parabola has passed its tangent point.
            value = choose(cells_above(d.extent - cosine, 0), crossed, value);
        }
        return value - value * d.spread();
    }

    /// clamped_cosine of the cell of level 1 that a block lies in.
    HWY_INLINE float held_cosine(int level, std::size_t block) const {
        const std::size_t path = block >> (4 * (level - 2));
        const DirectionBlock& d = terms_.directions.block(1, path / wide_cells);
        const std::size_t cell = path % wide_cells;
        const float extent = d.extent[cell],
                    cosine = normal_.x * d.x[cell] + normal_.y * d.y[cell] + normal_.z * d.z[cell],
                    over = std::max(cosine + extent, 0.0f),
                    clamped = cosine < extent ? over * over * 0.25f * d.inverse_extent[cell] : cosine;
        return clamped - clamped * (extent * extent * (1.0f / 3));
    }

    /// The share of the cells that a plane through the vertex leaves above it: mean of [cosine > 0].
    static HWY_INLINE Cells share_above(const BlockDirections& d, const Cells& cosine, unsigned crossed) {
        const Cells one = all_cells(1);
        if (crossed == 0) return only(cells_above(cosine, 0), one);
        const Cells half = all_cells(0.5f);
        return smaller(larger(half * cosine * d.inverse_extent + half, all_cells(0)), one);
    }

    /// Mean over the cells of a lobe; see vertex_shading.h.
    HWY_INLINE Cells lobe_cells(const Highlight& highlight, const BlockDirections& d, const Cells& cosine,
                                const Cells& aligned) const {
        if (highlight.exponent == 0) return all_cells(1);
        const Cells n = all_cells(highlight.exponent), one = all_cells(1);
        const Cells energy = all_cells(1 / (highlight.exponent + 1));
        if (!highlight.about_half_vector) {
            const Cells m = n / (one + n * d.spread());
            return (m + one) * energy * exponential(m * logarithm_near_one(aligned));
        }
        // |V + w| = 2 V.H, and with it N.H and the part of H across the plane of incidence.
        const Cells two = all_cells(2), square = larger(two + two * d.dot(to_eye_), all_cells(1e-4f));
        const Cells inverse = one / square_root(square);
        const Cells height = (cosine + all_cells(normal_.dot(to_eye_))) * inverse;
        const Cells across = d.dot(across_) * inverse;
        const Cells share_across =
            smaller(across * across / larger(one - height * height, all_cells(1e-6f)), one);
        const Cells m = n / (one + n * d.spread() * all_cells(0.25f)),
                    m_across = n / (one + n * d.spread() / square);
        return square_root((m + one) * (m_across + one)) * energy *
               exponential((m + (m_across - m) * share_across) * logarithm_near_one(height));
    }

    /// 1 - F of a metal, metallic_fresnel: within 2e-4.
    static HWY_INLINE Cells metallic_loss(const Cells& cosine) {
        // The angle of incidence by Abramowitz and Stegun 4.4.45.
        const Cells one = all_cells(1), c = smaller(larger(cosine, all_cells(0)), one);
        Cells root = all_cells(-0.0187293f);
        for (const float term : {0.0742610f, -0.2121144f, 1.5707288f})
            root = multiply_add(root, c, all_cells(term));
        const Cells from_pole = all_cells(1.12f) - square_root(one - c) * root * all_cells(float(2 / pi));
        const Cells fresnel = all_cells(0.014567225f) / (from_pole * from_pole) - all_cells(0.011612903f);
        return one - smaller(larger(fresnel, all_cells(0)), one);
    }

    /// What the near occluders leave open of each cell; the cells that they cover in part, and those that
    /// they cover wholly. False if they are nowhere near the block.
    HWY_INLINE bool block_near(const BlockDirections& d, int level, std::size_t block, Cells& open,
                               unsigned& partly, unsigned& wholly) const {
        const float margin = terms_.margin[std::size_t(level)];
        bool found = false;
        Cells blocked = all_cells(0);
        std::uint32_t first = 0;
        for (const std::uint32_t end : terms_.near.end) {
            const std::span<const Vec3f> sides(sides_.data() + first, end - first);
            first = end;
            if (level > 0) {
                const CellsCovered whole =
                    covered(middle(level, block), terms_.margin[std::size_t(level) - 1], sides);
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

    /// A whole block against one cone.
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
    const VertexTerms& terms_;
    const Vec3f normal_, mirror_, to_eye_;
    const Vec3f across_;         ///< The plane of incidence.
    std::vector<Vec3f>& sides_;  ///< Of the cones, in the face's frame.
};

struct RadianceSum {
    static constexpr unsigned needed = 2;
    static constexpr bool may_prune = true, may_blur = false;
    static constexpr float cell_share = 1.0f / wide_cells;

    Cells sum[3];
    float negligible, error = 0;  ///< See Walk.

    explicit RadianceSum(float negligible_error) : negligible(negligible_error) {
        for (Cells& channel : sum) channel = all_cells(0);
    }
    bool needs_bounds() const { return negligible > 0; }
    Rgb total() const { return Rgb(sum_of(sum[0]), sum_of(sum[1]), sum_of(sum[2])); }
    HWY_INLINE void visit(int, std::size_t, std::size_t, unsigned done, const Cells& product,
                          const HeadCells<3>& head) {
        const Cells share = only(done, product);
        for (int c = 0; c < 3; ++c) sum[c] = multiply_add(share, head.value[c], sum[c]);
    }
};

/// Walks all faces.
RadianceSum walked(const LightPyramid& light, const VertexTerms& terms,
                   std::span<const WeightedTrees<std::uint8_t>> visibilities, const Depth& depth,
                   float negligible, WalkMemory<std::uint8_t>& memory) {
    const LitColours reflected{light};
    RadianceSum sum(negligible);
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const FaceShading shading(reflected, terms, face, memory.sides);
        if (shading.is_dark()) continue;
        const FaceFactors factors = list_factors(visibilities, face, memory.varying[0]);
        if (factors.constant == 0) continue;
        Walk<std::uint8_t, FaceShading<LitColours>, RadianceSum> walk(shading, sum, memory, depth);
        walk.visit(0, face, 0, factors.constant * RadianceSum::cell_share);
    }
    return sum;
}

float size_of(const Rgb& radiance) {
    return std::abs(radiance.x) + std::abs(radiance.y) + std::abs(radiance.z);
}

Rgb radiance(const LightPyramid& light, const DirectionPyramid& directions, const VertexBrdf& brdf,
             const BlockedCones& near, std::span<const WeightedTrees<std::uint8_t>> visibilities, int depth,
             WalkMemory<std::uint8_t>& memory, float tolerance) {
    const int face_levels = light.numbers().levels();
    const Depth levels(depth, face_levels);
    const VertexTerms terms(directions, brdf, near, levels.levels - 1);
    if (tolerance > 0 && levels.levels > 1) {
        // Of a coarse guess at the radiance, each of some hundred cells may spoil its share; the sum of the
        // bounds is checked against what is found, and where it is too much the cells may spoil less.
        const VertexTerms coarse(directions, brdf, near, 0);
        const Rgb guess = walked(light, coarse, visibilities, Depth(2, face_levels), 0, memory).total();
        float negligible = tolerance * size_of(guess) / 128;
        for (int trial = 0; trial < 3 && negligible > 0; ++trial, negligible /= 8) {
            const RadianceSum sum = walked(light, terms, visibilities, levels, negligible, memory);
            const Rgb total = sum.total();
            // The full walk's result is at least this less the error, so this is enough:
            if (sum.error <= tolerance * (size_of(total) - sum.error)) return total;
        }
    }
    return walked(light, terms, visibilities, levels, 0, memory).total();
}

/// Writes the highlights, and adds up what is reflected diffusely.
struct HighlightWriter : BlockWriter<3, true> {
    Cells diffuse[3];

    HighlightWriter(const BlockNumbers& of_blocks, std::vector<WaveletBlock<3>>& to,
                    const DetailWeights* details)
        : BlockWriter{of_blocks, to, details} {
        for (Cells& channel : diffuse) channel = all_cells(0);
    }
    Rgb total() const { return Rgb(sum_of(diffuse[0]), sum_of(diffuse[1]), sum_of(diffuse[2])); }
    HWY_INLINE void visit(int level, std::size_t face, std::size_t block, unsigned done, const Cells& product,
                          const LitHighlights::Head& head) {
        static constexpr float cell_of_level[] = {0x1p-4f, 0x1p-8f, 0x1p-12f, 0x1p-16f};
        const Cells share = only(done, product) * all_cells(cell_of_level[level]);
        for (int c = 0; c < 3; ++c) diffuse[c] = multiply_add(share, head.diffuse[c], diffuse[c]);
        BlockWriter::visit(level, face, block, done, product, head);
    }
};

/// Writes what is reflected, times what is seen.
template <class Writer, class Reflected>
void write_product(const Reflected& reflected, const VertexTerms& terms,
                   std::span<const WeightedTrees<std::uint8_t>> visibilities, const Depth& depth,
                   WalkMemory<std::uint8_t>& memory, Writer& writer) {
    writer.blocks.clear();
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const FaceShading shading(reflected, terms, face, memory.sides);
        if (shading.is_dark()) continue;
        const FaceFactors factors = list_factors(visibilities, face, memory.varying[0]);
        if (factors.constant == 0) continue;
        Walk<std::uint8_t, FaceShading<Reflected>, Writer> walk(shading, writer, memory, depth);
        walk.visit(0, face, 0, factors.constant);
    }
    transform_blocks(writer.blocks);
}

double transfer(const LightPyramid& light, const DirectionPyramid& directions, const VertexBrdf& brdf,
                const BlockedCones& near, std::span<const WeightedTrees<std::uint8_t>> visibilities,
                int depth, const DetailWeights* detail, WalkMemory<std::uint8_t>& memory,
                std::vector<WaveletBlock<3>>& product) {
    const Depth levels(depth, light.numbers().levels());
    const VertexTerms terms(directions, brdf, near, levels.levels - 1);
    BlockWriter<3, true> writer{light.numbers(), product, detail};
    write_product(LitColours{light}, terms, visibilities, levels, memory, writer);
    return writer.blurred_energy;
}

double highlight_transfer(const LightPyramid& light, const DirectionPyramid& directions,
                          const VertexBrdf& brdf, const BlockedCones& near,
                          std::span<const WeightedTrees<std::uint8_t>> visibilities, int depth,
                          const DetailWeights* detail, WalkMemory<std::uint8_t>& memory,
                          std::vector<WaveletBlock<3>>& product, Rgb& diffuse) {
    const Depth levels(depth, light.numbers().levels());
    VertexBrdf highlights = brdf;
    highlights.diffuse = Rgb(0.0f);
    const VertexTerms terms(directions, highlights, near, levels.levels - 1);
    HighlightWriter writer(light.numbers(), product, detail);
    write_product(LitHighlights{{light}, brdf.diffuse}, terms, visibilities, levels, memory, writer);
    diffuse = writer.total();
    return writer.blurred_energy;
}

template <int count>
void write_terms(const BlockNumbers& numbers, const DirectionPyramid& directions, const VertexBrdf& brdf,
                 const BlockedCones& near, std::span<const WeightedTrees<std::uint8_t>> visibilities,
                 int depth, WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<count>>& product) {
    const Depth levels(depth, numbers.levels());
    const VertexTerms terms(directions, brdf, near, levels.levels - 1, lobe_of_terms_varies);
    BlockWriter<count> writer{numbers, product};
    write_product(PlainTerms<count>(), terms, visibilities, levels, memory, writer);
}

void two_terms(const BlockNumbers& numbers, const DirectionPyramid& directions, const VertexBrdf& brdf,
               const BlockedCones& near, std::span<const WeightedTrees<std::uint8_t>> visibilities, int depth,
               WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<2>>& product) {
    write_terms(numbers, directions, brdf, near, visibilities, depth, memory, product);
}

void three_terms(const BlockNumbers& numbers, const DirectionPyramid& directions, const VertexBrdf& brdf,
                 const BlockedCones& near, std::span<const WeightedTrees<std::uint8_t>> visibilities,
                 int depth, WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product) {
    write_terms(numbers, directions, brdf, near, visibilities, depth, memory, product);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(radiance);
HWY_EXPORT(transfer);
HWY_EXPORT(highlight_transfer);
HWY_EXPORT(two_terms);
HWY_EXPORT(three_terms);

Rgb vertex_radiance(const LightPyramid& light, const DirectionPyramid& directions, const VertexBrdf& brdf,
                    const BlockedCones& near, std::span<const WeightedTrees<std::uint8_t>> visibilities,
                    int depth, WalkMemory<std::uint8_t>& memory, float tolerance) {
    memory.reserve(visibilities);
    return HWY_DYNAMIC_DISPATCH(radiance)(light, directions, brdf, near, visibilities, depth, memory,
                                          tolerance);
}

double vertex_transfer(const LightPyramid& light, const DirectionPyramid& directions, const VertexBrdf& brdf,
                       const BlockedCones& near, std::span<const WeightedTrees<std::uint8_t>> visibilities,
                       int depth, WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product,
                       const DetailWeights* detail) {
    memory.reserve(visibilities);
    return HWY_DYNAMIC_DISPATCH(transfer)(light, directions, brdf, near, visibilities, depth, detail, memory,
                                          product);
}

double highlight_transfer(const LightPyramid& light, const DirectionPyramid& directions,
                          const VertexBrdf& brdf, const BlockedCones& near,
                          std::span<const WeightedTrees<std::uint8_t>> visibilities, int depth,
                          WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product,
                          Rgb& diffuse, const DetailWeights* detail) {
    memory.reserve(visibilities);
    return HWY_DYNAMIC_DISPATCH(highlight_transfer)(light, directions, brdf, near, visibilities, depth,
                                                    detail, memory, product, diffuse);
}

void vertex_terms(const BlockNumbers& numbers, const DirectionPyramid& directions, const VertexBrdf& brdf,
                  const BlockedCones& near, std::span<const WeightedTrees<std::uint8_t>> visibilities,
                  int depth, WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<2>>& product) {
    memory.reserve(visibilities);
    HWY_DYNAMIC_DISPATCH(two_terms)(numbers, directions, brdf, near, visibilities, depth, memory, product);
}

void vertex_terms(const BlockNumbers& numbers, const DirectionPyramid& directions, const VertexBrdf& brdf,
                  const BlockedCones& near, std::span<const WeightedTrees<std::uint8_t>> visibilities,
                  int depth, WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product) {
    memory.reserve(visibilities);
    HWY_DYNAMIC_DISPATCH(three_terms)(numbers, directions, brdf, near, visibilities, depth, memory, product);
}

}  // namespace haarfield
#endif
