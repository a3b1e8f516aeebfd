#pragma once
/// Encodes pictures as a movie with ffmpeg.

#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <filesystem>
#include <string>

namespace haarfield {

/// Tests whether the encoder can be started.
///
/// errors  the encoder is not installed.
Result<Done> check_encoder(const std::string& program = "ffmpeg");

/// Encodes numbered pictures as a movie that any player shows (yuv420p). The file name's extension selects
/// the container.
///
/// pictures           the files, with the number in printf syntax: `frames/frame_%04d.png`, counted from 1.
/// count              the number of pictures. The folder may contain more.
/// frames_per_second  > 0.
/// program            a path, or a name to be looked up in PATH.
/// errors             ffmpeg is not installed; ffmpeg's messages if it fails; interrupted. No incomplete
///                    movie remains.
Result<Done> write_movie(const std::filesystem::path& pictures, int count, const std::filesystem::path& movie,
                         int frames_per_second, const Progress& progress = {},
                         const std::string& program = "ffmpeg");

}  // namespace haarfield
