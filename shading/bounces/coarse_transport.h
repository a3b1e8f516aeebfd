#pragma once
/// The transport of diffuse light between groups of neighbouring vertices, for bounces after the first.
///
/// Light that has been reflected twice varies slowly over a surface. So the later bounces are computed
/// between groups, with a few of the rays of their rows, and all rows gather the result.

#include <cstdint>
#include <span>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield {

/// Groups of rows of a LightTransport, and the matrix between the groups.
struct CoarseTransport {
    std::vector<std::uint32_t> group;  ///< By row.
    std::vector<float> share;          ///< By group: 1 / number of its rows.

    std::vector<std::uint32_t> sources;  ///< Hit groups, ordered by the group that they light.
    std::vector<std::uint32_t> end;      ///< By group: end of its entries in `sources`.
    std::vector<float> factor;           ///< By group: irradiance / sum of the sources' radiance. [sr]

    /// Returns the mean of each group.
    ///
    /// values  by row.
    std::vector<Rgb> means(std::span<const Rgb> values) const;

    /// Returns the irradiance of all groups by the diffuse radiance of all groups. [W/m^2]
    ///
    /// radiance  by group. [W/(m^2 sr)]
    /// cost      about 0.5 ns per entry, on all of oneTBB's threads.
    std::vector<Rgb> irradiance(std::span<const Rgb> radiance) const;

    std::size_t bytes() const;  ///< Memory. [bytes]
};

}  // namespace haarfield
