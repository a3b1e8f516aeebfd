#pragma once
/// Product integrals in practice: the functions at the vertices of scenes/table_and_chairs.toml.

#include <cstdio>
#include <cstdlib>

#include "fields/wavelets/quadtree.h"
#include "scenes/scene_entities.h"

namespace haarfield::baseline {

/// Returns the value, or prints the error's message and exits.
template <class T>
T value_or_exit(Result<T> result) {
    if (result) return std::move(*result);
    std::fprintf(stderr, "%s\n", result.error().message().c_str());
    std::exit(1);
}

/// The scene under its own sky, without fields. Not movable, because its members point to each other.
struct ShippedScene {
    Scene description;
    SceneEntities entities;
    ShadedScene shaded;
};

/// Loaded once, in about a second. Exits if the files are missing.
const ShippedScene& shipped_scene();

/// Returns the scene with meshes to be subdivided to `vertices` vertices, summed over all instances.
Scene with_vertices(Scene scene, std::size_t vertices);

/// The functions of a vertex besides the lighting, in the order in which smaller products use them: own
/// visibility times clamped cosine, BRDF, and visibility around each other instance, sorted by decreasing
/// occlusion. Texels as in lighting.h: face by face in row-major order, 6 * size^2.
struct VertexTexels {
    std::size_t instance = 0;
    Vec3f point, normal, mirror;  ///< In the world; the point is the vertex's local sample.
    std::vector<std::vector<float>> factors;
};

/// The functions of all vertices, untruncated.
struct TexelIntegrals {
    int face_size = 64;
    std::vector<Rgb> light;
    std::vector<VertexTexels> vertices;
};

/// The functions of all vertices as truncated trees.
struct TreeIntegrals {
    int face_size = 64;
    RgbCubemapTree light;
    std::vector<std::vector<CubemapTree>> vertices;  ///< Indexed by vertex and factor.
};

/// The BRDF of all vertices, diffuse and glossy, so that it is never zero: diffuse / pi + specular (shininess
/// + 2) / (2 pi) max(0, mirror.w)^shininess. [1/sr]
inline constexpr float brdf_diffuse = 0.5f, brdf_specular = 0.3f, brdf_shininess = 60;

/// The part of the sky's light that is multiplied.
enum class StudiedLight {
    whole,   ///< All of it, with the sun spread over its pixels.
    smooth,  ///< Without the sun, which the library treats as a source with rays (light_sources.h).
};

/// Returns `count` vertices distributed evenly over the scene. Visibility is exact: rasterized at the vertex.
/// Vertices that no light reaches are skipped, because their products would measure nothing.
TexelIntegrals texel_integrals(int face_size, std::size_t count, StudiedLight light = StudiedLight::whole);

/// Returns the same vertices with half as many texels along an edge: means of four.
TexelIntegrals coarser(const TexelIntegrals& integrals);

/// The number of largest wavelets to keep per face; 0: all. `functions` includes the lighting: 2 to 7.
struct KeptWavelets {
    int light = 200, others = 70;
};
TreeIntegrals tree_integrals(const TexelIntegrals& integrals, int functions, const KeptWavelets& kept = {});

/// The reference: the sum over all texels, in double. [W/(m^2 sr)]
std::vector<Vec3d> texel_sums(const TexelIntegrals& integrals, int functions);
std::vector<Vec3d> texel_sums(const TreeIntegrals& integrals, int depth = 32);

/// Returns the root of the mean squared difference relative to that of `wanted`, over all channels.
double relative_rmse(std::span<const Rgb> found, std::span<const Vec3d> wanted);

}  // namespace haarfield::baseline
