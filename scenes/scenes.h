#pragma once
/// haarfield::scenes: scene files in, and everything that shading needs of them. This header is the library's
/// manual, and includes what users start with.
///
/// What it does
///
/// A scene file (TOML; the README has its keys) names meshes, materials, where things stand, the camera and
/// the environment. This library reads it, prepares each entity's meshes, makes its visibility field or takes
/// the one that lies in a folder if it fits, and hands the parts to shading: for one bake, or for a session
/// in which light, eye and objects change. It makes the meshes of the shipped scenes, too.
///
/// The way of the data
///
///     file --read_scene--> Scene --prepare_scene_entities--> SceneEntities: meshes, occluders, fields
///     both, and an environment --shaded_scene--> ShadedScene --scene_radiance--> radiance
///                              the same --> RelightSession
///
/// Where to start
///
/// | declaration | is in |
/// |---|---|
/// | Scene, Entity, Instance, Camera, EnvironmentDescription | scenes/scene.h |
/// | Shape, linear_parts: what stretches and mirrors | scenes/shape.h |
/// | read_scene | scenes/scene_reader.h |
/// | prepare_scene_entities, SceneEntities, SceneEntityOptions | scenes/scene_entities.h |
/// | shaded_scene | scenes/scene_entities.h |
/// | scene_text: a scene's file, scene_comments: what it keeps of comments | scenes/scene_writer.h,
/// scenes/scene_comments.h | | scene_of_models: a scene that shows models | scenes/scene_import.h | |
/// Surface, seen_radiance: materials with images | scenes/surface.h | | read_image, write_image,
/// read_environment_image | scenes/image.h | | fine_meshes, surface_meshes | scenes/scene_entities.h | |
/// scene_camera: the camera, if the file leaves it to be found | scenes/scene_camera.h |
///
/// A Scene is plain data: a program may as well fill it in itself. Lengths are metres and angles radians; the
/// file has degrees. Images are read by scenes/image.h.
///
/// A complete program: a scene held open, with its light turned. Its argument is a scene, such as the
/// installed scenes/single_chair.toml; linked with haarfield::scenes.
///
/// ```cpp
/// #include "scenes/scenes.h"
///
/// #include <cstdio>
///
/// using namespace haarfield;
///
/// // Mean luminance of all vertices.
/// double brightness(const SceneRadiance& radiance) {
///     double sum = 0, vertices = 0;
///     for (const std::vector<Rgb>& instance : radiance)
///         for (const Rgb& colour : instance) sum += double(luminance(colour)), ++vertices;
///     return sum / vertices;
/// }
///
/// int main(int, char** arguments) {
///     Result<Scene> scene = read_scene(arguments[1]);
///     if (!scene) return std::puts(scene.error().message().c_str()), 1;
///     for (Entity& entity : scene->entities) {  // a quick look
///         entity.fine_vertices = 2000;
///         entity.planar_samples = 600;
///         entity.spherical_samples = 300;
///     }
///     const Result<SceneEntities> entities =
///         prepare_scene_entities(*scene, {.fields_folder = "scenes_fields"});
///     if (!entities) return std::puts(entities.error().message().c_str()), 1;
///
///     const Environment sky = sky_environment(scene->environment.sky.value_or(AnalyticSky()), 512);
///     RelightSession session(shaded_scene(*scene, *entities, sky), {});
///     if (const Result<Done> done = session.commit(); !done) return 1;  // in full
///     const double before = brightness(session.radiance());
///     if (const Result<Done> done = session.vary_light(); !done) return 1;  // makes transfer vectors
///     for (int step = 0; step < 8; ++step) {
///         session.turn_environment(rotation_about({0, 1, 0}, step * pi / 4));
///         if (const Result<Done> done = session.frame(); !done) return 1;  // milliseconds
///         std::printf("turned by %3d degrees: %.4f, was %.4f\n", 45 * step,
///                     brightness(session.radiance()), before);
///     }
///     return brightness(session.radiance()) > 0 ? 0 : 1;
/// }
/// ```

#include "scenes/image.h"
#include "scenes/scene_camera.h"
#include "scenes/scene_comments.h"
#include "scenes/scene_entities.h"
#include "scenes/scene_import.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_writer.h"
#include "shading/shading.h"
