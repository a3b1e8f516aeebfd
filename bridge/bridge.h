#pragma once
/// haarfield::bridge: POV-Ray scenes and pictures. This header is the library's manual, and includes what
/// users start with.
///
/// What it does
///
/// Radiance at vertices becomes a POV-Ray scene without any light: one include file per object, with a mesh2
/// that glows in its vertices' colours, for a scene of one's own. The same scene becomes one for POV-Ray's
/// own ray tracer, with the environment as distant lights, to compare with. This library runs POV-Ray, reads
/// and writes pictures, compares them and writes the report; it draws a quick picture by itself as well. It
/// is the only one that knows of POV-Ray, of image files and of other programs.
///
/// The way of the data
///
///     radiance --write_baked_scene--> NAME.pov, NAME_<instance>.inc --render_scene--> baked.exr, baked.png
///     meshes, materials --write_reference_scene--> NAME.pov --rendered_reference--> Image and its own error
///     Image, Image --image_difference--> ImageDifference --write_comparison_report--> report.html
///
/// Where to start
///
/// | declaration | is in |
/// |---|---|
/// | BakedInstance, write_baked_scene | bridge/baked_scene.h |
/// | write_baked_ply, write_baked_csv: the colours for any viewer, as a table | bridge/mesh_file.h |
/// | write_baked_glb: the objects and their colours for Blender and engines | bridge/glb_file.h |
/// | original_bake: the same at the vertices that the models' files list | bridge/original_vertices.h |
/// | run_povray, render_scene | bridge/povray_process.h |
/// | write_reference_scene | bridge/reference_scene.h |
/// | rendered_reference | bridge/reference_picture.h |
/// | light_dome: an environment as distant lights | bridge/light_dome.h |
/// | image_difference | bridge/image_difference.h |
/// | write_comparison_report | bridge/comparison_report.h |
/// | Preview: a picture without POV-Ray | bridge/preview.h |
///
/// Pictures are linear RGB, from the top; files appear whole or not at all.
///
/// A complete program: from a scene file to a picture by POV-Ray, whose program has to be installed. Its
/// argument is a scene, such as the installed scenes/single_chair.toml; linked with haarfield::bridge.
///
/// ```cpp
/// #include "bridge/bridge.h"
///
/// #include <cstdio>
///
/// using namespace haarfield;
///
/// int fail(const Error& error) {
///     std::puts(error.message().c_str());
///     return 1;
/// }
///
/// int main(int, char** arguments) {
///     Result<Scene> scene = read_scene(arguments[1]);
///     if (!scene) return fail(scene.error());
///     for (Entity& entity : scene->entities) {  // a quick look
///         entity.fine_vertices = 5000;
///         entity.planar_samples = 600;
///         entity.spherical_samples = 300;
///     }
///     scene->camera.width = 320;
///     scene->camera.height = 240;
///     const Result<SceneEntities> entities =
///         prepare_scene_entities(*scene, {.fields_folder = "bridge_fields"});
///     if (!entities) return fail(entities.error());
///     scene->camera = scene_camera(*scene, *entities);
///
///     const Environment light = sky_environment(scene->environment.sky.value_or(AnalyticSky()), 512);
///     const Environment sky = turned_environment(
///         light, double(scene->environment.rotation),
///         double(scene->environment.exposure.value_or(automatic_exposure(light))));
///     const ShadedScene shaded = shaded_scene(*scene, *entities, sky);
///     const Result<SceneRadiance> radiance = scene_radiance(shaded, {});
///     if (!radiance) return fail(radiance.error());
///
///     std::vector<BakedInstance> instances;
///     for (std::size_t i = 0; i < scene->instances.size(); ++i)
///         instances.push_back({scene->instances[i].name,
///                              shaded.entities[shaded.instances[i].entity].mesh,
///                              shaded.instances[i].placement, (*radiance)[i]});
///     const LatLongImage background = image_with_suns(shaded.environment);
///     const Result<BakedFiles> files =
///         write_baked_scene("bridge_picture", scene->name, scene->camera, instances, {&background});
///     if (!files) return fail(files.error());
///
///     PovrayOptions options;
///     options.width = scene->camera.width;
///     options.height = scene->camera.height;
///     const Result<RenderedScene> picture = render_scene(files->scene, "bridge_picture/baked.exr", options);
///     if (!picture) return fail(picture.error());
///     std::printf("bridge_picture/baked.png is %d x %d\n", picture->image.width, picture->image.height);
///     return picture->image.width == 320 ? 0 : 1;
/// }
/// ```

#include "bridge/baked_scene.h"
#include "bridge/budget_report.h"
#include "bridge/comparison_report.h"
#include "bridge/glb_file.h"
#include "bridge/light_dome.h"
#include "bridge/mesh_file.h"
#include "bridge/movie.h"
#include "bridge/original_vertices.h"
#include "bridge/povray_process.h"
#include "bridge/preview.h"
#include "bridge/reference_picture.h"
#include "bridge/reference_scene.h"
#include "scenes/scenes.h"
