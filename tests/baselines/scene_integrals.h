#pragma once
/// Product integrals as they occur: what vertices of scenes/table_and_chairs.toml multiply.

#include <cstdio>
#include <cstdlib>

#include "fields/wavelets/quadtree.h"
#include "scenes/scene_entities.h"

namespace haarfield::baseline {

/// The value, or the end of the program with the error's message.
template <class T>
T value_or_exit(Result<T> result) {
    if (result) return std::move(*result);
    std::fprintf(stderr, "%s\n", result.error().message().c_str());
    std::exit(1);
}

/// The scene under its own sky, without fields. Stays where it is: its parts point at each other.
struct ShippedScene {
    Scene description;
    SceneEntities entities;
    ShadedScene shaded;
};

/// Made once, in about a second; ends the program if the files are not there.
const ShippedScene& shipped_scene();

/// The scene with meshes that are to be subdivided to so many vertices, over all instances.
Scene with_vertices(Scene scene, std::size_t vertices);

/// The functions of one vertex beside the lighting, in the order in which smaller products take them: own
/// visibility times clamped cosine, BRDF, visibility past each other instance, the one that blocks most
/// first. Texels as in lighting.h: face by face and row by row, 6 * size^2.
struct VertexTexels {
    std::size_t instance = 0;
    Vec3f point, normal, mirror;  ///< In the world; the point is the vertex's local sample.
    std::vector<std::vector<float>> factors;
};

/// All of them, untruncated.
struct TexelIntegrals {
    int face_size = 64;
    std::vector<Rgb> light;
    std::vector<VertexTexels> vertices;
};

/// The same as trees, truncated.
struct TreeIntegrals {
    int face_size = 64;
    RgbCubemapTree light;
    std::vector<std::vector<CubemapTree>> vertices;  ///< By vertex and factor.
};

/// The BRDF of all vertices: matte and glossy, so that it vanishes nowhere.
/// diffuse / pi + specular (shininess + 2) / (2 pi) max(0, mirror.w)^shininess. [1/sr]
inline constexpr float brdf_diffuse = 0.5f, brdf_specular = 0.3f, brdf_shininess = 60;

/// What of the sky's light is multiplied.
enum class StudiedLight {
    whole,   ///< All of it, the sun spread over its pixels.
    smooth,  ///< Without what the library takes out of it and serves by rays: the sun (light_sources.h).
};

/// `count` vertices spread evenly over the scene's. Visibility is exact: rasterized at the vertex. Vertices
/// that no light reaches are passed over, as their products would measure nothing.
TexelIntegrals texel_integrals(int face_size, std::size_t count, StudiedLight light = StudiedLight::whole);

/// The same with half as many texels along an edge: means of four.
TexelIntegrals coarser(const TexelIntegrals& integrals);

/// The wavelets of each face that are largest, so many; 0: all. `functions` counts the lighting: 2 to 7.
struct KeptWavelets {
    int light = 200, others = 70;
};
TreeIntegrals tree_integrals(const TexelIntegrals& integrals, int functions, const KeptWavelets& kept = {});

/// The slow and obvious: the sum over all texels, in double. [W/(m^2 sr)]
std::vector<Vec3d> texel_sums(const TexelIntegrals& integrals, int functions);
std::vector<Vec3d> texel_sums(const TreeIntegrals& integrals, int depth = 32);

/// Root of the mean squared difference over that of `wanted`, all channels.
double relative_rmse(std::span<const Rgb> found, std::span<const Vec3d> wanted);

}  // namespace haarfield::baseline
