#pragma once
/// POV-Ray's `finish` in scene files and programs, with POV-Ray's key names and defaults.

#include "fields/base/range.h"
#include "scenes/scene.h"

namespace haarfield {

inline constexpr Range albedos{0, 1};         ///< Of a surface.
inline constexpr Range emissions{0, 65000};   ///< Up to the largest half float. [W/(m^2 sr)]
inline constexpr Range shininesses{1, 1000};  ///< Exponents of Phong's lobe.

/// Reads the keys of a finish from a table or a message. `take(key, float, Range)` leaves the value unchanged
/// if the key is absent.
///
/// material  has its pigment; receives diffuse, emission, specular and lobes from the pigment and the finish.
template <class Reader>
void take_povray_finish(Reader& finish, SceneMaterial& material) {
    constexpr Range weights{0, 100};
    float diffuse = 0.6f, emission = 0;
    material.phong = 0;
    material.shininess = 40;
    finish.take("diffuse", diffuse, albedos);
    finish.take("emission", emission, emissions);
    finish.take("phong", material.phong, weights);
    finish.take("phong_size", material.shininess, shininesses);
    finish.take("specular", material.blinn, weights);
    finish.take("roughness", material.roughness, {0.0005, 1});
    finish.take("metallic", material.metallic, {0, 1});
    material.diffuse = material.pigment * diffuse;
    material.emission = material.pigment * emission;
    material.specular = Rgb(material.phong > 0 || material.blinn > 0 ? 1.0f : 0.0f);
}

}  // namespace haarfield
