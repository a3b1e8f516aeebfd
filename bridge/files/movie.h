#pragma once
/// Pictures to a movie, by ffmpeg.

#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <filesystem>
#include <string>

namespace haarfield {

/// Tests whether the encoder can be started.
///
/// errors  it is not installed.
Result<Done> check_encoder(const std::string& program = "ffmpeg");

/// Encodes numbered pictures as a movie that any player shows (its ending decides the container; yuv420p).
///
/// pictures           the files, with the number as printf has it: `frames/frame_%04d.png`, from 1 on.
/// count              of them; more may lie there.
/// frames_per_second  > 0.
/// program            a path, or a name to be looked up in PATH.
/// errors             ffmpeg is not installed; its own words if it fails; interrupted. No half movie stays.
Result<Done> write_movie(const std::filesystem::path& pictures, int count, const std::filesystem::path& movie,
                         int frames_per_second, const Progress& progress = {},
                         const std::string& program = "ffmpeg");

}  // namespace haarfield
