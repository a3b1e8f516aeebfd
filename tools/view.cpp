#include "fields/file/input_file.h"
#include "scenes/scene_shading.h"
#include "tools/number_option.h"
#include "tools/view/page_files.h"
#include "tools/view/view_server.h"
#include "tools/view/view_session.h"
#include "tools/view/web_access.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <charconv>

namespace haarfield {

namespace {

struct ViewOptions {
    SceneOptions scene;
    RenderChoices render;
    std::string output;
    std::string lights;  ///< A folder.
    std::string address = "127.0.0.1";
    int port = 0;
    bool open = false;
    int upload_megabytes = 64;
};

/// Answers the requests of pages.
class Site {
public:
    Site(ViewSession& session, LightShelf& shelf) : session_(session), shelf_(shelf) {}

    WebAnswer get(std::string_view path) const {
        if (std::optional<std::string> file = page_file(path))
            return {200, content_type(path), std::move(*file)};
        const auto below = [&](std::string_view folder) {
            const bool is_there = path.starts_with(folder);
            if (is_there) path.remove_prefix(folder.size());
            return is_there;
        };
        if (below("mesh/")) return mesh(path);
        if (below("texture/")) return texture(path);
        if (below("thumbnail/")) return light(path, "image/png", thumbnail_png);
        if (below("background/")) return light(path, "application/octet-stream", background_bytes);
        if (below("made/")) return made(path);
        return missing();
    }

    WebAnswer upload(std::string_view name, std::string_view bytes) const {
        const Result<std::string> added = shelf_.add(name, bytes);
        if (!added) return {400, "application/json", message_text({{"error", added.error().message()}})};
        session_.lights_changed();
        return {200, "application/json", message_text({{"light", *added}})};
    }

private:
    static WebAnswer missing() { return {404, "text/plain", "Not found.\n"}; }

    static std::optional<std::size_t> number(std::string_view text) {
        std::size_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
        return value;
    }

    const SceneEntity* entity(std::string_view text) const {
        const std::optional<std::size_t> place = number(text);
        const auto& entities = session_.entities().entities;
        return place && *place < entities.size() ? entities[*place].get() : nullptr;
    }

    WebAnswer mesh(std::string_view path) const {
        const SceneEntity* found = entity(path);
        if (!found) return missing();
        return {200, "application/octet-stream", mesh_bytes(found->mesh.fine)};
    }

    WebAnswer texture(std::string_view path) const {
        const std::size_t slash = std::min(path.find('/'), path.size());
        const SceneEntity* found = entity(path.substr(0, slash));
        const std::optional<std::size_t> part = number(path.substr(std::min(slash + 1, path.size())));
        if (!found || !part || *part >= found->surfaces.size() || !found->surfaces[*part].texture)
            return missing();
        const Texture& image = *found->surfaces[*part].texture;
        const Result<std::string> png = png_bytes(image.texels, image.width, image.height, image.has_alpha);
        if (!png) return {500, "text/plain", png.error().message()};
        return {200, "image/png", *png};
    }

    template <class Bytes>
    WebAnswer light(std::string_view name, const char* type, const Bytes& bytes_of) const {
        const std::optional<ShelfLight> found = shelf_.find(name);
        if (!found) return missing();
        const Result<std::string> bytes = bytes_of(*found);
        if (!bytes) return {500, "text/plain", bytes.error().message()};
        return {200, type, *bytes};
    }

    WebAnswer made(std::string_view name) const {
        const std::optional<std::filesystem::path> file = session_.made_file(name);
        if (!file) return missing();
        constexpr std::uint64_t largest = std::uint64_t{4} << 30;
        const Result<std::string> bytes = read_whole_file(*file, largest);
        if (!bytes) return missing();
        return {200, content_type(name), *bytes, std::string(name)};
    }

    ViewSession& session_;
    LightShelf& shelf_;
};

void open_in_browser(const std::string& url) {
    // In a new session, so that Ctrl-C ends this program alone.
    const std::string command = fmt::format("setsid xdg-open '{}' >/dev/null 2>&1 &", url);
    if (std::system(command.c_str()) != 0) print(stderr, "haarfield view: cannot run xdg-open\n");
}

Result<ExitCode> run(const ViewOptions& options, CommandContext& context) {
    const std::filesystem::path file = options.scene.scene;
    const std::filesystem::path output = options.output.empty()
                                             ? file.parent_path() / (file.stem().string() + "_view")
                                             : std::filesystem::path(options.output);
    HF_TRY(Scene scene, opened_scene(options.scene));
    WebLimits limits;
    limits.upload_bytes = std::size_t(options.upload_megabytes) << 20;
    HF_TRY(const std::unique_ptr<ViewServer> listening,
           ViewServer::listen(options.address, static_cast<std::uint16_t>(options.port), random_token(),
                              limits));
    ViewServer& server = *listening;

    HF_TRY(SceneEntities entities, opened_entities(scene, options.render, output, context));
    HF_TRY(Environment light, opened_environment(scene, context));
    HF_TRY_DONE(place_camera(scene, entities, options.scene, context));
    if (expose_room(scene, entities, light, context) != 0)
        scene.environment.exposure = context.report["environments"][0]["exposure"].get<float>();

    std::filesystem::path lights = options.lights;
    if (lights.empty() && !scene.environment.sky) lights = scene.environment.image.parent_path();
    LightShelf shelf(scene.environment, lights, output / "lights");
    ViewSettings settings;
    settings.render = options.render.shading;
    apply_bounces(scene, settings.render.bounces);
    settings.transfer = options.render.transfer;
    settings.scene_file = file;
    settings.session = random_token();
    settings.tasks = {options.render, output, context.threads};
    settings.tasks.render.shading.bounces = settings.render.bounces;
    settings.tasks.render.entities = entity_options(options.render, output);
    const Audience audience{[&](PageId page, const std::string& text) { server.tell(page, text); },
                            [&](const std::string& text) { server.tell_all(text); },
                            [&](SharedBytes frame) { server.show_all(std::move(frame)); },
                            [&](PageId page, SharedBytes frame) { server.show(page, std::move(frame)); },
                            [&](PageId page) { server.shown(page); }};
    ViewSession session(scene, std::move(entities), settings, shelf, audience);
    const Site site(session, shelf);

    print(stdout, "{}\n", server.url());
    std::fflush(stdout);
    if (options.open) open_in_browser(server.url());
    server.run({[&](std::string_view path) { return site.get(path); },
                [&](std::string_view name, std::string_view bytes) { return site.upload(name, bytes); },
                [&](PageId page) { session.join(page); }, [&](PageId page) { session.leave(page); },
                [&](PageId page, std::string_view text) { session.receive(page, text); }},
               context.progress.stop);
    return ExitCode::done;
}

}  // namespace

Command view_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("view", "Display and edit a scene in the browser");
    const auto options = std::make_shared<ViewOptions>();
    add_scene_option(*app, options->scene);
    app->add_option(
           "-o,--output", options->output,
           "Folder for fields, uploaded lights, bakes and pictures (default: NAME_view next to the scene)")
        ->type_name("DIR");
    add_view_options(*app, options->scene);
    add_render_options(*app, options->render, {OptionSet::occlusion, OptionSet::frames});
    add_field_options(*app, options->render);
    app->add_option("--lights", options->lights,
                    "Folder of lat-long images to choose from (default: that of the scene's environment)")
        ->type_name("DIR");
    add_number(*app, "--port", options->port, "Port to listen on; 0: a free one", {0, 65535})
        ->capture_default_str()
        ->type_name("N");
    app->add_option("--listen", options->address,
                    "Address to listen on. Anyone who can reach an address other than the loopback and knows "
                    "the token can change the scene")
        ->capture_default_str()
        ->type_name("ADDRESS");
    app->add_flag("--open", options->open, "Open the page in the browser");
    add_number(*app, "--upload-limit", options->upload_megabytes, "Largest size of an uploaded light [MB]",
               {1, 4096})
        ->capture_default_str()
        ->type_name("N");
    app->footer(
        "Example:\n  haarfield view scenes/table_and_chairs.toml --open\n"
        "prints the address of the page. Ctrl-C ends it. tools/view/PROTOCOL.md describes the protocol for\n"
        "other programs.");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
