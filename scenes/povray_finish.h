#pragma once
/// POV-Ray's `finish` in scene files and programs, with POV-Ray's key names and defaults.

#include "fields/base/range.h"
#include "scenes/scene.h"

#include <array>
#include <optional>

namespace haarfield {

inline constexpr Range albedos{0, 1};         ///< Of a surface.
inline constexpr Range pigments{0, 100};      ///< POV-Ray's; times `diffuse`, an albedo.
inline constexpr Range emissions{0, 65000};   ///< Up to the largest half float. [W/(m^2 sr)]
inline constexpr Range shininesses{1, 1000};  ///< Exponents of Phong's lobe.

/// Reads the keys of a finish from a table or a message. `take(key, float, Range)` leaves the value unchanged
/// if the key is absent.
///
/// material  has its pigment; receives diffuse, emission, ambient, specular and lobes from the pigment and
///           the finish.
template <class Reader>
void take_povray_finish(Reader& finish, SceneMaterial& material) {
    constexpr Range weights{0, 100};
    float diffuse = 0.6f, emission = 0, ambient = 0;
    material.phong = 0;
    material.shininess = 40;
    finish.take("diffuse", diffuse, albedos);
    finish.take("emission", emission, emissions);
    finish.take("ambient", ambient, emissions);
    finish.take("phong", material.phong, weights);
    finish.take("phong_size", material.shininess, shininesses);
    finish.take("specular", material.blinn, weights);
    finish.take("roughness", material.roughness, {0.0005, 1});
    finish.take("metallic", material.metallic, {0, 1});
    material.diffuse = material.pigment * diffuse;
    material.emission = material.pigment * emission;
    material.ambient = material.pigment * ambient;
    material.specular = Rgb(material.phong > 0 || material.blinn > 0 ? 1.0f : 0.0f);
}

/// A key of a finish with its value.
struct FinishKey {
    const char* key;
    float value;
    bool matters;  ///< False if the material is the same without the key.
};
/// The keys of a finish, in the order in which they are written.
using FinishKeys = std::array<FinishKey, 8>;

/// Returns the finish of a material next to its pigment; nothing if a finish cannot express the material.
/// Diffuse reflection, emission and ambient light must be multiples of the pigment, and specular light white.
inline std::optional<FinishKeys> finish_of(const SceneMaterial& material) {
    const bool has_phong = material.phong > 0, has_blinn = material.blinn > 0;
    if (material.convention != LobeConvention::povray ||
        material.specular != Rgb(has_phong || has_blinn ? 1.0f : 0.0f))
        return std::nullopt;
    const auto multiple = [&](const Rgb& colour) {
        float share = 0;
        for (int c = 0; c < 3; ++c)
            if (material.pigment[c] > 0) share = std::max(share, colour[c] / material.pigment[c]);
        return share;
    };
    const float diffuse = multiple(material.diffuse), emission = multiple(material.emission),
                ambient = multiple(material.ambient);
    if (!((material.diffuse - material.pigment * diffuse).length() <= 1e-6f) ||
        !((material.emission - material.pigment * emission).length() <= 1e-6f) ||
        !((material.ambient - material.pigment * ambient).length() <= 1e-6f))
        return std::nullopt;
    return FinishKeys{{{"diffuse", diffuse, true},
                       {"phong", material.phong, has_phong},
                       {"phong_size", material.shininess, has_phong},
                       {"specular", material.blinn, has_blinn},
                       {"roughness", material.roughness, has_blinn},
                       {"metallic", material.metallic, material.metallic > 0},
                       {"emission", emission, emission > 0},
                       {"ambient", ambient, ambient > 0}}};
}

}  // namespace haarfield
