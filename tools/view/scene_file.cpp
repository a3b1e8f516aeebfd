#include "tools/view/scene_file.h"

#include "fields/base/names.h"
#include "fields/file/input_file.h"
#include "fields/file/write_file.h"
#include "scenes/scene_comments.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_writer.h"

#include <fmt/format.h>

namespace haarfield {
namespace {

/// Returns the comments of a file; none if the file does not exist.
Result<SceneComments> comments_of(const std::filesystem::path& file) {
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) return SceneComments{};
    constexpr std::uint64_t largest = std::uint64_t{16} << 20;
    const Result<std::string> text = read_whole_file(file, largest);
    if (!text) return Error{file.string(), text.error().what + "; it is not replaced"};
    return scene_comments(*text);
}

}  // namespace

std::filesystem::path SceneFile::free_file(const std::filesystem::path& like) const {
    std::error_code ignored;
    const std::string stem = like.stem().string();
    for (int number = 1;; ++number) {
        const std::string end = number == 1 ? "" : fmt::format("_{}", number);
        const std::filesystem::path file = like.parent_path() / fmt::format("{}.view{}.toml", stem, end);
        if (!std::filesystem::exists(file, ignored)) return file;
        if (!made_.contains(file)) continue;
        // Comments may have been added to the file since.
        const Result<SceneComments> comments = comments_of(file);
        if (comments && !comments->has_others) return file;
    }
}

std::filesystem::path SceneFile::autosave_file() const {
    return opened_.parent_path() / (opened_.stem().string() + ".autosave.toml");
}

std::optional<Result<Scene>> SceneFile::left_scene() const {
    std::error_code ignored;
    if (opened_.empty() || !std::filesystem::exists(autosave_file(), ignored)) return std::nullopt;
    return read_scene(autosave_file());
}

Result<Done> SceneFile::autosave(const Scene* scene) const {
    const std::filesystem::path file = autosave_file();
    if (scene) return write_file(file, scene_text(*scene, file.parent_path()));
    std::error_code failure;
    std::filesystem::remove(file, failure);
    if (failure) return Error{file.string(), failure.message()};
    return Done{};
}

Result<SavedScene> SceneFile::save(const Scene& scene, std::string_view name) {
    SavedScene saved{opened_, {}};
    if (!name.empty()) {
        const std::string plain = plain_name(name);
        if (plain.front() == '.' || plain.front() == '-')
            return Error{"", "the name of the scene is invalid; expected letters, digits, _, - and ."};
        saved.file = opened_.parent_path() / (plain.ends_with(".toml") ? plain : plain + ".toml");
    }
    std::error_code ignored;
    if (saved.file != opened_ && !made_.contains(saved.file) && std::filesystem::exists(saved.file, ignored))
        return Error{saved.file.string(), "exists already; expected the name of a new file"};
    const Result<SceneComments> opened = comments_of(opened_);
    const Result<SceneComments> there = saved.file == opened_ ? opened : comments_of(saved.file);
    if (!opened || !there) return (opened ? there : opened).error();
    if (there->has_others) {
        saved.instead_of = saved.file;
        saved.file = free_file(saved.file);
    }
    const std::string text = scene_text(scene, saved.file.parent_path(), opened->on_top);
    HF_TRY_DONE(write_file(saved.file, text));
    made_.insert(saved.file);
    return saved;
}

}  // namespace haarfield
