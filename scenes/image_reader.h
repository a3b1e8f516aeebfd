#pragma once
/// The reader of image files, for reader processes. It is the only use of OpenImageIO, which
/// haarfield::scenes does not link.

#include "fields/file/reader_process.h"

namespace haarfield {

/// Returns the task that reads images, for serve_reader_process and fork_reader_process.
ReaderTask image_reader_task();

/// Lets this process read images if it has no reader process and allow_unsandboxed_readers() was called.
void read_images_in_this_process();

}  // namespace haarfield
