#pragma once
/// The diffuse and the specular component of outgoing radiance.

#include <vector>

#include "fields/base/vector.h"

namespace haarfield {

/// The two components of a BRDF, of its product with a cosine, or of the radiance that results.
template <class Colour>
struct Components {
    Colour diffuse{0}, specular{0};

    Colour total() const { return diffuse + specular; }  ///< Both together.

    /// Adds both.
    Components& operator+=(const Components& other) {
        diffuse += other.diffuse;
        specular += other.specular;
        return *this;
    }
    /// Scales both, by a number or per channel.
    template <class Factor>
    Components operator*(const Factor& factor) const {
        return {Colour(diffuse * factor), Colour(specular * factor)};
    }
    /// Divides both, by a number or per channel.
    template <class Factor>
    Components operator/(const Factor& factor) const {
        return {Colour(diffuse / factor), Colour(specular / factor)};
    }
    bool operator==(const Components&) const = default;

    /// Converts both to another type or precision.
    template <class Other>
    explicit operator Components<Other>() const {
        return {Other(diffuse), Other(specular)};
    }
};

/// Adds both.
template <class Colour>
Components<Colour> operator+(Components<Colour> a, const Components<Colour>& b) {
    return a += b;
}

/// Outgoing radiance of a point. [W/(m^2 sr)]
using Outgoing = Components<Rgb>;

/// Removes negative channels from both components. What a component is below zero is subtracted from the
/// other one, so that the total changes only where it is negative itself.
Outgoing without_negative(const Outgoing& radiance);

/// Outgoing radiance by instance and vertex of its fine mesh. [W/(m^2 sr)]
using SceneRadiance = std::vector<std::vector<Outgoing>>;

/// An RGB value by instance and vertex of its fine mesh.
using SceneColours = std::vector<std::vector<Rgb>>;

SceneColours total(const SceneRadiance& radiance);               ///< Diffuse and specular radiance together.
SceneColours diffuse_component(const SceneRadiance& radiance);   ///< Diffuse radiance alone.
SceneColours specular_component(const SceneRadiance& radiance);  ///< Specular radiance alone.

}  // namespace haarfield
