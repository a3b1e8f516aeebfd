#pragma once
/// haarfield::scenes: scene files, and the preparation of scenes for shading. This header is the manual of
/// the library, and includes the headers that users start with.
///
/// Purpose
///
/// A scene file (TOML, see scenes/SCENE_FILE.md) names meshes, materials, placements, the camera and the
/// environment. This library reads the file and prepares the meshes of each entity. It computes the
/// visibility field of each entity, or reuses one from a folder. The result is a ShadedScene, for a bake or
/// for a relighting session. The library also makes complete bakes, with refinement, textures and passes, and
/// reads and writes images.
///
/// Data flow
///
///     file --read_scene--> Scene --prepare_scene_entities--> SceneEntities: meshes, occluders, fields
///     Scene, SceneEntities, Environment --shaded_scene--> ShadedScene
///     ShadedScene --scene_radiance--> radiance of all vertices
///     ShadedScene --> RelightSession: radiance after each change
///
/// Where to start
///
/// | declaration | header | purpose |
/// |---|---|---|
/// | Scene, Entity, Instance, Camera, EnvironmentDescription | scenes/scene.h | the description of a scene |
/// | Shape, placed_shape | scenes/shape.h | stretched and mirrored instances |
/// | read_scene | scenes/scene_reader.h | reads scene files |
/// | scene_text | scenes/scene_writer.h | writes scene files |
/// | scene_comments | scenes/scene_comments.h | the comments that a rewritten file keeps |
/// | scene_of_models | scenes/scene_import.h | a scene for model files |
/// | prepare_scene_entities, SceneEntities | scenes/scene_entities.h | meshes and fields |
/// | SceneEntityOptions | scenes/scene_entities.h | options of this preparation |
/// | fine_meshes, surface_meshes | scenes/scene_entities.h | the meshes to be shaded |
/// | shaded_scene | scenes/scene_shading.h | the scene for shading |
/// | baked_scene, BakeOptions | scenes/scene_bake.h | shades a scene with textures and passes |
/// | search_start, search_fields | scenes/bake_search.h | the entities for a bake with a target error |
/// | BakedInstance | scenes/baked_instance.h | an instance with the radiance of its vertices |
/// | original_bake | scenes/original_vertices.h | values at the vertices of the model files |
/// | scene_budget | scenes/scene_budget.h | the error of each approximation |
/// | Surface, layered_radiance | scenes/surface.h | materials with images |
/// | read_image, write_image, read_environment_image | scenes/image.h | image files |
/// | scene_camera | scenes/scene_camera.h | places the camera if the file does not |
///
/// A Scene is plain data, which a program can also fill in itself. Lengths are in metres and angles in
/// radians; scene files have degrees.
///
/// A complete program: a relighting session in which the light rotates. The argument is a scene file, such as
/// the installed scenes/single_chair.toml. Link with haarfield::scenes.
///
/// ```cpp
/// #include "scenes/scenes.h"
///
/// #include <cstdio>
///
/// using namespace haarfield;
///
/// // Mean luminance of all vertices.
/// double brightness(const SceneColours& radiance) {
///     double sum = 0, vertices = 0;
///     for (const std::vector<Rgb>& instance : radiance)
///         for (const Rgb& colour : instance) sum += double(luminance(colour)), ++vertices;
///     return sum / vertices;
/// }
///
/// int main(int, char** arguments) {
///     Result<Scene> scene = read_scene(arguments[1]);
///     if (!scene) return std::puts(scene.error().message().c_str()), 1;
///     for (Entity& entity : scene->entities) {  // coarse, for a quick result
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
///     if (const Result<Done> done = session.commit(); !done) return 1;  // shades everything
///     const double before = brightness(session.radiance());
///     if (const Result<Done> done = session.vary_light(); !done) return 1;  // computes transfer vectors
///     for (int step = 0; step < 8; ++step) {
///         session.turn_environment(rotation_about({0, 1, 0}, step * pi / 4));
///         if (const Result<Done> done = session.frame(); !done) return 1;  // milliseconds
///         std::printf("turned by %3d degrees: %.4f, was %.4f\n", 45 * step,
///                     brightness(session.radiance()), before);
///     }
///     return brightness(session.radiance()) > 0 ? 0 : 1;
/// }
/// ```

#include "scenes/baked_instance.h"
#include "scenes/image.h"
#include "scenes/original_vertices.h"
#include "scenes/scene_bake.h"
#include "scenes/scene_budget.h"
#include "scenes/scene_camera.h"
#include "scenes/scene_comments.h"
#include "scenes/scene_entities.h"
#include "scenes/scene_import.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_shading.h"
#include "scenes/scene_writer.h"
#include "shading/shading.h"
