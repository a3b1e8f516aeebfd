#pragma once
/// The kernels of `bake` and `relight` on generated data, for counting, timing and verification.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "shading/walk/wavelet_blocks.h"

namespace haarfield::bench {

/// A kernel and its work. The data are generated on first use.
struct ShippedKernel {
    std::string name;
    std::function<void()> run;
    std::function<std::size_t()> vertices;  ///< Vertices per run.
    /// Runs it. Returns the relative RMSE of radiance against sums over texels.
    std::function<double()> error;
    double tolerance;  ///< Largest accepted error.
};

/// Returns the kernels, by name:
///     outgoing_radiance    the product integral at a vertex
///     radiance_integrand   the product itself, in wavelets
///     specular_integrand  the product for the specular term only: vertex_shading.h
///     scene_radiance       the radiance of all vertices of a scene, with their visibility
///     light_vectors        just-in-time radiance transfer: computing the vectors
///     light_frame          and a frame with them; similarly:
///     view_vectors, view_frame, motion_vectors, motion_frame
std::vector<ShippedKernel> shipped_kernels();

/// Returns the integral of a product in wavelets: the sum of its faces' means.
Rgb integral_of(std::span<const WaveletBlock<3>> product);

}  // namespace haarfield::bench
