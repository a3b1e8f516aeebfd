#pragma once
/// Models that assimp reads.

#include "fields/file/reader_process.h"
#include "fields/model/model_content.h"
#include "fields/model/model_format.h"

#include <filesystem>

namespace haarfield {

/// Reads a model's bytes with the importer of its format, in this process. Files that it refers to (MTL,
/// buffers of glTF) are opened only in its directory or below: no URLs, no parent directories.
///
/// file    the absolute path of the file with these bytes.
/// errors  (with an empty `where`) those of assimp.
Result<ModelContent> assimp_content(std::string_view bytes, const std::filesystem::path& file,
                                    ModelFormat format);

/// Like assimp_content, but in a reader process if there is one.
///
/// errors  (with an empty `where`) as above; the reader crashed or exceeded its limits.
Result<ModelContent> guarded_content(std::string_view bytes, const std::filesystem::path& file,
                                     ModelFormat format);

/// Returns the task for fork_reader_process that reads models.
ReaderTask model_reader_task();

}  // namespace haarfield
