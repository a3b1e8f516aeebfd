#include "fields/file/guarded_read.h"

#include "fields/base/exception_message.h"

namespace haarfield {

Result<MappedFile> guarded_read(const ReaderTask& task, int descriptor, std::string_view details,
                                double memory_per_byte, const std::string& where) {
    HF_TRY(const MappedFile file, mapped_file(descriptor, where, MappedPages::as_read));
    const Result<bool> apart = reads_apart();
    if (!apart) return Error{where, apart.error().what};
    if (*apart)
        return read_apart(task.name, descriptor, details, reader_limits(file.bytes.size(), memory_per_byte),
                          where);
    HF_TRY_DONE(load_pages(file, where));
    const auto output = std::make_shared<std::string>();
    ByteSink answer([&](std::string_view bytes) { *output += bytes; });
    try {
        if (const Result<Done> read = task.read(file.bytes, details, answer); !read)
            return Error{where, read.error().what};
    } catch (const std::exception& error) {  // libraries throw for some damaged files
        return Error{where, exception_message(error)};
    }
    return MappedFile{*output, output};
}

}  // namespace haarfield
