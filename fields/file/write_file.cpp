#include "fields/file/write_file.h"

#include "fields/file/output_target.h"
#include "fields/file/temporary_file.h"

namespace haarfield {

Result<Done> write_file(const std::filesystem::path& file, std::string_view bytes) {
    HF_TRY(const OutputTarget target, output_target(file));
    if (target.is_stream) return write_stream(target, bytes);
    HF_TRY(TemporaryFile temporary, TemporaryFile::beside(target.file));
    HF_TRY_DONE(temporary.write(bytes));
    return temporary.take_place();
}

Result<Done> make_folder(const std::filesystem::path& folder) {
    std::error_code code, ignored;
    std::filesystem::create_directories(folder, code);
    if (!std::filesystem::is_directory(folder, ignored))
        return Error{folder.string(), "is not a directory and cannot be created: " + code.message()};
    remove_abandoned_files(folder);
    return Done{};
}

}  // namespace haarfield
