#pragma once
/// What all faces and blocks of a vertex share, while it is shaded.

#include <algorithm>
#include <cassert>
#include <cmath>

#include "shading/walk/vertex_shading.h"

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

    /// Fills in the cosines.
    ///
    /// last_level  of the blocks that are walked.
    /// varies      from this share of its peak on it does.
    void look_for(const DirectionPyramid& directions, int last_level, float varies) {
        near.fill(exponent == 0 ? -2.0f : 0.0f);
        curved.fill(2);
        if (exponent == 0) return;
        const Reach zero(std::pow(lobe_zero, 1 / exponent), about_half_vector),
            varying(std::pow(varies, 1 / exponent), about_half_vector);
        for (int level = 0; level <= last_level; ++level) {
            near[std::size_t(level)] = zero.cosine_beyond(directions, level);
            curved[std::size_t(level)] = varying.cosine_beyond(directions, level);
        }
    }

private:
    /// How far from the mirror direction a lobe has a value.
    struct Reach {
        float sine, cosine;

        /// cosine_of_lobe  of the angle from the lobe's axis; the mirror direction turns twice as far as the
        ///                 half vector.
        Reach(float cosine_of_lobe, bool about_half_vector) {
            const float c = cosine_of_lobe, s = std::sqrt(std::max(1 - c * c, 0.0f));
            sine = about_half_vector ? 2 * s * c : s;
            cosine = about_half_vector ? 2 * c * c - 1 : c;
        }
        /// Of the reach and a cell's radius together; no more than half a turn.
        float cosine_beyond(const DirectionPyramid& directions, int level) const {
            const float s = directions.sine(level), c = directions.cosine(level);
            return sine * c + cosine * s > 0 ? cosine * c - sine * s : -1.0f;
        }
    };
};

/// What all faces and blocks of a vertex share. The ShadedVertex must outlive it.
struct PreparedVertex {
    const DirectionPyramid& directions;
    const VertexBrdf& brdf;
    VertexSight sight;
    float varies;  ///< Of lobes: lobe_varies or lobe_of_terms_varies.
    bool is_metallic;
    Vec3f to_eye;
    Vec3f across;  ///< The plane of incidence: unit length.
    /// By level: sine of the largest angle from a cell's middle to its border.
    std::array<float, 4> margin{};
    /// By level: a highlight times the light's deviation in a cell, over the mean of the light. What is less
    /// changes less than a thousandth of what the highlights reflect of even light.
    std::array<float, 4> negligible{};

    /// last_level  of the blocks that are walked.
    /// lobes_vary  from this share of its peak on a lobe does.
    PreparedVertex(const ShadedVertex& vertex, int last_level, float lobes_vary = lobe_varies)
        : directions(vertex.directions),
          brdf(vertex.brdf),
          sight(vertex.sight),
          varies(lobes_vary),
          is_metallic(brdf.metallic != Rgb(0.0f)),
          to_eye(brdf.normal * (2 * brdf.normal.dot(brdf.mirror)) - brdf.mirror),
          across(brdf.normal.cross(to_eye).normalized()) {
        assert(last_level >= 0);
        if (brdf.specular != Rgb(0.0f)) {
            if (brdf.phong > 0)
                highlights_[highlight_count_++] = {.weight = brdf.phong, .exponent = brdf.shininess};
            if (brdf.blinn > 0)
                highlights_[highlight_count_++] = {
                    .weight = brdf.blinn, .exponent = brdf.blinn_exponent, .about_half_vector = true};
        }
        for (std::size_t i = 0; i < highlight_count_; ++i)
            highlights_[i].look_for(directions, last_level, varies);
        float energy = 0;  // mean over the sphere; the half vector turns half as far
        for (const Highlight& highlight : highlights())
            energy += highlight.weight * (highlight.about_half_vector ? 4.0f : 1.0f) /
                      (2 * (highlight.exponent + 1));
        for (int level = 0; level <= last_level; ++level) {
            margin[std::size_t(level)] = directions.sine(level);
            const auto cells = static_cast<float>(cubemap_faces << (4 * (level + 1)));
            negligible[std::size_t(level)] = 1e-3f * energy * cells;
        }
    }

    /// Those that are not zero.
    std::span<const Highlight> highlights() const { return {highlights_.data(), highlight_count_}; }

private:
    std::array<Highlight, 2> highlights_;
    std::size_t highlight_count_ = 0;
};

}  // namespace haarfield
