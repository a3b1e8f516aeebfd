#include "tools/scene_options.h"

#include "fields/base/names.h"
#include "scenes/scene_camera.h"
#include "scenes/scene_environment.h"
#include "scenes/scene_reader.h"
#include "tools/number_option.h"

#include <fmt/format.h>

namespace haarfield {

namespace {

constexpr Range exposures{-60, 60};  // [stops]
constexpr const char* automatic = "auto";

constexpr double much_clipped = 0.02;  // fraction of the objects' pixels

Result<Done> apply_view(const SceneOptions& options, Camera& camera) {
    if (options.view.empty()) return Done{};
    camera.position = Vec3f(options.view[0], options.view[1], options.view[2]);
    if (!((camera.target - camera.position).length() > 1e-6f))
        return Error{"--view", "is the camera's target; expected another position"};
    return Done{};
}

}  // namespace

void add_scene_option(CLI::App& command, SceneOptions& options) {
    command.add_option("SCENE", options.scene, "The scene file (TOML)")->required()->type_name("");
}

void add_view_options(CLI::App& command, SceneOptions& options) {
    command
        .add_option("--environment", options.environment,
                    "A lat-long image instead of the scene's environment")
        ->type_name("FILE")
        ->group(shown_group);
    add_number_or_word(
        command, "--exposure", options.exposure,
        "Exposure instead of the scene's: radiance times 2^STOPS\n`auto`: the largest exposure "
        "at which a white diffuse sphere (albedo 0.8) does not exceed 1.",
        exposures, automatic)
        ->type_name("STOPS")
        ->group(shown_group);
    CLI::Option* view =
        add_number(command, "--view", options.view, "Position of the camera; the target stays", coordinates)
            ->delimiter(',')
            ->expected(3)
            ->allow_extra_args(false)
            ->type_name("X,Y,Z")
            ->group(shown_group);
    command
        .add_flag("--frame", options.frame,
                  "Place the camera so that it shows all objects from the front right")
        ->excludes(view)
        ->group(shown_group);
}

void add_picture_options(CLI::App& command, SceneOptions& options) {
    add_view_options(command, options);
    add_number(command, "--antialiasing", options.antialiasing,
               "POV-Ray traces N x N rays per pixel at edges; 0: one ray", {0, 9})
        ->capture_default_str()
        ->type_name("N")
        ->group(accuracy_group);
    add_number(command, "--povray-patience", options.patience,
               "End POV-Ray after this many seconds without progress", {0.1, 1e6})
        ->capture_default_str()
        ->type_name("S")
        ->group(speed_group);
}

Result<Scene> opened_scene(const SceneOptions& options) {
    Result<Scene> scene = read_scene(options.scene);
    if (!scene) return scene;
    if (!options.environment.empty()) {
        scene->environment.image = options.environment;
        scene->environment.sky.reset();
        scene->environment.lights = true;
    }
    if (options.exposure == automatic)
        scene->environment.exposure.reset();
    else if (const std::optional<double> stops = number_in(exposures, options.exposure))
        scene->environment.exposure = static_cast<float>(*stops);
    if (options.frame) scene->finds_camera = true;
    if (!scene->finds_camera) HF_TRY_DONE(apply_view(options, scene->camera));
    return scene;
}

Result<Done> place_camera(Scene& scene, const SceneEntities& entities, const SceneOptions& options,
                          CommandContext& context) {
    const bool is_found = scene.finds_camera;
    Camera& camera = scene.camera;
    if (is_found) {
        camera = scene_camera(scene, entities);
        scene.finds_camera = false;
        HF_TRY_DONE(apply_view(options, camera));
        context.print("camera position = [{:.6g}, {:.6g}, {:.6g}], target = [{:.6g}, {:.6g}, {:.6g}]\n",
                      camera.position.x, camera.position.y, camera.position.z, camera.target.x,
                      camera.target.y, camera.target.z);
    }
    for (const std::string& trouble : camera_troubles(scene, entities)) context.warn(trouble);
    context.report["camera"] = {{"position", {camera.position.x, camera.position.y, camera.position.z}},
                                {"target", {camera.target.x, camera.target.y, camera.target.z}},
                                {"found", is_found}};
    return Done{};
}

Result<Environment> opened_environment(const Scene& scene, CommandContext& context) {
    HF_TRY(SceneEnvironment light, scene_environment(scene));
    for (const std::string& warning : light.warnings) context.warn(warning);
    context.report["environments"].push_back(
        {{"from", light.from}, {"exposure", light.exposure}, {"found", light.is_found}});
    if (light.is_found) context.print("light  {}, exposure {:.2f} stops\n", light.from, light.exposure);
    return std::move(light.environment);
}

float expose_room(const Scene& scene, const SceneEntities& entities, Environment& environment,
                  CommandContext& context, std::size_t number) {
    const float stops = entity_stops(scene, entities, environment);
    if (stops == 0) return 0;
    environment = turned_environment(std::move(environment), 0, double(stops));
    auto& exposure = context.report["environments"][number]["exposure"];
    exposure = exposure.get<float>() + stops;
    context.print("light  exposure {:.2f} stops, because {}\n", exposure.get<float>(),
                  stops > 0 ? "the camera is in a room" : "surfaces emit light");
    return stops;
}

PovrayOptions povray_options(const Scene& scene, const SceneOptions& options, const CommandContext& context) {
    PovrayOptions povray = picture_options(scene.camera, options.antialiasing);
    povray.threads = context.threads;
    povray.patience = options.patience;
    return povray;
}

void report_picture(const std::filesystem::path& exr, const Image& objects, std::span<const PovrayRun> runs,
                    CommandContext& context) {
    double parse_seconds = 0, trace_seconds = 0;
    for (const PovrayRun& run : runs) {
        parse_seconds += run.parse_seconds;
        trace_seconds += run.trace_seconds;
    }
    for (const std::string& warning : runs.back().warnings) context.warn("POV-Ray: " + warning);
    context.report["image"] = exr.string();
    const double clipped = clipped_share(objects);
    context.report["clipped_share"] = clipped;
    if (clipped > much_clipped)
        context.message(fmt::format(
            "{:.1f} % of the objects' pixels are brighter than 1 and clipped in the .png; use --exposure "
            "to avoid it",
            100 * clipped));
    context.report["povray"] = {{"command_line", runs.back().command_line},
                                {"parse_seconds", parse_seconds},
                                {"trace_seconds", trace_seconds}};
    context.print("image  {} (and .png), traced in {:.1f} s\n", exr.string(), trace_seconds);
}

Result<Done> write_picture(const std::filesystem::path& exr, const Image& objects,
                           const std::filesystem::path& scene, std::span<const PovrayRun> runs,
                           const PovrayOptions& povray, CommandContext& context) {
    Result<Done> written = write_with_background(objects, scene, exr, povray, context.progress);
    if (written) report_picture(exr, objects, runs, context);
    return written;
}

std::string file_stem(const Scene& scene) {
    // Followed by an instance's name and an extension, it must still be a valid file name.
    constexpr std::size_t longest = 60, kept = 50;
    const std::string plain = plain_name(scene.name);
    if (plain.size() <= longest) return plain;
    std::uint32_t sum = 2166136261;  // FNV-1a: distinguishes names that differ only after the kept part
    for (const char c : scene.name) sum = (sum ^ static_cast<std::uint8_t>(c)) * 16777619;
    return fmt::format("{}_{:08x}", plain.substr(0, kept), sum);
}

void add_render_options(CLI::App& command, RenderChoices& choices, std::initializer_list<OptionSet> sets) {
    for (const RenderOption* row : render_options(sets)) {
        const auto set = [row, &choices](const std::string& text) { row->set_text(choices, text); };
        const std::string text = row->summary + "\n" + row->details;
        if (row->is_flag) {
            command
                .add_flag_callback(
                    "--" + row->name, [set] { set("true"); }, text)
                ->group(row->group);
            continue;
        }
        const auto check = [row](const std::string& value) { return row->trouble(value); };
        CLI::Option* option = command.add_option_function<std::string>("--" + row->name, set, text)
                                  ->check(CLI::Validator(check, row->values()))
                                  ->default_str(row->text(choices))
                                  ->group(row->group);
        if (!row->type.empty()) option->type_name(row->type);
    }
}

void add_field_options(CLI::App& command, RenderChoices& choices) {
    add_render_options(command, choices, {OptionSet::fields});
    command
        .add_option("--fields", choices.entities.fields_folder,
                    "Folder of the visibility fields (default: fields/ in the output)")
        ->type_name("DIR")
        ->group(files_group);
}

SceneEntityOptions entity_options(const RenderChoices& choices, const std::filesystem::path& output) {
    SceneEntityOptions wanted = choices.entities;
    if (wanted.fields_folder.empty()) wanted.fields_folder = output / "fields";
    return wanted;
}

Result<SceneEntities> opened_entities(const Scene& scene, const RenderChoices& choices,
                                      const std::filesystem::path& output, CommandContext& context) {
    const SceneEntityOptions wanted = entity_options(choices, output);
    Result<SceneEntities> entities = prepare_scene_entities(scene, wanted, context.progress);
    if (!entities) return entities;
    for (const std::string& warning : entities->warnings) context.warn(warning);

    context.report["fields"] = nlohmann::json::array();
    if (wanted.fields == FieldExtent::none) return entities;
    for (const auto& entity : entities->entities) {
        const VisibilityField& field = entity->field;
        const std::size_t samples =
            field.planar_handles.size() + field.spherical_handles.size() + field.local_handles.size();
        std::error_code unknown;
        const std::uintmax_t bytes = std::filesystem::file_size(entity->field_file, unknown);
        if (!entity->recomputed_because.empty())
            context.message("field remade: " + entity->recomputed_because);
        context.report["fields"].push_back({{"entity", entity->name},
                                            {"reused", entity->reused},
                                            {"surroundings_reused", entity->surroundings_reused},
                                            {"samples", samples},
                                            {"nodes", node_count(field.pool)},
                                            {"bytes", unknown ? 0 : bytes},
                                            {"seconds", entity->field_seconds},
                                            {"mesh_seconds", entity->mesh_seconds},
                                            {"recomputed_because", entity->recomputed_because},
                                            {"file", entity->field_file.string()}});
        context.print("field  {:<24} {}  {} samples, {} nodes, {:.1f} MB, {:.2f} s\n", entity->name,
                      entity->reused                ? "reused"
                      : entity->surroundings_reused ? "local "
                                                    : "made  ",
                      samples, node_count(field.pool), unknown ? 0.0 : static_cast<double>(bytes) / 1e6,
                      entity->field_seconds);
    }
    return entities;
}

Result<SceneEntities> opened_originals(const Scene& scene, CommandContext& context) {
    Result<SceneEntities> entities = original_entities(scene, context.progress);
    if (!entities) return entities;
    for (const std::string& warning : entities->warnings) context.warn(warning);
    return entities;
}

Result<TracedScene> opened_for_tracing(Scene& scene, const SceneOptions& options, CommandContext& context) {
    HF_TRY(Environment environment, opened_environment(scene, context));
    HF_TRY(SceneEntities entities, opened_originals(scene, context));
    HF_TRY_DONE(place_camera(scene, entities, options, context));
    expose_room(scene, entities, environment, context);
    std::vector<ReferenceInstance> instances = reference_instances(scene, entities);
    return TracedScene{std::move(environment), std::move(entities), std::move(instances)};
}

}  // namespace haarfield
