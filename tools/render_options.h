#pragma once
/// The options of rendering: one table for the command line, Python, `view` and jobs of plans.

#include "fields/base/range.h"
#include "scenes/scene_bake.h"
#include "scenes/scene_entities.h"
#include "shading/transfer/radiance_transfer.h"

#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// The settings that the options change.
struct RenderChoices {
    RenderChoices() { shading.bounces.most = any_bounces; }

    SceneEntityOptions entities;  ///< An empty fields_folder: `fields` in the output folder.
    RenderSettings shading;       ///< Its face_size is that of the entities.
    BakeOptions bake;             ///< Its error is determined by target_error.
    std::string error;            ///< As given: a number, a percentage or `off`. Empty: not given.
    TransferSettings transfer;
};

/// Returns BakeOptions::error for these choices: the given error. If none is given, 1 %, or none if other
/// options choose the vertices or the evaluator.
std::optional<double> target_error(const RenderChoices& choices);

/// Sets of options; a command has all options of some sets.
enum class OptionSet { fields, vertices, occlusion, lighting, depth, bake, frames };

/// The groups of --help.
inline constexpr const char *shown_group = "Content", *accuracy_group = "Accuracy", *speed_group = "Speed",
                            *files_group = "Files";

/// A row of the table: an option whose value is a number, a word, a list of words, or a flag.
struct RenderOption {
    std::string name;  ///< On the command line, without `--`; in Python with _ for -.
    OptionSet set;
    const char* group;
    std::string type;                  ///< The symbol of the value in --help: N, E.
    std::string summary;               ///< One line.
    std::string details;               ///< For the manual page and Python; may be empty.
    std::vector<std::string> words{};  ///< The valid words.
    std::optional<Range> range{};      ///< The valid numbers.
    bool is_whole = false;             ///< Numbers are whole.
    bool is_share = false;             ///< Numbers may be percentages: `1%` for 0.01.
    bool is_optional = false;          ///< True if the value may be missing; `text` is then empty.
    bool is_list = false;              ///< Words, separated by commas.
    bool is_flag = false;              ///< The value is `true` or `false`.

    /// Returns the value as text.
    std::function<std::string(const RenderChoices&)> text{};
    /// Sets the value from a valid text; see trouble.
    std::function<void(RenderChoices&, const std::string& text)> set_text{};

    /// Returns why a text is invalid: `is 2; expected a number in [0, 1]`. Empty if it is valid.
    std::string trouble(const std::string& value) const;
    /// Returns the valid values for --help: `in [0, 1]` or `{fields,exact,auto}`.
    std::string values() const;
};

/// All rows; within a group the common ones come first.
const std::vector<RenderOption>& render_options();

/// Returns the row of a name. The table must have it (asserted).
const RenderOption& render_option(std::string_view name);

/// Returns the rows of some sets, in the order of the table.
std::vector<const RenderOption*> render_options(std::initializer_list<OptionSet> sets);

/// Returns the options of some sets as arguments of a command line. Leaves out flags that are off, and lists
/// and numbers that are not given.
std::vector<std::string> option_arguments(const RenderChoices& choices,
                                          std::initializer_list<OptionSet> sets);

}  // namespace haarfield
