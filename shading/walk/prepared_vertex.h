#pragma once
/// Data that all faces and blocks of a vertex share during its shading.

#include <algorithm>
#include <cassert>
#include <cmath>

#include "shading/walk/vertex_shading.h"

namespace haarfield {

/// Fraction of its peak below which a lobe counts as zero.
inline constexpr float lobe_zero = 1e-3f;
/// Fraction of its peak from which a lobe varies within cells above the last level.
inline constexpr float lobe_varies = 4e-3f;
/// As lobe_varies, for terms that will be pruned.
inline constexpr float lobe_of_terms_varies = 0.03f;

/// One of a vertex's specular lobes, and the directions in which it is evaluated.
struct SpecularLobe : Lobe {
    /// By level: cosines of the angle between mirror direction and centre of a cell. Above `near`, the lobe
    /// is nonzero somewhere in the cell; above `curved`, it varies within it.
    std::array<float, 4> near{}, curved{};

    /// Computes the cosines.
    ///
    /// last_level  of the blocks that are walked.
    /// varies      fraction of its peak from which the lobe varies.
    void look_for(const DirectionPyramid& directions, int last_level, float varies) {
        near.fill(exponent == 0 ? -2.0f : 0.0f);
        curved.fill(2);
        if (exponent == 0) return;
        const Reach zero(std::pow(lobe_zero, 1 / exponent), axis == LobeAxis::half_vector),
            varying(std::pow(varies, 1 / exponent), axis == LobeAxis::half_vector);
        for (int level = 0; level <= last_level; ++level) {
            near[std::size_t(level)] = zero.cosine_beyond(directions, level);
            curved[std::size_t(level)] = varying.cosine_beyond(directions, level);
        }
    }

private:
    /// The angle from the mirror direction up to which a lobe exceeds a value.
    struct Reach {
        float sine, cosine;

        /// cosine_of_lobe  of the angle from the lobe's axis; the mirror direction rotates by twice the angle
        ///                 of the half vector.
        Reach(float cosine_of_lobe, bool about_half_vector) {
            const float c = cosine_of_lobe, s = std::sqrt(std::max(1 - c * c, 0.0f));
            sine = about_half_vector ? 2 * s * c : s;
            cosine = about_half_vector ? 2 * c * c - 1 : c;
        }
        /// Returns the cosine of the reach plus a cell's radius, limited to 180 degrees.
        float cosine_beyond(const DirectionPyramid& directions, int level) const {
            const float s = directions.sine(level), c = directions.cosine(level);
            return sine * c + cosine * s > 0 ? cosine * c - sine * s : -1.0f;
        }
    };
};

/// The data that all faces and blocks of a vertex share. The ShadedVertex must outlive it.
struct PreparedVertex {
    const DirectionPyramid& directions;
    const VertexBrdf& brdf;
    VisibilityProduct visibility;
    float varies;  ///< Threshold of lobes: lobe_varies or lobe_of_terms_varies.
    bool is_metallic;
    Vec3f to_eye;
    Vec3f across;  ///< Unit normal of the plane of incidence.
    /// By level: sine of the largest angle from a cell's centre to its border.
    std::array<float, 4> margin{};
    /// By level: bound on a lobe times the light's deviation in a cell, over the mean of the light.
    /// Smaller products change the specular reflection of uniform light by less than a thousandth.
    std::array<float, 4> negligible{};

    /// last_level  of the blocks that are walked.
    /// lobes_vary  fraction of its peak from which a lobe varies.
    PreparedVertex(const ShadedVertex& vertex, int last_level, float lobes_vary = lobe_varies)
        : directions(vertex.directions),
          brdf(vertex.brdf),
          visibility(vertex.visibility),
          varies(lobes_vary),
          is_metallic(brdf.is_metallic()),
          to_eye(brdf.eye()),
          across(brdf.normal.cross(to_eye).normalized()) {
        assert(last_level >= 0);
        float energy = 0;  // Mean over the sphere.
        for (const Lobe& lobe : brdf.lobes) {
            if (!brdf.has_specular() || !(lobe.weight > 0)) continue;
            specular_lobes_[specular_lobe_count_] = {lobe};
            specular_lobes_[specular_lobe_count_++].look_for(directions, last_level, varies);
            energy += lobe.weight * lobe.mean_over_power() / (2 * (lobe.exponent + 1));
        }
        for (int level = 0; level <= last_level; ++level) {
            margin[std::size_t(level)] = directions.sine(level);
            const auto cells = static_cast<float>(cubemap_faces << (4 * (level + 1)));
            negligible[std::size_t(level)] = 1e-3f * energy * cells;
        }
    }

    /// Returns the lobes with nonzero weight.
    std::span<const SpecularLobe> specular_lobes() const {
        return {specular_lobes_.data(), specular_lobe_count_};
    }

private:
    std::array<SpecularLobe, most_lobes> specular_lobes_;
    std::size_t specular_lobe_count_ = 0;
};

}  // namespace haarfield
