#include "bridge/povray_import/scene_queries.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <future>

#include "bridge/povray/povray_log.h"
#include "fields/base/srgb.h"
#include "fields/file/child_process.h"
#include "fields/file/input_file.h"
#include "fields/file/write_file.h"

namespace haarfield {
namespace {

constexpr std::uint64_t most_written_bytes = std::uint64_t{1} << 30;  // Of a file that POV-Ray writes.
constexpr const char *plain_folder = "hf_plain", *emissive_folder = "hf_emissive";
constexpr const char *prelude_file = "hf_prelude.inc", *suffix_file = "hf_suffix.inc";

constexpr const char* common_prelude = R"(
#declare HF_N=0;
#declare HF_A=array[200000]
#macro HF_Light(HF_I) #write(HF_F,"\nlight ",str(HF_I,0,0)," {") #end
#macro HF_Word(HF_W) #write(HF_F," ",HF_W) #end
#macro HF_Number(HF_W) #write(HF_F," ",str(HF_W,0,12)) #end
#macro HF_Count(HF_W) #write(HF_F," ",str(HF_W,0,0)) #end
#macro HF_Vector(HF_W) #write(HF_F," <",vstr(3,HF_W,",",0,12),">") #end
#macro HF_Scale(HF_W) #local HF_X=HF_W+<0,0,0>; HF_Vector(HF_X) #end
#macro HF_Colour(HF_W)
  #write(HF_F," rgb <",str(HF_W.red,0,9),",",str(HF_W.green,0,9),",",str(HF_W.blue,0,9),">")
#end
#macro HF_Place(HF_W) #write(HF_F,"\nplace ",vstr(3,HF_W," ",0,12)) #end
)";

/// Removes the scratch folder with its last owner.
std::shared_ptr<const std::filesystem::path> scratch_folder() {
    std::error_code ignored;
    std::string pattern =
        (std::filesystem::temp_directory_path(ignored) / "haarfield-povray-XXXXXX").string();
    if (!::mkdtemp(pattern.data())) return nullptr;
    return {new std::filesystem::path(pattern), [](const std::filesystem::path* folder) {
                std::error_code failure;
                std::filesystem::remove_all(*folder, failure);
                delete folder;
            }};
}

/// The folders that hold programs, libraries, fonts and POV-Ray's configuration.
const std::vector<std::filesystem::path>& system_folders() {
    static const std::vector<std::filesystem::path> folders{
        "/usr", "/bin", "/lib", "/lib64", "/etc/povray", "/etc/fonts", "/etc/ld.so.cache", "/opt"};
    return folders;
}

/// Returns bubblewrap's arguments up to the program.
std::vector<std::string> bubblewrap_arguments(const std::vector<std::filesystem::path>& readable,
                                              const std::filesystem::path& writable) {
    std::vector<std::string> arguments{"--unshare-all", "--die-with-parent", "--new-session", "--dev",
                                       "/dev",          "--tmpfs",           "/tmp"};
    std::error_code ignored;
    for (const std::filesystem::path& folder : system_folders()) {
        if (std::filesystem::is_symlink(folder, ignored)) {
            const std::string target = std::filesystem::read_symlink(folder, ignored).string();
            arguments.insert(arguments.end(), {"--symlink", target, folder.string()});
        } else {
            arguments.insert(arguments.end(), {"--ro-bind-try", folder.string(), folder.string()});
        }
    }
    for (const std::filesystem::path& folder : readable)
        arguments.insert(arguments.end(), {"--ro-bind-try", folder.string(), folder.string()});
    if (!writable.empty())
        arguments.insert(arguments.end(),
                         {"--bind", writable.string(), writable.string(), "--chdir", writable.string()});
    return arguments;
}

/// Reads a binary PPM of 16 bits.
Result<std::vector<Rgb>> ppm_pixels(const std::string& bytes, int width, int height, bool is_linear) {
    const Error damaged{"POV-Ray", "wrote a damaged picture"};
    std::size_t at = bytes.find("P6");
    if (at != 0) return damaged;
    at = 2;
    std::array<long, 3> numbers{};
    for (long& number : numbers) {
        while (at < bytes.size() && (std::isspace(static_cast<unsigned char>(bytes[at])) || bytes[at] == '#'))
            at = bytes[at] == '#' ? std::min(bytes.find('\n', at), bytes.size()) : at + 1;
        const auto [end, code] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), number);
        if (code != std::errc()) return damaged;
        at = static_cast<std::size_t>(end - bytes.data());
    }
    ++at;
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (numbers[0] != width || numbers[1] != height || numbers[2] != 65535 || bytes.size() < at + 6 * count)
        return damaged;
    std::vector<Rgb> pixels(count);
    for (Rgb& pixel : pixels)
        for (int c = 0; c < 3; ++c) {
            const unsigned code =
                static_cast<unsigned char>(bytes[at]) * 256u + static_cast<unsigned char>(bytes[at + 1]);
            at += 2;
            const float value = static_cast<float>(code) / 65535.0f;
            pixel[c] = is_linear ? value : srgb_decoded(value);
        }
    return pixels;
}

/// Returns the number behind the last `HF_OBJECT` of a log.
std::optional<std::size_t> last_object(const std::string& log) {
    constexpr std::string_view word = "HF_OBJECT ";
    const std::size_t at = log.rfind(word);
    std::size_t number = 0;
    if (at == std::string::npos || log.find('\n', at) == std::string::npos) return std::nullopt;
    std::from_chars(log.data() + at + word.size(), log.data() + log.size(), number);
    return number;
}

/// Returns what is included in front of a rewritten scene.
std::string prelude_text(const SceneQuery& query) {
    std::string prelude;
    for (const auto& [name, is_on] : {std::pair("HF_Survey", query.survey),
                                      {"HF_Lights", query.lights},
                                      {"HF_Sky", query.sky},
                                      {"HF_Camera", query.camera},
                                      {"HF_Settings", query.settings},
                                      {"HF_Extras", query.extras}})
        prelude += fmt::format("#declare {}={};\n", name, is_on ? 1 : 0);
    prelude += fmt::format("#declare HF_E={};\n", query.pigments ? pigment_emission : 1);
    prelude += common_prelude;
    if (query.survey) prelude += "#fopen HF_F \"hf_survey.txt\" write\n";
    prelude += fmt::format("#macro HF_Put(HF_I) {} #declare HF_N=HF_N+1; #end\n", query.put);
    if (query.pigments) prelude += "#default{finish{ambient 0 diffuse 0 emission HF_E}}\n";
    prelude += query.prelude;
    return prelude;
}

/// Returns what is included behind a rewritten scene.
std::string suffix_text(const SceneQuery& query) {
    std::string suffix = query.suffix;
    if (query.survey) suffix += "\n#write(HF_F,\"\\nend\\n\")\n#fclose HF_F\n";
    return suffix;
}

/// Runs POV-Ray in its sandbox.
///
/// file            the scene, for messages.
/// readable        folders that POV-Ray can read besides its installation.
/// object_seconds  as SceneQuery::object_seconds.
Result<SceneAnswer> sandboxed_run(const std::filesystem::path& file,
                                  std::vector<std::filesystem::path> readable,
                                  const std::filesystem::path& scratch, std::vector<std::string> arguments,
                                  const QueryOptions& options, double object_seconds,
                                  const Progress& progress) {
    if (options.threads > 0) arguments.push_back(fmt::format("+WT{}", options.threads));
    for (const std::filesystem::path& library : options.wrap.library) readable.push_back(library);
    if (options.program.find('/') != std::string::npos)
        readable.push_back(std::filesystem::absolute(options.program).parent_path());
    ChildLimits limits;
    limits.memory = options.memory;
    limits.processor_seconds = 8 * options.seconds;
    limits.readable = system_folders();
    limits.readable.insert(limits.readable.end(), readable.begin(), readable.end());
    limits.writable = {scratch};
    const bool bubblewrap = options.sandboxed && bubblewrap_works();
    Result<ChildSandbox> sandbox = ChildSandbox::create(limits, options.sandboxed && !bubblewrap);
    if (!sandbox)
        return Error{file.string(), "POV-Ray cannot be sandboxed: " + sandbox.error().what +
                                        "; install bubblewrap, or use the option --unsandboxed if you trust "
                                        "the scene"};
    std::string program = options.program;
    if (bubblewrap) {
        std::vector<std::string> wrapped = bubblewrap_arguments(readable, scratch);
        wrapped.push_back(program);
        wrapped.insert(wrapped.end(), arguments.begin(), arguments.end());
        arguments = std::move(wrapped);
        program = "bwrap";
    }
    ChildProcess child;
    if (const int failure = child.start(program, arguments, scratch, &*sandbox); failure != 0)
        return Error{options.program, "cannot be run: " + std::generic_category().message(failure) +
                                          "; expected POV-Ray 3.7 (Debian package povray)"};
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    const auto seconds_since = [](Clock::time_point time) {
        return std::chrono::duration<double>(Clock::now() - time).count();
    };
    const auto spent = [&] { return child.processor_seconds().value_or(seconds_since(start)); };
    Clock::time_point last_change = start;
    double spent_before = 0;  // By earlier objects.
    std::optional<std::size_t> object;
    std::string log;
    constexpr std::size_t longest_log = std::size_t{1} << 20;
    while (child.read_some(log)) {
        if (progress.stop.stop_requested()) return interruption(file.string());
        if (log.size() > longest_log) log.erase(0, log.size() / 2);
        if (object_seconds > 0) {
            if (const auto now = last_object(log); now != object) {
                object = now;
                last_change = Clock::now();
                spent_before = spent();
            }
            // On a busy machine, processor time is what tells how slow an object is.
            if (object && seconds_since(last_change) > object_seconds &&
                spent() - spent_before > object_seconds)
                return SceneAnswer{{}, object};
        }
        if (seconds_since(start) > options.seconds)
            return Error{file.string(), fmt::format("POV-Ray took longer than {} s and was ended; its last "
                                                    "messages: {}",
                                                    options.seconds, povray_failure(log))};
    }
    const int status = child.wait();
    if (WIFSIGNALED(status))
        return Error{file.string(), fmt::format("POV-Ray was ended by signal {} ({})", WTERMSIG(status),
                                                strsignal(WTERMSIG(status)))};
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        return Error{file.string(),
                     fmt::format("POV-Ray failed (exit code {}): {}",
                                 WIFEXITED(status) ? WEXITSTATUS(status) : -1, povray_failure(log))};
    return SceneAnswer{};
}

}  // namespace

bool bubblewrap_works() {
    static const bool works = [] {
        ChildProcess child;
        std::vector<std::string> arguments = bubblewrap_arguments({}, {});
        arguments.emplace_back("/bin/true");
        if (child.start("bwrap", arguments, "/") != 0) return false;
        std::string log;
        while (child.read_some(log)) {
        }
        const int status = child.wait();
        return WIFEXITED(status) && WEXITSTATUS(status) == 0;
    }();
    return works;
}

double SceneGamma::light(double number) const {
    if (is_legacy) return double(srgb_decoded(static_cast<float>(number)));
    return std::pow(std::max(0.0, number), exponent);
}

double SceneGamma::number(double light) const {
    if (is_legacy) return double(srgb_encoded(static_cast<float>(light)));
    return std::pow(std::max(0.0, light), 1 / exponent);
}

SceneQueries::~SceneQueries() = default;

Result<Done> SceneQueries::measure_gamma(const Progress& progress) {
    constexpr std::string_view word = "assumed_gamma";
    bool is_set = false, is_one = true;
    for (const WrappedScene::File& file : scene_.files)
        for (std::size_t at = file.text.find(word); at != std::string::npos; at = file.text.find(word, at)) {
            at = file.text.find_first_not_of(" \t\n\r", at + word.size());
            is_set = true;
            const std::string_view rest = std::string_view(file.text).substr(std::min(at, file.text.size()));
            double value = 0;
            std::from_chars(rest.data(), rest.data() + rest.size(), value);
            is_one = is_one && value == 1;
        }
    const std::string& main = scene_.files.front().text;
    double version = 0;
    if (const std::size_t at = main.find("#version"); at != std::string::npos) {
        const std::size_t number = std::min(main.find_first_of("0123456789", at), main.size());
        std::from_chars(main.data() + number, main.data() + main.size(), version);
    }
    gamma_ = {};
    if (!is_set && version < 3.7) {
        gamma_ = {2.2, true};
        return Done{};
    }
    if (is_one) return Done{};
    SceneQuery query;
    query.width = query.height = 2;
    query.suffix =
        "\n#version 3.7;\ncamera{location 0 look_at z}\n"
        "sphere{0,1 hollow pigment{rgb .5} finish{emission 1 ambient 0 diffuse 0}}\n";
    HF_TRY(const SceneAnswer answer, this->answer(query, progress));
    const auto half = double(answer.pixels.front().y);
    constexpr double equal = 0.01;
    const double exponent = half > 0 && half < 1 ? std::log(half) / std::log(0.5) : 1;
    if (std::abs(exponent - 1) > equal) gamma_.exponent = std::round(1000 * exponent) / 1000;
    return Done{};
}

Result<SceneQueries> SceneQueries::create(const std::filesystem::path& scene, const QueryOptions& options) {
    SceneQueries queries;
    queries.file_ = scene;
    queries.options_ = options;
    HF_TRY(queries.scene_, wrapped_scene(scene, options.wrap));
    queries.scratch_ = scratch_folder();
    if (!queries.scratch_)
        return Error{"", "cannot create a temporary folder: " + std::string(strerror(errno))};
    for (const char* folder : {plain_folder, emissive_folder})
        HF_TRY_DONE(make_folder(queries.scratch() / folder));
    for (const WrappedScene::File& file : queries.scene_.files) {
        HF_TRY_DONE(write_file(queries.scratch() / plain_folder / file.name, file.text));
        HF_TRY_DONE(write_file(queries.scratch() / emissive_folder / file.name, file.emissive_text));
        const bool uses_frames = file.text.find("frame_number") != std::string::npos;
        queries.uses_frames_ = queries.uses_frames_ || uses_frames;
    }
    return queries;
}

Result<std::string> SceneQueries::written(const std::string& name) const {
    return read_whole_file(scratch() / name, most_written_bytes);
}

Result<Done> SceneQueries::write_files(const SceneQuery& query, const std::filesystem::path& main) const {
    const std::filesystem::path folder = main.parent_path();
    HF_TRY_DONE(make_folder(folder));
    for (const WrappedScene::File& file : scene_.files) {
        const bool is_main = &file == &scene_.files.front();
        HF_TRY_DONE(write_file(is_main ? main : folder / file.name, file.text));
    }
    HF_TRY_DONE(write_file(folder / prelude_file, prelude_text(query)));
    return write_file(folder / suffix_file, suffix_text(query));
}

std::string SceneQueries::input_of(const SceneQuery& query) const {
    return scratch() / (query.pigments ? emissive_folder : plain_folder) / "hf_scene.pov";
}

Result<SceneAnswer> SceneQueries::answer(const SceneQuery& query, const Progress& progress) const {
    return picture(query, scratch(), input_of(query), progress);
}

Result<std::vector<SceneAnswer>> SceneQueries::answers(std::span<const SceneQuery> queries,
                                                       const Progress& progress) const {
    constexpr std::size_t together = 4;
    std::vector<SceneAnswer> answers;
    for (std::size_t first = 0; first < queries.size(); first += together) {
        std::vector<std::future<Result<SceneAnswer>>> running;
        for (std::size_t k = first; k < std::min(first + together, queries.size()); ++k)
            running.push_back(std::async(std::launch::async, [&, k]() -> Result<SceneAnswer> {
                const std::filesystem::path folder = scratch() / fmt::format("hf_run_{}", k - first);
                HF_TRY_DONE(make_folder(folder));
                return picture(queries[k], folder, input_of(queries[k]), {{}, progress.stop});
            }));
        std::optional<Error> failure;
        for (std::future<Result<SceneAnswer>>& run : running) {
            Result<SceneAnswer> answer = run.get();
            if (answer)
                answers.push_back(*std::move(answer));
            else if (!failure)
                failure = answer.error();
        }
        if (failure) return *failure;
    }
    return answers;
}

Result<SceneAnswer> SceneQueries::original(const SceneQuery& query, const Progress& progress) const {
    const std::filesystem::path file = std::filesystem::absolute(file_).lexically_normal();
    return picture(query, scratch(), file.string(), progress);
}

Result<SceneAnswer> SceneQueries::picture(const SceneQuery& query, const std::filesystem::path& folder,
                                          const std::string& input, const Progress& progress) const {
    HF_TRY(SceneAnswer answer, run(query, folder, input, "+FP16", progress));
    if (answer.slow_object || (query.width == 1 && query.height == 1)) return answer;
    const std::filesystem::path file = folder / (uses_frames_ ? "hf_picture1.ppm" : "hf_picture.ppm");
    HF_TRY(const std::string bytes, read_whole_file(file, most_written_bytes));
    HF_TRY(answer.pixels, ppm_pixels(bytes, query.width, query.height, query.is_linear));
    const bool has_gamma = gamma_.exponent != 1;
    if (!query.pigments && !(query.in_numbers && has_gamma)) return answer;
    const double brightness = query.pigments ? 1 / pigment_emission : 1;
    for (Rgb& pixel : answer.pixels)
        for (int c = 0; c < 3; ++c) {
            const auto light = double(pixel[c]);
            const double number = brightness * (has_gamma ? gamma_.number(light) : light);
            pixel[c] = static_cast<float>(query.in_numbers || !has_gamma ? number : gamma_.light(number));
        }
    return answer;
}

Result<std::filesystem::path> SceneQueries::rendered_exr(const SceneQuery& query,
                                                         const Progress& progress) const {
    HF_TRY_DONE(run(query, scratch(), input_of(query), "+FE", progress));
    return scratch() / (uses_frames_ ? "hf_picture1.exr" : "hf_picture.exr");
}

/// Runs POV-Ray.
///
/// folder  receives what POV-Ray writes; the scratch folder or one in it.
/// input   the scene, as an absolute path.
Result<SceneAnswer> SceneQueries::run(const SceneQuery& query, const std::filesystem::path& folder,
                                      const std::string& input, const std::string& format,
                                      const Progress& progress) const {
    HF_TRY_DONE(write_file(folder / prelude_file, prelude_text(query)));
    HF_TRY_DONE(write_file(folder / suffix_file, suffix_text(query)));

    const std::filesystem::path of_scene = std::filesystem::absolute(file_).parent_path().lexically_normal();
    const std::filesystem::path variant = scratch() / (query.pigments ? emissive_folder : plain_folder);
    std::vector<std::string> arguments{"+I\"" + input + "\"",
                                       "+L\"" + variant.string() + "\"",
                                       "+Ohf_picture",
                                       format,
                                       fmt::format("+W{}", query.width),
                                       fmt::format("+H{}", query.height),
                                       "-D",
                                       "-P",
                                       "-C",
                                       "-A",
                                       "-V",
                                       "-GR",
                                       "-GS",
                                       "-GW",
                                       query.is_linear ? "File_Gamma=1.0" : "File_Gamma=sRGB"};
    if (of_scene.string().find('"') != std::string::npos)
        return Error{file_.string(), "POV-Ray accepts no file names with quotation marks"};
    arguments.push_back("+L\"" + of_scene.string() + "\"");
    for (const std::filesystem::path& library : options_.wrap.library) {
        std::error_code ignored;
        if (std::filesystem::is_directory(library, ignored))
            arguments.push_back("+L\"" + library.string() + "\"");
    }
    // Scenes of an animation need a frame. The first of nine has a number of one digit.
    if (uses_frames_) arguments.insert(arguments.end(), {"+KFF9", "+SF1", "+EF1"});
    arguments.insert(arguments.end(), query.arguments.begin(), query.arguments.end());

    QueryOptions options = options_;
    if (query.seconds > 0) options.seconds = std::min(options.seconds, query.seconds);
    return sandboxed_run(file_, {of_scene, scratch()}, folder, std::move(arguments), options,
                         query.object_seconds, progress);
}

Result<Done> render_sandboxed(const std::filesystem::path& scene,
                              const std::vector<std::filesystem::path>& folders,
                              const std::filesystem::path& png, std::vector<std::string> arguments,
                              const QueryOptions& options, const Progress& progress) {
    const std::shared_ptr<const std::filesystem::path> scratch = scratch_folder();
    if (!scratch) return Error{"", "cannot create a temporary folder: " + std::string(strerror(errno))};
    std::vector<std::filesystem::path> readable;
    std::vector<std::string> all;
    const auto add = [&](const std::string& option, const std::filesystem::path& path) {
        const std::string whole = std::filesystem::absolute(path).lexically_normal().string();
        all.push_back(option + "\"" + whole + "\"");
        return whole.find('"') == std::string::npos;
    };
    bool is_plain = add("+I", scene);
    for (const std::filesystem::path& folder : folders) {
        readable.push_back(std::filesystem::absolute(folder).lexically_normal());
        is_plain = add("+L", folder) && is_plain;
    }
    for (const std::filesystem::path& library : options.wrap.library) {
        std::error_code ignored;
        if (std::filesystem::is_directory(library, ignored)) is_plain = add("+L", library) && is_plain;
    }
    if (!is_plain) return Error{scene.string(), "POV-Ray accepts no file names with quotation marks"};
    for (const char* argument : {"+Opicture.png", "+FN", "-D", "-P", "-C", "-V", "-GR", "-GS", "-GW"})
        all.emplace_back(argument);
    all.insert(all.end(), arguments.begin(), arguments.end());
    HF_TRY_DONE(sandboxed_run(scene, std::move(readable), *scratch, std::move(all), options, 0, progress));
    HF_TRY(const std::string bytes, read_whole_file(*scratch / "picture.png", std::uint64_t{1} << 31));
    return write_file(png, bytes);
}

}  // namespace haarfield
