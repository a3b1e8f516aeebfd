#pragma once
/// Mirror reflection, which is not baked: POV-Ray traces it when it renders a bake.

#include "fields/base/vector.h"

namespace haarfield {

/// POV-Ray's `reflection` of a finish.
struct Reflection {
    Rgb at_normal{0, 0, 0};   ///< Reflected fraction at normal incidence, in [0, 1].
    Rgb at_grazing{0, 0, 0};  ///< At grazing incidence, in [0, 1].
    /// Index of refraction; above 1: Fresnel's formula interpolates between both. 0: POV-Ray's interpolation,
    /// linear in the cosine.
    float ior = 0;
    float metallic = 0;  ///< How far the pigment tints both, in [0, 1].

    /// True if the surface reflects.
    bool is_there() const { return at_normal != Rgb(0.0f) || at_grazing != Rgb(0.0f); }
    bool operator==(const Reflection&) const = default;
};

}  // namespace haarfield
