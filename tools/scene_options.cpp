#include "tools/scene_options.h"

#include "fields/base/names.h"
#include "scenes/scene_camera.h"
#include "scenes/scene_environment.h"
#include "scenes/scene_reader.h"
#include "tools/number_option.h"

#include <fmt/format.h>

namespace haarfield {

namespace {

constexpr Range shares{0, 1, false, true};
constexpr Range exposures{-60, 60};  // [stops]
constexpr Range bounce_numbers{0, any_bounces};
constexpr const char* automatic = "auto";

constexpr double much_clipped = 0.02;  // share of the objects' pixels

Result<Done> apply_view(const SceneOptions& options, Camera& camera) {
    if (options.view.empty()) return Done{};
    camera.position = Vec3f(options.view[0], options.view[1], options.view[2]);
    if (!((camera.target - camera.position).length() > 1e-6f))
        return Error{"--view", "is the camera's target; wanted another place"};
    return Done{};
}

}  // namespace

void add_scene_option(CLI::App& command, SceneOptions& options) {
    command.add_option("SCENE", options.scene, "The scene file (TOML)")->required()->type_name("");
}

void add_view_options(CLI::App& command, SceneOptions& options) {
    command
        .add_option("--environment", options.environment,
                    "Light from this lat-long image instead of the scene's")
        ->type_name("FILE");
    add_number_or_word(command, "--exposure", options.exposure,
                       "Instead of the scene's: the light is multiplied by 2^STOPS; auto: so that white "
                       "paint is just not clipped",
                       exposures, automatic)
        ->type_name("STOPS");
    CLI::Option* view = add_number(command, "--view", options.view,
                                   "Move the camera here; it keeps looking at its target", coordinates)
                            ->delimiter(',')
                            ->expected(3)
                            ->type_name("X,Y,Z");
    command
        .add_flag("--frame", options.frame,
                  "Show all objects from the front right, as without a camera in the scene")
        ->excludes(view);
}

void add_picture_options(CLI::App& command, SceneOptions& options) {
    add_view_options(command, options);
    add_number(command, "--antialiasing", options.antialiasing,
               "POV-Ray traces N x N rays a pixel at edges; 0: one", {0, 9})
        ->capture_default_str()
        ->type_name("N");
    add_number(command, "--povray-patience", options.patience,
               "A POV-Ray that tells of no progress for so many seconds is ended", {0.1, 1e6})
        ->capture_default_str()
        ->type_name("S");
}

Result<Scene> opened_scene(const SceneOptions& options) {
    Result<Scene> scene = read_scene(options.scene);
    if (!scene) return scene;
    if (!options.environment.empty()) {
        scene->environment.image = options.environment;
        scene->environment.sky.reset();
    }
    if (options.exposure == automatic)
        scene->environment.exposure.reset();
    else if (const std::optional<double> stops = number_in(exposures, options.exposure))
        scene->environment.exposure = static_cast<float>(*stops);
    if (options.frame) scene->finds_camera = true;
    if (!scene->finds_camera)
        if (const Result<Done> good = apply_view(options, scene->camera); !good) return good.error();
    return scene;
}

Result<Done> place_camera(Scene& scene, const SceneEntities& entities, const SceneOptions& options,
                          CommandContext& context) {
    const bool is_found = scene.finds_camera;
    Camera& camera = scene.camera;
    if (is_found) {
        camera = scene_camera(scene, entities);
        scene.finds_camera = false;
        if (const Result<Done> good = apply_view(options, camera); !good) return good;
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
    Result<SceneEnvironment> light = scene_environment(scene);
    if (!light) return light.error();
    for (const std::string& warning : light->warnings) context.warn(warning);
    context.report["environments"].push_back(
        {{"from", light->from}, {"exposure", light->exposure}, {"found", light->is_found}});
    if (light->is_found) context.print("light  {}, exposure {:.2f} stops\n", light->from, light->exposure);
    return std::move(light->environment);
}

float expose_room(const Scene& scene, const SceneEntities& entities, Environment& environment,
                  CommandContext& context, std::size_t number) {
    const float stops = room_stops(scene, entities, environment);
    if (stops == 0) return 0;
    environment = turned_environment(environment, 0, double(stops));
    auto& exposure = context.report["environments"][number]["exposure"];
    exposure = exposure.get<float>() + stops;
    context.print("light  exposure {:.2f} stops, because the camera is in a room\n", exposure.get<float>());
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
        context.message(
            fmt::format("{:.1f} % of the objects' pixels are brighter than 1, and clipped in the "
                        ".png; --exposure changes that",
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
    // With an instance's name and an ending behind it, it must still be the name of a file.
    constexpr std::size_t longest = 60, kept = 50;
    const std::string plain = plain_name(scene.name);
    if (plain.size() <= longest) return plain;
    std::uint32_t sum = 2166136261;  // FNV-1a: names that differ only behind what is kept stay apart
    for (const char c : scene.name) sum = (sum ^ static_cast<std::uint8_t>(c)) * 16777619;
    return fmt::format("{}_{:08x}", plain.substr(0, kept), sum);
}

void add_occlusion_options(CLI::App& command, OcclusionOptions& options) {
    command
        .add_option("--occlusion", options.choice,
                    "How vertices see past other objects. fields: between samples of their fields, fast; "
                    "exact: rasterized at the vertex; auto: that only where a field's own estimate of its "
                    "error is too large")
        ->check(CLI::IsMember({"fields", "exact", "auto"}))
        ->capture_default_str();
    add_number(command, "--occlusion-error", options.error,
               "What is too large for --occlusion auto: RMS error of visibility, of which `info` shows "
               "the estimates",
               shares)
        ->capture_default_str()
        ->type_name("E");
    add_number(
        command, "--reach", options.reach,
        "How far an object casts shadows: its radii, of the sphere round it. What lies beyond hides at "
        "most 1 / R^2 of the light",
        {1, 1e4})
        ->capture_default_str()
        ->type_name("R");
}

void apply_occlusion(const OcclusionOptions& options, RenderSettings& settings) {
    settings.occlusion = options.choice == "fields"  ? Occlusion::fields
                         : options.choice == "exact" ? Occlusion::exact
                                                     : Occlusion::automatic;
    settings.occlusion_error = options.error;
    settings.reach = options.reach;
}

void add_unsealed_option(CLI::App& command, bool& allow_unsealed) {
    command.add_flag("--allow-unsealed", allow_unsealed,
                     "Take fields that another program saved again, if their own checksums hold");
}

void add_field_options(CLI::App& command, FieldOptions& options) {
    command
        .add_option("--fields", options.folder,
                    "Folder of the visibility fields (default: fields/ in the output)")
        ->type_name("DIR");
    command.add_option("--face-size", options.face_size, "Texels along an edge of the cubemaps")
        ->check(CLI::IsMember(std::vector<std::string>{"16", "32", "64", "128", "256"}))
        ->capture_default_str()
        ->type_name("N");
    add_number(command, "--coefficients", options.coefficients,
               "At most so many wavelets of visibility a cubemap face; 0: no limit", {0, 65536})
        ->capture_default_str()
        ->type_name("M");
    add_number(command, "--visibility-error", options.relative_l2_error,
               "Drop wavelets of visibility up to this part of what is blocked or of what is open, whichever "
               "is less (L2, of each cubemap); 0: none",
               shares)
        ->capture_default_str()
        ->type_name("E");
    add_unsealed_option(command, options.allow_unsealed);
}

CLI::Option* add_original_vertices(CLI::App& command, FieldOptions& options) {
    return command.add_flag("--original-vertices", options.original_vertices,
                            "At the vertices that the models' files list, and no others: the scene's "
                            "fine_vertices are without effect");
}

SceneEntityOptions entity_options(const FieldOptions& options, const std::filesystem::path& output) {
    SceneEntityOptions wanted;
    wanted.fields_folder = options.folder.empty() ? output / "fields" : std::filesystem::path(options.folder);
    wanted.face_size = options.face_size;
    wanted.coefficients = options.coefficients;
    wanted.relative_l2_error = options.relative_l2_error;
    wanted.original_vertices = options.original_vertices;
    if (options.allow_unsealed) wanted.unsealed = Unsealed::allowed;
    return wanted;
}

Result<SceneEntities> opened_entities(const Scene& scene, const FieldOptions& options,
                                      const std::filesystem::path& output, CommandContext& context) {
    const SceneEntityOptions wanted = entity_options(options, output);
    Result<SceneEntities> entities = prepare_scene_entities(scene, wanted, context.progress);
    if (!entities) return entities;
    for (const std::string& warning : entities->warnings) context.warn(warning);

    context.report["fields"] = nlohmann::json::array();
    for (const auto& entity : entities->entities) {
        const VisibilityField& field = entity->field;
        const std::size_t samples =
            field.planar_handles.size() + field.spherical_handles.size() + field.local_handles.size();
        std::error_code unknown;
        const std::uintmax_t bytes = std::filesystem::file_size(entity->field_file, unknown);
        if (!entity->remade_because.empty()) context.message("field remade: " + entity->remade_because);
        context.report["fields"].push_back({{"entity", entity->name},
                                            {"reused", entity->reused},
                                            {"surroundings_reused", entity->surroundings_reused},
                                            {"samples", samples},
                                            {"nodes", node_count(field.pool)},
                                            {"bytes", unknown ? 0 : bytes},
                                            {"seconds", entity->field_seconds},
                                            {"mesh_seconds", entity->mesh_seconds},
                                            {"remade_because", entity->remade_because},
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

void add_shading_options(CLI::App& command, RenderSettings& settings) {
    add_number(command, "--depth", settings.depth,
               "Levels of the trees that take part: less is faster and coarser", {0, full_depth})
        ->capture_default_str()
        ->type_name("D");
    add_number(command, "--light-coefficients", settings.light_coefficients,
               "Wavelets kept a cubemap face, of lighting; 0: all", {0, 65536})
        ->capture_default_str()
        ->type_name("M");
}

void add_bounce_options(CLI::App& command, BounceOptions& options) {
    add_number_or_word(
        command, "--bounces", options.bounces,
        "How many times light goes from one diffuse surface to another; 0: direct light alone; "
        "auto: as often as it changes more than a thousandth",
        bounce_numbers, automatic)
        ->capture_default_str()
        ->type_name("N");
}

void apply_bounces(const BounceOptions& options, RenderSettings& settings) {
    const std::optional<double> number = number_in(bounce_numbers, options.bounces, /*whole=*/true);
    settings.bounces.most = number ? static_cast<int>(*number) : any_bounces;
}

Result<SceneEntities> opened_originals(const Scene& scene, CommandContext& context) {
    Result<SceneEntities> entities = original_entities(scene, context.progress);
    if (!entities) return entities;
    for (const std::string& warning : entities->warnings) context.warn(warning);
    return entities;
}

Result<TracedScene> opened_for_tracing(Scene& scene, const SceneOptions& options, CommandContext& context) {
    Result<Environment> environment = opened_environment(scene, context);
    if (!environment) return environment.error();
    Result<SceneEntities> entities = opened_originals(scene, context);
    if (!entities) return entities.error();
    if (const Result<Done> placed = place_camera(scene, *entities, options, context); !placed)
        return placed.error();
    expose_room(scene, *entities, *environment, context);
    std::vector<ReferenceInstance> instances = reference_instances(scene, *entities);
    return TracedScene{std::move(*environment), std::move(*entities), std::move(instances)};
}

}  // namespace haarfield
