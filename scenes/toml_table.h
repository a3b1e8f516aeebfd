#pragma once
/// TOML tables whose values are checked as they are taken. The one place that knows toml++.

#include "fields/base/range.h"
#include "fields/base/result.h"
#include "fields/base/vector.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

// toml++ 3.3 asserts that no value begins with a comma, which a file may well do; it then says so itself.
// Under NDEBUG the same assertion becomes an assumption, so that it is switched off there too.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expression) static_assert(true)
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
#define TOML_MAX_NESTED_VALUES 16
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

namespace haarfield {

/// A file that is being read, and the first thing that was wrong with it.
struct TomlFile {
    std::string name;
    std::optional<Error> error;
    /// Names that stand for no file, but for what a program gives in its place; null: none.
    const std::set<std::string>* given = nullptr;

    /// Keeps the first error only: later ones are often its consequences.
    void refuse(const toml::source_region& where, std::string what);
};

/// Parses a file.
///
/// errors  those of InputFile::open; larger than 16 MiB; not TOML (with line and column); of TOML, texts of
///         several lines and keys of more than 100 parts.
Result<toml::table> read_toml(const std::filesystem::path& file);

/// One table, taken key by key. An absent key leaves the value as it was; a wrong one is refused, with
/// line and column. finish() refuses keys that were not taken, and the lack of required ones.
class TomlTable {
public:
    /// name  what the table is called in messages, such as `materials.lacquer`.
    TomlTable(const toml::table& table, std::string name, TomlFile& file)
        : table_(&table), name_(std::move(name)), file_(&file) {}

    void require(std::string_view key) { required_.emplace_back(key); }  ///< The table must have this key.
    /// Whether the table has this key.
    bool has(std::string_view key) const { return table_->contains(key); }

    void take(std::string_view key, float& value, const Range& range);  ///< Integers will do.
    /// A number, or a word that leaves none.
    void take(std::string_view key, std::optional<float>& value, const Range& range, std::string_view word);
    void take(std::string_view key, Vec3f& value, const Range& range);          ///< Three numbers.
    void take(std::string_view key, Rgb& value, const Range& range);            ///< Three numbers.
    void take(std::string_view key, std::uint32_t& value, const Range& range);  ///< A whole number.
    /// Three numbers of these magnitudes and any signs, or one that stands for all three.
    void take_factors(std::string_view key, Vec3d& value, const Range& magnitudes);
    /// Three rows of four numbers; a fourth, if there is one, must be 0 0 0 1.
    void take_matrix(std::string_view key, std::array<std::array<double, 4>, 3>& value, const Range& range);
    /// Two whole numbers.
    void take(std::string_view key, std::array<std::uint32_t, 2>& value, const Range& range);
    void take(std::string_view key, std::string& value);  ///< Any text.
    void take(std::string_view key, bool& value);         ///< true or false.
    /// A file that is there; relative to `folder`. Or a name in TomlFile::given, as it is.
    void take(std::string_view key, std::filesystem::path& value, const std::filesystem::path& folder);

    /// Null if absent or not a table.
    const toml::table* take_table(std::string_view key);
    const toml::array* take_array(std::string_view key);  ///< Null if absent or not an array.

    void finish();  ///< Refuses what was not taken, and the lack of what was required.

    /// Refuses the value of a key, or the table if it has no such key.
    void refuse(std::string_view key, std::string what);

    const toml::table& table() const { return *table_; }  ///< As it was parsed.
    TomlFile& file() { return *file_; }                   ///< The file that it is in.
    const std::string& name() const { return name_; }     ///< What it is called in messages.

private:
    const toml::node* node(std::string_view key);
    std::string key_name(std::string_view key) const;
    std::optional<double> number(const toml::node& node, const std::string& key, const Range& range);
    template <std::size_t n>
    std::optional<std::array<double, n>> numbers(const toml::node& node, const std::string& key,
                                                 const Range& range, bool whole);

    const toml::table* table_;
    std::string name_;
    TomlFile* file_;
    std::set<std::string, std::less<>> known_;
    std::vector<std::string> required_;
};

}  // namespace haarfield
