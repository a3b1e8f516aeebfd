#pragma once
/// What `bake` and `relight` spend their time in, on data that is made here: to count, to time, and to check
/// before.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "shading/walk/wavelet_blocks.h"

namespace haarfield::bench {

/// A kernel, and its work; the data is made when it is first run or checked.
struct ShippedKernel {
    std::string name;
    std::function<void()> run;
    std::function<std::size_t()> vertices;  ///< That a run goes through.
    std::function<double()> error;          ///< Runs it: relative RMSE of radiance against sums over texels.
    double tolerance;                       ///< Below it the answer is right.
};

/// By name:
///     outgoing_radiance    the product integral of a vertex,
///     radiance_integrand   the product itself, in wavelets,
///     highlight_integrand  and that of the highlights alone: vertex_shading.h
///     scene_radiance       the radiance of all vertices of a scene, with what they see
///     light_vectors        just-in-time radiance transfer: making the vectors,
///     light_frame          and a frame by them; and so on:
///     view_vectors, view_frame, motion_vectors, motion_frame
std::vector<ShippedKernel> shipped_kernels();

/// Of a product in wavelets: the sum of its faces' means.
Rgb integral_of(std::span<const WaveletBlock<3>> product);

}  // namespace haarfield::bench
