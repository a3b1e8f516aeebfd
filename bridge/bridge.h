#pragma once
/// haarfield::bridge: POV-Ray scenes, pictures and their comparison. This header is the manual of the
/// library, and includes the headers that users start with.
///
/// Purpose
///
/// This library writes a bake as a POV-Ray scene without light sources. Each object is an include file with
/// one mesh2 whose vertex colours emit the radiance, for use in other POV-Ray scenes. It also writes bakes as
/// PLY, glTF and CSV. For a reference picture, it writes the original meshes and materials for POV-Ray's ray
/// tracer, with the environment as distant lights. It runs POV-Ray, compares pictures and writes reports.
/// Preview draws a picture without POV-Ray. No other library writes POV-Ray scenes or runs POV-Ray.
///
/// Data flow
///
///     radiance --write_baked_scene--> NAME.pov, NAME_<instance>.inc --render_scene--> baked.exr, baked.png
///     meshes, materials --write_reference_scene--> NAME.pov --rendered_reference--> Image and its error
///     Image, Image --image_difference--> ImageDifference --write_comparison_report--> report.html
///
/// Where to start
///
/// | declaration | header | purpose |
/// |---|---|---|
/// | write_baked_scene | bridge/povray/baked_scene.h | a bake for POV-Ray |
/// | write_placed_bake | bridge/povray/placed_bake.h | a bake in another POV-Ray scene |
/// | write_baked_ply, write_baked_csv | bridge/files/mesh_file.h | a bake as PLY or as a table |
/// | write_baked_glb | bridge/files/glb_file.h | a bake as glTF, with images |
/// | imported_povray_scene | bridge/povray_import/imported_scene.h | imports a POV-Ray scene |
/// | probed_light | bridge/povray_import/light_probe.h | the light at a place in a POV-Ray scene |
/// | models_in_scene | bridge/povray_import/models_in_scene.h | models in a POV-Ray scene, lit by it |
/// | run_povray, render_scene | bridge/povray/povray_process.h | runs POV-Ray |
/// | write_reference_scene | bridge/povray/reference_scene.h | the scene for the ray tracer |
/// | rendered_reference | bridge/povray/reference_picture.h | the reference picture and its error |
/// | light_dome | bridge/povray/light_dome.h | an environment as distant lights |
/// | image_difference | bridge/pictures/image_difference.h | compares two pictures |
/// | write_comparison_report | bridge/pictures/comparison_report.h | a report as one HTML page |
/// | write_movie | bridge/files/movie.h | frames as a movie |
/// | Preview | bridge/pictures/preview.h | a picture without POV-Ray |
///
/// Pictures are linear RGB from the top row down. Files appear complete or not at all.
///
/// A complete program: renders a scene file with POV-Ray, which must be installed. The argument is a scene
/// file, such as the installed scenes/single_chair.toml. Link with haarfield::bridge.
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
///     for (Entity& entity : scene->entities) {  // coarse, for a quick result
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
///     const SceneColours colours = total(*radiance);
///
///     std::vector<BakedInstance> instances;
///     for (std::size_t i = 0; i < scene->instances.size(); ++i)
///         instances.push_back({scene->instances[i].name,
///                              shaded.entities[shaded.instances[i].entity].mesh,
///                              shaded.instances[i].placement, colours[i]});
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

#include "bridge/files/glb_file.h"
#include "bridge/files/mesh_file.h"
#include "bridge/files/movie.h"
#include "bridge/pictures/budget_report.h"
#include "bridge/pictures/comparison_report.h"
#include "bridge/pictures/preview.h"
#include "bridge/povray/baked_scene.h"
#include "bridge/povray/light_dome.h"
#include "bridge/povray/placed_bake.h"
#include "bridge/povray/povray_process.h"
#include "bridge/povray/reference_picture.h"
#include "bridge/povray/reference_scene.h"
#include "bridge/povray_import/imported_scene.h"
#include "bridge/povray_import/light_probe.h"
#include "bridge/povray_import/models_in_scene.h"
#include "scenes/scenes.h"
