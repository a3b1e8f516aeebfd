#pragma once
/// Transparent surfaces that filter the light of lamps, such as glass.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fields/base/embree_device.h"

struct RTCSceneTy;

namespace haarfield {

/// Triangles in the world, each with the fraction of light that passes it. Light is not refracted, as in
/// POV-Ray's shadows without photons. Threads may share it once it is committed.
class LightFilters {
public:
    /// Adds a mesh.
    ///
    /// positions   [m]
    /// colours     fraction of light that passes each triangle, in [0, 1]; one colour serves all triangles.
    /// absorption  absorption coefficient inside a closed mesh; >= 0. [1/m] As in POV-Ray, it acts over the
    ///             way from the last crossing of any mesh to the one that leaves this mesh.
    void add(std::span<const Vec3f> positions, std::span<const std::array<std::uint32_t, 3>> triangles,
             std::vector<Rgb> colours, const Rgb& absorption = Rgb(0.0f));

    /// Builds the acceleration structure; call it after the last addition.
    ///
    /// cost  about 0.3 us per triangle.
    void commit();

    /// Returns the fraction of light that remains between two points. Triangles multiply it by their colours,
    /// and absorption decreases it exponentially (Beer-Lambert law).
    ///
    /// accuracy  surfaces nearer to each other than 2e-6 of their distance from `from` count once; those of
    ///           one mesh that face the same side, than 1e-4.
    /// cost      40 ns, and as much for each crossing.
    Rgb transmitted(const Vec3f& from, const Vec3f& end) const;

private:
    EmbreeDevice device_;
    std::shared_ptr<RTCSceneTy> scene_;
    std::vector<std::vector<Rgb>> colours_;  // By geometry.
    std::vector<Rgb> absorption_;            // By geometry.
};

}  // namespace haarfield
