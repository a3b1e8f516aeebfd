#pragma once
/// haarfield::shading: integrals of products of functions of direction, and what they make of a scene. This
/// header is the library's manual, and includes what users start with.
///
/// What it does
///
/// The radiance that a point sends to the eye is the integral of a product: incident light, BRDF, cosine, the
/// visibility past the point's own object and past every other. Each factor is given as six quadtrees of Haar
/// wavelets; the product integral walks down all of them together, and goes on only where at least two vary
/// and none is zero (Sun and Mukherjee 2006). The function product is the product itself, again as wavelets.
/// On these two stand the shading of whole scenes and just-in-time radiance transfer, which folds all factors
/// but one into a sparse vector per vertex. What of a scene's light is concentrated, its suns and lamps, is
/// taken from it before and served by shadow rays.
///
/// The way of the data
///
///     environment --lighting_tree--> RgbCubemapTree --> LightPyramid
///     texels --haar_cubemap--> CubemapTree --> WideCubemapTree --factor--> any number of factors
///     both --product_integral--> Rgb, a number a channel
///          --function_product--> blocks of wavelets --cubemap_tree--> CubemapTree, to be used as any other
///
/// or a scene at a time:
///
///     meshes, fields, placements, environment: ShadedScene --scene_radiance--> radiance of all vertices
///                             the same, open --RelightSession--> as light, eye, objects change
///
/// Where to start
///
/// | declaration | is in |
/// |---|---|
/// | product_integral, product_integrals, function_product | shading/walk/product_integral.h |
/// | WideCubemapTree, WeightedTrees: factors | shading/walk/wide_tree.h |
/// | LightPyramid: the lighting as a factor | shading/walk/light_pyramid.h |
/// | cubemap_tree: a function product as quadtrees | shading/walk/wavelet_blocks.h |
/// | lighting_tree: where the solid angle enters | shading/scene/lighting.h |
/// | Environment, sky_environment | shading/scene/environment.h, shading/scene/sky.h |
/// | automatic_exposure: from the light alone | shading/scene/exposure.h |
/// | lobe_texels, Material: what surfaces do | shading/scene/lobes.h, shading/scene/material.h |
/// | ShadedScene, RenderSettings | shading/scene/shaded_scene.h |
/// | scene_radiance, point_radiance | shading/bake/renderer.h |
/// | RelightSession | shading/transfer/relight_session.h |
///
/// Radiance is linear RGB in W/(m^2 sr). Exactly one factor of an integral over directions holds the texels'
/// solid angles, and that is the lighting. Trees are read only and may be shared by threads; the memory of a
/// walk is a thread's own. No answer depends on the number of threads.
///
/// Included, too: meshes that are refined where radiance needs it (shading/bake/mesh_refinement.h), colours
/// that fit what lies between the vertices (shading/bake/colour_fit.h), diffuse light, highlights, irradiance
/// and occlusion apart (shading/bake/render_passes.h), the slow oracle (shading/bake/dense_renderer.h), and
/// what each approximation costs (shading/bake/error_budget.h).
///
/// A complete program: the radiance of a glossy point of the floor under a sky, between two chairs, as the
/// integral of five functions; and the point's answer to any light as a function product. Its argument is a
/// mesh, such as the installed scenes/meshes/chair.obj; linked with haarfield::shading.
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
/// // A function of direction, given as texels: without the wavelets that make up a hundredth of it.
/// WideCubemapTree tree_of(const std::vector<float>& texels) {
///     return WideCubemapTree(haar_cubemap<float>(texels, size, {.relative_l2_error = 0.01f}));
/// }
///
/// // What can be seen past an object that stands at the origin.
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
///     // A diffuse and a glossy term, seen from 45 degrees above.
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
///     // Lighting and four more functions: one number a channel.
///     const std::array factors{brdf.factor(), cosine.factor(), past_right.factor(), past_front.factor()};
///     WalkMemory<float> memory;
///     const Rgb radiance = product_integral(light, factors, full_depth, memory);
///     std::printf("radiance %.4f %.4f %.4f\n", double(radiance.x), double(radiance.y), double(radiance.z));
///
///     // The four alone, as a function: what the point makes of any light.
///     std::vector<WaveletBlock<1>> blocks;
///     function_product(size, factors, full_depth, memory, blocks);
///     const WideCubemapTree answer(cubemap_tree(blocks));
///     const Rgb again = product_integral(light, std::array{answer.factor()}, full_depth, memory);
///     std::printf("the same %.4f %.4f %.4f\n", double(again.x), double(again.y), double(again.z));
///     return radiance.y > 0 && std::abs(again.y - radiance.y) <= 1e-4f * radiance.y ? 0 : 1;
/// }
/// ```

#include "fields/fields.h"
#include "shading/bake/colour_fit.h"
#include "shading/bake/dense_renderer.h"
#include "shading/bake/error_budget.h"
#include "shading/bake/mesh_refinement.h"
#include "shading/bake/render_passes.h"
#include "shading/bake/renderer.h"
#include "shading/scene/exposure.h"
#include "shading/scene/lighting.h"
#include "shading/scene/lobes.h"
#include "shading/scene/sky.h"
#include "shading/transfer/relight_session.h"
#include "shading/walk/product_integral.h"
