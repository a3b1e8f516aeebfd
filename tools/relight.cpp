#include "bridge/files/movie.h"
#include "bridge/pictures/preview.h"
#include "bridge/povray/baked_scene.h"
#include "fields/file/write_file.h"
#include "scenes/scene_entities.h"
#include "scenes/scene_shading.h"
#include "tools/command.h"
#include "tools/error_report.h"
#include "tools/farm/task_share.h"
#include "tools/number_option.h"
#include "tools/relight_modes.h"
#include "tools/session_error.h"
#include "tools/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

namespace {

/// Returns the scene's environment, or those of --lights.
Result<std::vector<Environment>> opened_environments(const Scene& scene, const RelightOptions& options,
                                                     CommandContext& context) {
    std::vector<Environment> environments;
    std::vector<Scene> scenes;
    for (const std::string& file : options.lights) {
        scenes.push_back(scene);
        scenes.back().environment.image = file;
        scenes.back().environment.sky.reset();
        scenes.back().environment.lights = true;
    }
    if (scenes.empty()) scenes.push_back(scene);
    for (const Scene& lit : scenes) {
        HF_TRY(Environment environment, opened_environment(lit, context));
        environments.push_back(std::move(environment));
    }
    return environments;
}

/// Writes frames, as pictures or for POV-Ray.
class FrameWriter {
public:
    FrameWriter(const RelightStage& stage, const SceneEntities& entities)
        : stage_(stage), entities_(entities) {}

    /// Shades and writes a frame.
    ///
    /// output  an existing folder.
    /// mode    the mode that changed the scene; it determines how the frame is shaded.
    Result<Done> write(const std::filesystem::path& output, int frame, const RelightMode& mode,
                       FrameQuality quality, const Progress& progress) {
        const bool is_picture = stage_.options.format != "povray";
        RelightSession& session = *stage_.session;
        if (!is_picture || !mode.by_vertex) {
            HF_TRY_DONE(timed(
                [&] { return mode.in_full ? session.commit(progress) : session.frame(quality, progress); }));
        }
        if (!is_picture) return write_povray(output / fmt::format("frame_{:04}", frame));
        Result<Done> shaded = Done{};
        std::vector<BakedInstance> instances = displayed_instances();
        const auto shade_seen = [&](const VertexMask& seen) {
            shaded = timed([&] { return session.frame_of(seen, quality, progress); });
            if (shaded) std::ranges::copy(displayed_instances(), instances.begin());
            return bool(shaded);
        };
        const RunTime shading_before = shading_;
        const Stopwatch watch;
        const Image image = preview_.draw(
            stage_.scene.camera, instances,
            [this](const Vec3f& direction) { return stage_.background(direction); },
            mode.by_vertex ? shade_seen : BeforeReading());
        drawing_ += watch.elapsed() - (shading_ - shading_before);
        if (!shaded) return shaded;
        return write_image(image, output / fmt::format("frame_{:04}.{}", frame, stage_.options.format));
    }

    const RunTime& drawing() const { return drawing_; }  ///< Of all pictures so far.
    const RunTime& shading() const { return shading_; }  ///< Of all frames so far.

private:
    template <class Shade>
    Result<Done> timed(const Shade& shade) {
        const Stopwatch watch;
        const Result<Done> result = shade();
        shading_ += watch.elapsed();
        return result;
    }

    /// Returns the instances with the session's radiance, if it has been computed. Valid until the next call.
    std::vector<BakedInstance> displayed_instances() {
        std::vector<BakedInstance> instances;
        const bool is_shaded = !stage_.session->radiance().empty();
        seen_.resize(stage_.scene.instances.size());
        for (std::size_t i = 0; i < stage_.scene.instances.size(); ++i) {
            const SceneEntity& entity = entities_.of_instance(i);
            instances.push_back(
                baked_instance(stage_.scene.instances[i], entity, entity.mesh.fine,
                               is_shaded ? stage_.session->outgoing(i) : std::vector<Outgoing>(), seen_[i]));
        }
        return instances;
    }

    Result<Done> write_povray(const std::filesystem::path& folder) {
        const std::vector<BakedInstance> instances = displayed_instances();
        LatLongImage background = stage_.backgrounds[0];
        for (std::size_t p = 0; p < background.pixels.size(); ++p) {
            const auto width = static_cast<std::size_t>(background.width);
            background.pixels[p] =
                stage_.background(Vec3f(lat_long_direction((double(p % width) + 0.5) / background.width,
                                                           (double(p / width) + 0.5) / background.height)));
        }
        HF_TRY_DONE(write_baked_scene(folder, file_stem(stage_.scene), stage_.scene.camera, instances,
                                      BackgroundDescription{&background, false, stage_.scene.assumed_gamma}));
        return Done{};
    }

    const RelightStage& stage_;
    const SceneEntities& entities_;
    Preview preview_;
    std::vector<LayeredRadiance> seen_;  ///< By instance.
    RunTime drawing_, shading_;
};

/// Checks options beyond CLI11's checks.
Result<Done> check_options(const RelightOptions& options) {
    if (options.lights.size() == 1)
        return Error{"--lights", "found one environment; expected two or more, separated by commas"};
    if (options.format != "png" && !options.movie.empty())
        return Error{"--movie", "needs PNG pictures; expected --format png"};
    const int last = options.last_frame > 0 ? options.last_frame : options.frames;
    if (last > options.frames || options.first_frame > last)
        return Error{"--first-frame, --last-frame",
                     fmt::format("are {} and {}; expected a range within {} frames", options.first_frame,
                                 last, options.frames)};
    if (!options.movie.empty() && last - options.first_frame + 1 < options.frames)
        return Error{"--movie", "needs all frames; expected neither --first-frame nor --last-frame"};
    if (std::ranges::count(options.axis, 0.0f) == 3) return Error{"--axis", "has length 0"};
    return Done{};
}

/// Returns the range of frames to compute, counted from 0, excluding the end.
std::pair<int, int> frame_range(const RelightOptions& options, const CommandContext& context) {
    const int first = options.first_frame - 1,
              last = options.last_frame > 0 ? options.last_frame : options.frames;
    if (!context.share) return {first, last};
    const auto [begin, end] = context.share->range(static_cast<std::size_t>(last - first));
    return {first + static_cast<int>(begin), first + static_cast<int>(end)};
}

/// Measures and reports the error of the frame that the session shows.
Result<Done> report_error(RelightStage& stage, const SceneEntities& entities, CommandContext& context) {
    RelightSession& session = *stage.session;
    // A fade ends with its last environment.
    if (stage.environments.size() > 1) session.set_environment(stage.environments.back());
    Preview preview;
    HF_TRY(const BakeError error,
           session_error(session, entities, stage.scene.camera, preview, context.progress));
    if (error.points == 0) return Done{};
    context.report["error"] = error_report(error);
    context.report["error"]["frame"] = "last";
    context.print("{}\n", error_line(error, " in the last frame"));
    return Done{};
}

/// Returns the folder of a frame, counted from 0 among all frames. Tasks of a plan have a folder per part.
Result<std::filesystem::path> frame_folder(const RelightOptions& options, const CommandContext& context,
                                           int frame) {
    std::filesystem::path folder = options.output;
    if (!context.share) return folder;
    const auto all = static_cast<std::size_t>((options.last_frame > 0 ? options.last_frame : options.frames) -
                                              options.first_frame + 1),
               item = static_cast<std::size_t>(frame - (options.first_frame - 1));
    std::size_t k = 0;
    while (item >= context.share->range_of(k, all).second) ++k;
    folder /= part_folder(k);
    HF_TRY_DONE(make_folder(folder));
    return folder;
}

/// Encodes the frames as a movie if the options request one.
Result<ExitCode> filmed(const RelightOptions& options, CommandContext& context) {
    if (options.movie.empty()) return ExitCode::done;
    HF_TRY_DONE(write_movie(std::filesystem::path(options.output) / "frame_%04d.png", options.frames,
                            options.movie, options.frames_per_second, context.progress));
    context.report["movie"] = options.movie;
    context.print("movie  {}\n", options.movie);
    return ExitCode::done;
}

Result<ExitCode> run(const RelightOptions& options, CommandContext& context) {
    HF_TRY_DONE(check_options(options));
    if (context.share && context.share->joins) return filmed(options, context);
    if (!context.share && !options.movie.empty()) HF_TRY_DONE(check_encoder());
    const std::filesystem::path output = options.output;
    HF_TRY(Scene scene, opened_scene(options.scene));
    HF_TRY(std::vector<Environment> environments, opened_environments(scene, options, context));
    HF_TRY(const SceneEntities entities, opened_entities(scene, options.render, output, context));
    HF_TRY_DONE(place_camera(scene, entities, options.scene, context));
    for (std::size_t i = 0; i < environments.size(); ++i)
        expose_room(scene, entities, environments[i], context, i);

    HF_TRY_DONE(make_folder(output));
    RelightStage stage{options, std::move(scene), {}, std::move(environments), {}, {}, {}, nullptr};
    for (const Environment& environment : stage.environments)
        stage.backgrounds.push_back(image_with_suns(environment));
    stage.settings = options.render.shading;
    apply_bounces(stage.scene, stage.settings.bounces);
    stage.weights.assign(stage.environments.size(), 0);
    stage.weights[0] = 1;
    RelightSession relight(shaded_scene(stage.scene, entities, stage.environments[0]), stage.settings,
                           options.render.transfer);
    relight.separate_components(has_separate_specular(entities));
    stage.session = &relight;
    HF_TRY(const RelightMode mode, chosen_mode(stage));

    const Stopwatch watch;
    HF_TRY_DONE(relight.prepare(context.progress));
    const RunTime for_scene = watch.elapsed();
    HF_TRY_DONE(mode.prepare(context.progress));
    const RunTime setup = watch.elapsed(), for_vectors = setup - for_scene;

    RunTime changing, moving;
    FrameWriter writer(stage, entities);
    const auto [first, last] = frame_range(options, context);
    for (int frame = first; frame < last; ++frame) {
        if (context.progress.stop.stop_requested()) return interruption();
        const int steps = mode.closed ? options.frames : std::max(1, options.frames - 1);
        const bool is_at_rest = mode.rests && frame + 1 == options.frames;
        moving = changing;
        moving += writer.shading();
        const Stopwatch change_watch;
        mode.change(double(frame) / steps);
        changing += change_watch.elapsed();
        HF_TRY(const std::filesystem::path folder, frame_folder(options, context, frame));
        HF_TRY_DONE(writer.write(folder, frame + 1, mode,
                                 mode.rests && !is_at_rest ? FrameQuality::moving : FrameQuality::still,
                                 context.progress));
        if (context.progress.report)
            context.progress.report("frames", std::uint64_t(frame - first) + 1, std::uint64_t(last - first));
    }
    if (context.share) return ExitCode::done;
    RunTime shaded = changing;
    shaded += writer.shading();
    const int made = last - first;
    const bool has_rest = mode.rests && made > 1 && last == options.frames;
    const RunTime a_frame = has_rest ? moving / (made - 1) : shaded / made, rest = shaded - moving,
                  a_picture = writer.drawing() / made;
    context.report["mode"] = mode.name;
    report_time(context.report, "setup", setup);
    report_time(context.report, "scene", for_scene);
    report_time(context.report, "vector", for_vectors);
    context.report["transfer_bytes"] = relight.transfer_bytes();
    context.report["frames"] = made;
    context.report["frames_per_second"] = 1 / a_frame.wall;
    report_time(context.report, "frame", a_frame);
    if (has_rest) report_time(context.report, "rest", rest);
    report_time(context.report, "preview", a_picture);
    context.print(
        "setup  {:.2f} s: {:.2f} s for the scene, {:.2f} s for {:.1f} MB of transfer vectors\n"
        "frames {} in {}, {:.1f} per second, {:.0f} ms per picture\n",
        setup.wall, for_scene.wall, for_vectors.wall, double(relight.transfer_bytes()) / 1e6, made,
        output.string(), 1 / a_frame.wall, a_picture.wall * 1e3);
    if (has_rest) context.print("rest   {:.2f} s for the last frame, at full quality\n", rest.wall);
    if (last == options.frames) HF_TRY_DONE(report_error(stage, entities, context));

    return filmed(options, context);
}

std::string path_trouble(const std::string& text) {
    return path_points(text) ? "" : fmt::format("is {}; expected positions X,Y,Z, separated by :", text);
}

std::string turn_trouble(const std::string& text) {
    return place_in(text) ? "" : fmt::format("is {}; expected degrees X,Y,Z", text);
}

}  // namespace

Command relight_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("relight", "Render frames with changing light, view or positions");
    const auto options = std::make_shared<RelightOptions>();
    add_scene_option(*app, options->scene);
    app->add_option("-o,--output", options->output, "Folder for the frames")->required()->type_name("DIR");
    add_view_options(*app, options->scene);
    options->render.shading.occlusion = Occlusion::fields;  // moving objects use their fields; short set-up
    add_render_options(*app, options->render, {OptionSet::occlusion, OptionSet::frames});
    add_field_options(*app, options->render);
    CLI::Option_group* modes =
        app->add_option_group("Modes", "What changes: one of these options, or --move and --rotate together");
    CLI::Option* spin =
        modes->add_flag("--spin-light", options->spin_light, "Turn the environment by 360 degrees");
    modes->add_option("--lights", options->lights, "Fade from one lat-long image to the next")
        ->delimiter(',')
        ->excludes(app->get_option("--environment"))
        ->type_name("A,B,...");
    modes->add_flag("--orbit", options->orbit, "Move the camera on a circle around its target");
    modes
        ->add_option(
            "--move", options->moves,
            "Move an instance from its place along a path X,Y,Z:X,Y,Z:... Repeat for further instances")
        ->check(CLI::Validator(path_trouble, "").application_index(1))
        ->type_name("INSTANCE PATH");
    modes
        ->add_option(
            "--rotate", options->turns,
            "Turn an instance by this many degrees in total, about x, then y, then z: X,Y,Z. Can be "
            "combined with --move. Frames with rotations or with several instances are shaded in full")
        ->check(CLI::Validator(turn_trouble, "").application_index(1))
        ->type_name("INSTANCE DEGREES");
    modes->add_flag(
        "--keyframes", options->keyframes,
        "Change instances and lamps according to the scene's [[keyframes]], from time 0 to the last one");
    for (const char* one : {"--spin-light", "--lights", "--orbit", "--keyframes"})
        for (const char* other : {"--spin-light", "--lights", "--orbit", "--keyframes", "--move", "--rotate"})
            if (std::string_view(one) != other) modes->get_option(one)->excludes(modes->get_option(other));
    modes->require_option(1, 2);
    add_number(*app, "--axis", options->axis, "Axis of --spin-light (default: 0,1,0)", coordinates)
        ->needs(spin)
        ->delimiter(',')
        ->expected(3)
        ->type_name("X,Y,Z");
    add_number(*app, "--frames", options->frames, "Number of frames", {1, 9999})
        ->capture_default_str()
        ->type_name("N");
    add_number(*app, "--first-frame", options->first_frame, "First frame to render", {1, 9999})
        ->capture_default_str()
        ->type_name("N");
    add_number(*app, "--last-frame", options->last_frame,
               "Last frame to render (default: the last of --frames)", {1, 9999})
        ->type_name("N");
    app->add_option("--format", options->format,
                    "png, exr: quick pictures; povray: a POV-Ray scene per frame")
        ->check(CLI::IsMember({"png", "exr", "povray"}))
        ->capture_default_str();
    app->add_option("--movie", options->movie, "Encode the frames as a movie, with ffmpeg")
        ->type_name("FILE.mp4");
    add_number(*app, "--fps", options->frames_per_second, "Frames per second of the movie", {1, 240})
        ->capture_default_str()
        ->type_name("N");
    app->footer(
        "Example:\n  haarfield relight scenes/table_and_chairs.toml -o out/spin --spin-light --frames 24\n"
        "writes out/spin/frame_0001.png and so on. --move chair_1 0,0.5,0:1,0,0 lifts a chair and sets it\n"
        "down again; adding --rotate chair_1 0,90,0 also turns it.");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
