#include "bridge/povray/povray_process.h"

#include "bridge/povray/povray_log.h"
#include "bridge/povray/povray_scene.h"
#include "fields/file/child_process.h"
#include "fields/file/input_file.h"
#include "fields/file/output_target.h"
#include "fields/file/write_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

namespace haarfield {
namespace {

constexpr std::size_t longest_log = std::size_t{1} << 20;  // bytes; a scene can print endlessly

constexpr const char* folder_prefix = ".povray-";

/// A temporary folder next to the picture, where POV-Ray leaves its state when it is stopped. A lock
/// distinguishes folders in use from those that a killed process left behind.
class TemporaryFolder {
public:
    explicit TemporaryFolder(const std::filesystem::path& parent) {
        remove_abandoned(parent);
        std::string pattern = (parent / folder_prefix).string() + "XXXXXX";
        if (!::mkdtemp(pattern.data())) return;
        path_ = pattern;
        lock_ = ::open(pattern.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (lock_ >= 0) ::flock(lock_, LOCK_EX | LOCK_NB);
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
        if (lock_ >= 0) ::close(lock_);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

private:
    static void remove_abandoned(const std::filesystem::path& parent) {
        std::error_code code;
        std::vector<std::filesystem::path> abandoned;
        for (std::filesystem::directory_iterator entry(parent, code), end; entry != end && !code;
             entry.increment(code)) {
            const std::filesystem::path& path = entry->path();
            if (!path.filename().string().starts_with(folder_prefix)) continue;
            struct stat status {};
            // Another process creates a folder a moment before it locks it.
            constexpr std::time_t moment = 10;
            if (::stat(path.c_str(), &status) != 0 || std::time(nullptr) - status.st_mtime < moment) continue;
            const int lock = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
            if (lock < 0) continue;
            if (::flock(lock, LOCK_EX | LOCK_NB) == 0) abandoned.push_back(path);
            ::close(lock);
        }
        for (const std::filesystem::path& path : abandoned) std::filesystem::remove_all(path, code);
    }

    std::filesystem::path path_;
    int lock_ = -1;
};

double logged_seconds(const std::string& log, const char* key) {
    std::size_t at = log.rfind(key);
    if (at == std::string::npos || (at = log.find('(', at)) == std::string::npos) return 0;
    double seconds = 0;  // not strtod: a program may have set a locale with decimal commas
    const char* const number = log.data() + std::min(log.find_first_not_of(' ', at + 1), log.size());
    std::from_chars(number, log.data() + log.size(), seconds);
    return seconds;
}

/// Reports progress from the last `Rendered 1024 of 4096 pixels` in the log.
void report_pixels(const std::string& log, const Progress& progress) {
    if (!progress.report) return;
    const std::size_t at = log.rfind("Rendered ");
    unsigned long long done = 0, total = 0;
    if (at != std::string::npos && std::sscanf(log.c_str() + at, "Rendered %llu of %llu", &done, &total) == 2)
        progress.report("POV-Ray", done, total);
}

std::vector<std::string> arguments_of(const std::string& scene, const std::string& output,
                                      const PovrayOptions& options) {
    std::vector<std::string> arguments{"+I\"" + scene + "\"",
                                       "+O\"" + output + "\"",
                                       "+FE",
                                       "+UA",
                                       fmt::format("+W{}", options.width),
                                       fmt::format("+H{}", options.height),
                                       "-D",
                                       "-P",
                                       "-C"};
    if (options.threads > 0) arguments.push_back(fmt::format("+WT{}", options.threads));
    if (options.last_row > 0) {
        arguments.push_back(fmt::format("+SR{}", options.first_row + 1));
        arguments.push_back(fmt::format("+ER{}", options.last_row));
    }
    if (options.antialiasing > 0)
        for (std::string argument :
             {fmt::format("+A{:.4f}", options.antialiasing_threshold), std::string("+AM1"),
              fmt::format("+R{}", options.antialiasing), std::string("-J")})
            arguments.push_back(std::move(argument));
    else
        arguments.push_back("-A");
    for (const std::string& name : options.declarations) arguments.push_back("Declare=" + name + "=1");
    return arguments;
}

std::string as_typed(const std::string& program, const std::vector<std::string>& arguments) {
    std::string line = program;
    for (const std::string& argument : arguments) {
        const bool plain = argument.find_first_of(" \t'\\$&;()<>|*?") == std::string::npos;
        std::string shown = argument;
        if (plain) shown.erase(std::remove(shown.begin(), shown.end(), '"'), shown.end());
        if (!plain)  // within single quotes, a shell changes only single quotes
            for (std::size_t at = 0; (at = shown.find('\'', at)) != std::string::npos; at += 4)
                shown.replace(at, 1, "'\\''");
        line += plain ? " " + shown : " '" + shown + "'";
    }
    return line;
}

}  // namespace

PovrayOptions picture_options(const Camera& camera, int antialiasing) {
    // More rays do not improve pixels that differ less from their neighbours. [sRGB-encoded]
    constexpr double threshold = 0.05;
    PovrayOptions options;
    options.width = camera.width;
    options.height = camera.height;
    options.antialiasing = antialiasing;
    options.antialiasing_threshold = threshold;
    return options;
}

Result<PovrayRun> run_povray(const std::filesystem::path& scene, const std::filesystem::path& exr,
                             const PovrayOptions& options, const Progress& progress) {
    assert(options.width >= 1 && options.height >= 1 && options.threads >= 0 && options.antialiasing >= 0 &&
           options.antialiasing_threshold >= 0 && options.first_row >= 0 &&
           options.last_row <= options.height);
    std::error_code code;
    HF_TRY_DONE(check_input_file(scene));
    const std::filesystem::path whole_scene = std::filesystem::absolute(scene);
    const std::filesystem::path whole_exr = std::filesystem::absolute(exr);
    HF_TRY(const OutputTarget target, output_target(whole_exr));
    const std::filesystem::path folder =
        target.is_stream ? whole_scene.parent_path() : target.file.parent_path();
    HF_TRY_DONE(make_folder(folder));
    const TemporaryFolder temporary(folder);
    if (temporary.path().empty()) return Error{folder.string(), "cannot be written to"};
    const std::filesystem::path picture = temporary.path() / "picture.exr";
    // The path is relative to the scene's folder, in which POV-Ray runs: quotation marks in common parents
    // are then harmless.
    const std::filesystem::path seen = picture.lexically_relative(whole_scene.parent_path());

    const std::string scene_name = whole_scene.filename().string(),
                      output = seen.empty() ? picture.string() : seen.string();
    if (mentions(scene_name, "\"") || mentions(output, "\""))
        return Error{scene.string(), "POV-Ray accepts no file names with quotation marks"};
    if (progress.stop.stop_requested()) return interruption(scene.string());
    PovrayRun run;
    run.command_line =
        as_typed(options.program, arguments_of(scene_name, whole_exr.filename().string(), options));
    ChildProcess child;  // POV-Ray first looks up includes in its working directory, the scene's folder
    const int failure =
        child.start(options.program, arguments_of(scene_name, output, options), whole_scene.parent_path());
    if (failure != 0)
        return Error{options.program, "cannot be run: " + std::generic_category().message(failure) +
                                          "; expected POV-Ray 3.7 (Debian package povray)"};

    std::string log;
    using Clock = std::chrono::steady_clock;
    Clock::time_point last_word = Clock::now();
    while (true) {
        const std::size_t said = log.size();
        if (!child.read_some(log)) break;
        if (progress.stop.stop_requested()) return interruption(scene.string());
        if (log.size() > said) last_word = Clock::now();
        if (Clock::now() - last_word > std::chrono::duration<double>(options.patience))
            return Error{scene.string(), fmt::format("POV-Ray reported nothing for {} s and was ended; its "
                                                     "last messages: {}",
                                                     options.patience, povray_failure(log))};
        report_pixels(log, progress);
        if (log.size() > longest_log) log.erase(0, log.size() / 2);
    }
    const int status = child.wait();
    report_pixels(log, progress);
    if (WIFSIGNALED(status))
        return Error{scene.string(),
                     fmt::format("POV-Ray was ended by signal {} ({}); its last messages: {}",
                                 WTERMSIG(status), strsignal(WTERMSIG(status)), povray_failure(log))};
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        return Error{scene.string(),
                     fmt::format("POV-Ray failed (exit code {}): {}",
                                 WIFEXITED(status) ? WEXITSTATUS(status) : -1, povray_failure(log))};
    if (!std::filesystem::is_regular_file(picture, code))
        return Error{scene.string(), "POV-Ray wrote no picture: " + povray_failure(log)};
    HF_TRY_DONE(move_output(picture, target));

    run.parse_seconds = logged_seconds(log, "Parse Time:");
    run.trace_seconds = logged_seconds(log, "Trace Time:");
    for (std::string& message : povray_messages(log))
        if (mentions(message, "Warning") || mentions(message, "Possible"))
            if (!mentions(message, "Stream to console")) run.warnings.push_back(std::move(message));
    return run;
}

Result<RenderedScene> rendered_scene(const std::filesystem::path& scene, const PovrayOptions& options,
                                     const Progress& progress) {
    const std::filesystem::path folder = std::filesystem::absolute(scene).parent_path();
    const TemporaryFolder temporary(folder);
    if (temporary.path().empty()) return Error{folder.string(), "cannot be written to"};
    const std::filesystem::path exr = temporary.path() / "picture.exr";
    HF_TRY(PovrayRun run, run_povray(scene, exr, options, progress));
    HF_TRY(Image image, read_image(exr));
    return RenderedScene{std::move(image), std::move(run)};
}

Result<Done> write_with_background(const Image& objects, const std::filesystem::path& scene,
                                   const std::filesystem::path& exr, const PovrayOptions& options,
                                   const Progress& progress) {
    PovrayOptions behind = options;
    behind.declarations.emplace_back(background_only);
    HF_TRY(const RenderedScene background, rendered_scene(scene, behind, {{}, progress.stop}));
    HF_TRY_DONE(write_image(objects, exr));
    return write_image(over(objects, background.image), std::filesystem::path(exr).replace_extension(".png"));
}

Result<RenderedScene> render_scene(const std::filesystem::path& scene, const std::filesystem::path& exr,
                                   const PovrayOptions& options, const Progress& progress) {
    PovrayOptions objects = options;
    objects.declarations.emplace_back(without_background);
    Result<RenderedScene> rendered = rendered_scene(scene, objects, progress);
    if (!rendered) return rendered;
    HF_TRY_DONE(write_with_background(rendered->image, scene, exr, options, progress));
    return rendered;
}

}  // namespace haarfield
