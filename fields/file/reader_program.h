#pragma once
/// The programs that serve as reader processes (reader_process.h).
///
/// `haarfield-reader` reads models and OpenVDB files. For the first image, it starts `haarfield-image-reader`
/// in the same folder and passes requests for images on to it, because the libraries for images take longer
/// to load than most models and fields to read.

#include "fields/file/reader_process.h"

#include <filesystem>

namespace haarfield {

/// Serves requests on the socket that the parent process left, until its other end is closed.
///
/// name           the program, for the message to users who start it directly.
/// other_program  a program that serves requests for all other tasks; empty: none.
/// returns        the exit code of a program that was started directly.
int run_reader_program(const char* name, std::span<const ReaderTask> tasks,
                       const std::filesystem::path& other_program = {});

}  // namespace haarfield
