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
    std::string environment;  ///< Instead of the scene's own, if not empty.
    std::string exposure;     ///< Instead of the scene's own, if not empty: a number, or `auto`. [stops]
    std::vector<float> view;  ///< Instead of the camera's position, if not empty: x, y, z. [m]
    bool frame = false;       ///< The camera's place is found, whatever the scene says.
    int antialiasing = 3;     ///< As PovrayOptions has it.
    double patience = PovrayOptions().patience;  ///< Likewise. [s]
};

/// Adds SCENE.
void add_scene_option(CLI::App& command, SceneOptions& options);

/// Adds --environment, --exposure, --view and --frame.
void add_view_options(CLI::App& command, SceneOptions& options);

/// Adds --antialiasing and --povray-patience, too.
void add_picture_options(CLI::App& command, SceneOptions& options);

/// Reads the scene and applies the options: those of the camera, if it is to be found, in place_camera.
Result<Scene> opened_scene(const SceneOptions& options);

/// Finds the scene's camera if it is to be found; warns where it sees nothing, and of what it is inside. The
/// report's `camera`; a line on stdout if it was found.
Result<Done> place_camera(Scene& scene, const SceneEntities& entities, const SceneOptions& options,
                          CommandContext& context);

/// The scene's light: read or made, cleaned (with a warning that counts), turned and exposed. Into the
/// report's `environments` goes where it is from, and its exposure; onto stdout, if that is found.
Result<Environment> opened_environment(const Scene& scene, CommandContext& context);

/// Adds entity_stops to the exposure of a light, in the report's `environments`, too; prints a line if there
/// are any. Returns the stops.
///
/// number  of the light in the report.
float expose_room(const Scene& scene, const SceneEntities& entities, Environment& environment,
                  CommandContext& context, std::size_t number = 0);

/// Returns the options with which POV-Ray renders a scene.
PovrayOptions povray_options(const Scene& scene, const SceneOptions& options, const CommandContext& context);

/// Says where a picture is, what POV-Ray said, and that much of it is clipped, if so; into the report go
/// `image`, `clipped_share`, and `povray`: the times of all runs together, and the command line of the last.
///
/// objects  the picture, with coverage.
void report_picture(const std::filesystem::path& exr, const Image& objects, std::span<const PovrayRun> runs,
                    CommandContext& context);

/// write_with_background and report_picture.
Result<Done> write_picture(const std::filesystem::path& exr, const Image& objects,
                           const std::filesystem::path& scene, std::span<const PovrayRun> runs,
                           const PovrayOptions& povray, CommandContext& context);

/// Returns the scene's name for POV-Ray's files: other characters than those of plain_name become `_`, and
/// long names end with a checksum.
std::string file_stem(const Scene& scene);

/// Adds --allow-unsealed, as every command that reads fields has it.
void add_unsealed_option(CLI::App& command, bool& allow_unsealed);

/// Adds the options of some sets. The choices must outlive the command.
void add_render_options(CLI::App& command, RenderChoices& choices, std::initializer_list<OptionSet> sets);

/// Adds --fields and the options of OptionSet::fields.
void add_field_options(CLI::App& command, RenderChoices& choices);

/// The options of entities, with the default of the folder of fields.
SceneEntityOptions entity_options(const RenderChoices& choices, const std::filesystem::path& output);

/// prepare_scene_entities, with warnings, messages and the report's `fields`; a line for each on stdout.
Result<SceneEntities> opened_entities(const Scene& scene, const RenderChoices& choices,
                                      const std::filesystem::path& output, CommandContext& context);

/// original_entities, with warnings.
Result<SceneEntities> opened_originals(const Scene& scene, CommandContext& context);

/// A scene for POV-Ray's ray tracer.
struct TracedScene {
    Environment environment;
    SceneEntities entities;                    ///< As their files have them.
    std::vector<ReferenceInstance> instances;  ///< Of these.
};

/// Opens what a reference needs, and finds the scene's camera.
Result<TracedScene> opened_for_tracing(Scene& scene, const SceneOptions& options, CommandContext& context);

}  // namespace haarfield
