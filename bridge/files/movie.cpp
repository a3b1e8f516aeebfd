#include "bridge/files/movie.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstring>

#include "fields/file/child_process.h"
#include "fields/file/output_target.h"

namespace haarfield {

Result<Done> check_encoder(const std::string& program) {
    std::error_code ignored;
    ChildProcess child;
    const int failure = child.start(program, {"-version"}, std::filesystem::current_path(ignored));
    if (failure == ENOENT)
        return Error{"--movie",
                     fmt::format("{} is not installed; install it, or leave out --movie", program)};
    if (failure != 0) return Error{program, std::strerror(failure)};
    std::string log;
    while (child.read_some(log)) log.clear();
    child.wait();
    return Done{};
}

Result<Done> write_movie(const std::filesystem::path& pictures, int count, const std::filesystem::path& movie,
                         int frames_per_second, const Progress& progress, const std::string& program) {
    std::error_code ignored;
    HF_TRY(const OutputTarget target, output_target(movie));
    // ffmpeg selects the container by the extension. A stream receives the finished file, because containers
    // need to seek.
    const std::filesystem::path temporary =
        (target.is_stream ? pictures.parent_path() : target.file.parent_path()) /
        fmt::format(".{}", movie.filename().string());
    const std::vector<std::string> arguments{"-nostdin", "-y", "-loglevel", "error", "-start_number", "1",
                                             "-framerate", std::to_string(frames_per_second), "-i",
                                             std::filesystem::absolute(pictures).string(), "-frames:v",
                                             std::to_string(count),
                                             // yuv420p requires even sizes.
                                             "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p",
                                             std::filesystem::absolute(temporary).string()};
    ChildProcess child;
    const int failure = child.start(program, arguments, std::filesystem::current_path(ignored));
    if (failure == ENOENT)
        return Error{movie.string(), fmt::format("{} is not installed; install it, or leave out --movie. The "
                                                 "frames are in {}",
                                                 program, pictures.parent_path().string())};
    if (failure != 0) return Error{program, std::strerror(failure)};
    std::string log;
    bool is_interrupted = false;
    while (!is_interrupted && child.read_some(log)) is_interrupted = progress.stop.stop_requested();
    if (is_interrupted) {
        std::filesystem::remove(temporary, ignored);
        return interruption();
    }
    const int status = child.wait();
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        std::filesystem::remove(temporary, ignored);
        while (!log.empty() && log.back() == '\n') log.pop_back();
        return Error{movie.string(), fmt::format("{} failed: {}", program, log)};
    }
    return move_output(temporary, target);
}

}  // namespace haarfield
