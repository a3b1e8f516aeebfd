#pragma once
/// Models that assimp reads.

#include "fields/file/reader_process.h"
#include "fields/model/model_content.h"
#include "fields/model/model_format.h"

#include <filesystem>

namespace haarfield {

/// Reads a model's bytes with the one importer of its format, in this process. What the file refers to (MTL,
/// buffers of glTF) is opened only beside it or below: no URL, no way up.
///
/// file    absolute: where the bytes are from.
/// errors  (with an empty `where`) what assimp says.
Result<ModelContent> assimp_content(std::string_view bytes, const std::filesystem::path& file,
                                    ModelFormat format);

/// The same, in a reader process if there is one.
///
/// errors  (with an empty `where`) as above; that the reader crashed, or took more than it may.
Result<ModelContent> guarded_content(std::string_view bytes, const std::filesystem::path& file,
                                     ModelFormat format);

/// For fork_reader_process: reads models.
ReaderTask model_reader_task();

}  // namespace haarfield
