#pragma once
/// haarfield::shading: integrals of products of functions of direction, and the radiance of scenes. This
/// header is the manual of the library, and includes the headers that users start with.
///
/// Purpose
///
/// The radiance of a surface point towards the eye is the integral of a product: incident radiance, BRDF,
/// cosine, the visibility around the point's own object, and the visibility around every other object. Each
/// factor is six quadtrees of Haar wavelets. The product integral walks down all trees together. It descends
/// only where at least two factors vary and none is zero (Sun and Mukherjee 2006; shading/PAPER.md). The
/// function product is the same product as a function of direction, again in wavelets. A bake computes
/// product integrals at all vertices. Just-in-time radiance transfer multiplies all factors but one into a
/// sparse vector per vertex, so that a frame computes only inner products. Suns, lamps and bright windows are
/// separated from the environment beforehand and evaluated by shadow rays.
///
/// Data flow
///
///     lat-long image --lighting_tree--> RgbCubemapTree --> LightPyramid
///     texels --haar_cubemap--> CubemapTree --> WideCubemapTree --factor--> WeightedTrees, a factor
///     LightPyramid, factors --product_integral--> Rgb, one number per channel
///     factors --function_product--> blocks of wavelets --cubemap_tree--> CubemapTree, which can be a factor
///
/// or a whole scene:
///
///     meshes, fields, placements, environment --> ShadedScene
///     ShadedScene --scene_radiance--> radiance of all vertices
///     ShadedScene --> RelightSession: radiance after each change of light, eye or objects
///
/// Where to start
///
/// | declaration | header | purpose |
/// |---|---|---|
/// | product_integral, function_product | shading/walk/product_integral.h | the integral, the product |
/// | product_integrals | shading/walk/product_integral.h | the integrals of many points |
/// | WideCubemapTree, WeightedTrees | shading/walk/wide_tree.h | factors |
/// | LightPyramid | shading/walk/light_pyramid.h | the lighting as a factor |
/// | cubemap_tree | shading/walk/wavelet_blocks.h | a function product as quadtrees |
/// | lighting_tree | shading/scene/lighting.h | light as wavelets, with the solid angle |
/// | Environment | shading/scene/environment.h | light from far away |
/// | sky_environment | shading/scene/sky.h | the analytic sky |
/// | split_light | shading/scene/light_sources.h | separates suns and windows from the smooth light |
/// | automatic_exposure | shading/scene/exposure.h | an exposure from the light alone |
/// | Material | shading/scene/material.h | diffuse and specular reflection |
/// | VertexBrdf, Lobe, reflectance | shading/walk/brdf.h | the BRDF of a point as data |
/// | lobe_texels | shading/scene/lobes.h | specular lobes and the cosine as texels |
/// | ShadedScene, RenderSettings | shading/scene/shaded_scene.h | a scene to shade |
/// | scene_radiance, point_radiance | shading/bake/renderer.h | radiance of vertices and points |
/// | Outgoing, SceneRadiance, total | shading/walk/outgoing.h | diffuse and specular radiance |
/// | refined_radiance | shading/bake/mesh_refinement.h | splits triangles where radiance varies |
/// | target_bake | shading/bake/error_target.h | chooses vertices and rays for a wanted error |
/// | BakeErrorMeter | shading/bake/bake_error.h | measures the error of a bake, and its causes |
/// | fit_radiance | shading/bake/colour_fit.h | fits colours to radiance between vertices |
/// | dense_scene_radiance | shading/bake/dense_renderer.h | slow reference: plain sums over texels |
/// | error_budget | shading/bake/error_budget.h | the error of each approximation |
/// | RelightSession | shading/transfer/relight_session.h | an open scene whose radiance follows changes |
///
/// shading/bake/render_passes.h separates diffuse light, specular light, irradiance and occlusion.
///
/// Radiance is linear RGB in W/(m^2 sr). Exactly one factor of an integral over directions contains the solid
/// angles of the texels: the lighting. Trees are read-only, and threads may share them. Each thread has its
/// own WalkMemory. Results do not depend on the number of threads.
///
/// A complete program: the radiance of a glossy point on the floor, under a sky and between two chairs. It is
/// the integral of a product of five functions. Then the program computes the product of the four functions
/// without the light, which is the transfer function of the point, and integrates it with the light. The
/// argument is a mesh file, such as the installed scenes/meshes/chair.obj. Link with haarfield::shading.
///
/// ```cpp
/// #include "shading/shading.h"
///
/// #include <cmath>
/// #include <cstdio>
///
/// using namespace haarfield;
///
/// constexpr int size = 64;  // texels along a cubemap edge
///
/// // A function of direction as a tree, truncated to a relative L2 error of 1 %.
/// WideCubemapTree tree_of(const std::vector<float>& texels) {
///     return WideCubemapTree(haar_cubemap<float>(texels, size, {.relative_l2_error = 0.01f}));
/// }
///
/// // Visibility around an object at the origin.
/// WideCubemapTree visibility(const Occluder& object, const Vec3f& point) {
///     VisibilityRasterizer rasterizer(size);
///     std::vector<float> texels;
///     for (const std::uint8_t open : rasterizer.open_samples(object, point))
///         texels.push_back(open_fraction(open));
///     return tree_of(texels);
/// }
///
/// int main(int, char** arguments) {
///     const Result<ImportedMesh> chair = read_mesh(arguments[1]);
///     if (!chair) return std::puts(chair.error().message().c_str()), 1;
///
///     // A diffuse and a specular term, viewed from 45 degrees above.
///     const Vec3f normal(0, 1, 0), mirror = Vec3f(1, 1, 0).normalized();
///     std::vector<float> brdf_texels = lobe_texels(50, mirror, size);
///     for (float& value : brdf_texels) value = float((0.3 + 0.2 * 26 * double(value)) / pi);
///
///     // One chair is 0.6 m to the right of the point, the other 0.8 m in front of it.
///     const Occluder object = make_occluder(chair->mesh);
///     const WideCubemapTree brdf = tree_of(brdf_texels), cosine = tree_of(lobe_texels(1, normal, size)),
///                           past_right = visibility(object, {-0.6f, 0.001f, 0}),
///                           past_front = visibility(object, {0, 0.001f, -0.8f});
///     const LightPyramid light(lighting_tree(sky_image({}, 512), size, {.coefficients = 300}), size);
///
///     // The integral of the lighting and four more functions, one number per channel.
///     const std::array factors{brdf.factor(), cosine.factor(), past_right.factor(), past_front.factor()};
///     WalkMemory<float> memory;
///     const Rgb radiance = product_integral(light, factors, full_depth, memory);
///     std::printf("radiance %.4f %.4f %.4f\n", double(radiance.x), double(radiance.y), double(radiance.z));
///
///     // The product of the four functions without the light: the response of the point to any light.
///     std::vector<WaveletBlock<1>> blocks;
///     function_product(size, factors, full_depth, memory, blocks);
///     const WideCubemapTree answer(cubemap_tree(blocks));
///     const Rgb again = product_integral(light, std::array{answer.factor()}, full_depth, memory);
///     std::printf("the same %.4f %.4f %.4f\n", double(again.x), double(again.y), double(again.z));
///     return radiance.y > 0 && std::abs(again.y - radiance.y) <= 1e-4f * radiance.y ? 0 : 1;
/// }
/// ```

#include "fields/fields.h"
#include "shading/bake/bake_error.h"
#include "shading/bake/colour_fit.h"
#include "shading/bake/dense_renderer.h"
#include "shading/bake/error_budget.h"
#include "shading/bake/error_target.h"
#include "shading/bake/mesh_refinement.h"
#include "shading/bake/render_passes.h"
#include "shading/bake/renderer.h"
#include "shading/scene/exposure.h"
#include "shading/scene/lighting.h"
#include "shading/scene/lobes.h"
#include "shading/scene/sky.h"
#include "shading/transfer/relight_session.h"
#include "shading/walk/product_integral.h"
