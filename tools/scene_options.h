#pragma once
/// Options and steps that commands share: the scene, changes to it, its light, its fields and its shading.

#include "bridge/povray/povray_process.h"
#include "bridge/povray/reference_scene.h"
#include "scenes/scene.h"
#include "scenes/scene_entities.h"
#include "tools/command.h"
#include "tools/render_options.h"

#include <optional>
#include <span>
#include <vector>

namespace haarfield {

struct SceneOptions {
    std::string scene;        ///< The file.
    std::string environment;  ///< If not empty, replaces the scene's environment.
    std::string exposure;     ///< If not empty, replaces the scene's exposure: a number, or `auto`. [stops]
    std::vector<float> view;  ///< If not empty, replaces the camera's position: x, y, z. [m]
    bool frame = false;       ///< True: scene_camera places the camera, even if the scene does.
    int antialiasing = 3;     ///< PovrayOptions::antialiasing.
    double patience = PovrayOptions().patience;  ///< PovrayOptions::patience. [s]
};

/// Adds SCENE.
void add_scene_option(CLI::App& command, SceneOptions& options);

/// Adds --environment, --exposure, --view and --frame.
void add_view_options(CLI::App& command, SceneOptions& options);

/// Adds the options of add_view_options, --antialiasing and --povray-patience.
void add_picture_options(CLI::App& command, SceneOptions& options);

/// Reads the scene and applies the options. If the camera is to be found, place_camera applies those of the
/// camera.
Result<Scene> opened_scene(const SceneOptions& options);

/// Places the scene's camera if it is to be found, and prints its position. Prints the camera_troubles as
/// warnings. Adds `camera` to the report.
Result<Done> place_camera(Scene& scene, const SceneEntities& entities, const SceneOptions& options,
                          CommandContext& context);

/// Returns the scene_environment. Prints its warnings, and its exposure if that was found. Adds the origin
/// and the exposure to the report's `environments`.
Result<Environment> opened_environment(const Scene& scene, CommandContext& context);

/// Adds entity_stops to the exposure of a light and to that in the report's `environments`. Prints the stops
/// unless they are 0, and returns them.
///
/// number  index of the light in the report.
float expose_room(const Scene& scene, const SceneEntities& entities, Environment& environment,
                  CommandContext& context, std::size_t number = 0);

/// Returns the options with which POV-Ray renders a scene.
PovrayOptions povray_options(const Scene& scene, const SceneOptions& options, const CommandContext& context);

/// Prints the file of a picture and POV-Ray's warnings. Warns if a large fraction of the picture clips. Adds
/// `image`, `clipped_share` and `povray` to the report: the total times of all runs, and the command line of
/// the last run.
///
/// objects  the picture, with coverage.
void report_picture(const std::filesystem::path& exr, const Image& objects, std::span<const PovrayRun> runs,
                    CommandContext& context);

/// Calls write_with_background, then report_picture.
Result<Done> write_picture(const std::filesystem::path& exr, const Image& objects,
                           const std::filesystem::path& scene, std::span<const PovrayRun> runs,
                           const PovrayOptions& povray, CommandContext& context);

/// Returns the scene's name for POV-Ray's files: its plain_name. Long names are shortened and end with a
/// checksum.
std::string file_stem(const Scene& scene);

/// Adds the options of some sets. The choices must outlive the command.
void add_render_options(CLI::App& command, RenderChoices& choices, std::initializer_list<OptionSet> sets);

/// Adds --fields and the options of OptionSet::fields.
void add_field_options(CLI::App& command, RenderChoices& choices);

/// Returns the options of entities. If no folder of fields was chosen, it is `fields` in the output folder.
SceneEntityOptions entity_options(const RenderChoices& choices, const std::filesystem::path& output);

/// Calls prepare_scene_entities. Prints its warnings and a line per field, and adds `fields` to the report.
Result<SceneEntities> opened_entities(const Scene& scene, const RenderChoices& choices,
                                      const std::filesystem::path& output, CommandContext& context);

/// Calls original_entities and prints its warnings.
Result<SceneEntities> opened_originals(const Scene& scene, CommandContext& context);

/// A scene for POV-Ray's ray tracer.
struct TracedScene {
    Environment environment;
    SceneEntities entities;                    ///< original_entities.
    std::vector<ReferenceInstance> instances;  ///< reference_instances of these entities.
};

/// Reads the meshes and the light for a reference, and places the scene's camera.
Result<TracedScene> opened_for_tracing(Scene& scene, const SceneOptions& options, CommandContext& context);

}  // namespace haarfield
