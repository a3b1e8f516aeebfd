#pragma once
/// TOML tables whose values are checked as they are read. The only header that includes toml++.

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

// toml++ 3.3 asserts that no value begins with a comma, although it also reports that as an error of the
// file. Under NDEBUG the assertion becomes an assumption, so it is disabled there, too.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expression) static_assert(true)
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
#define TOML_MAX_NESTED_VALUES 16
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

namespace haarfield {

/// A file that is being read, and the first error found in it.
struct TomlFile {
    std::string name;
    std::optional<Error> error;
    /// Names that refer to data supplied by a program, not to files; null: none.
    const std::set<std::string>* given = nullptr;

    /// Records an error. Keeps only the first: later errors are often its consequences.
    void refuse(const toml::source_region& where, std::string what);
};

/// Parses a file.
///
/// errors  those of InputFile::open; more than 16 MiB; invalid TOML (with line and column); multi-line
///         strings, and keys of more than 100 parts, although TOML allows them.
Result<toml::table> read_toml(const std::filesystem::path& file);

/// A table that is read key by key. An absent key leaves the value unchanged. An invalid value is an error
/// with line and column. finish() reports unknown keys and missing required keys.
class TomlTable {
public:
    /// name  the table's name in messages, such as `materials.lacquer`.
    TomlTable(const toml::table& table, std::string name, TomlFile& file)
        : table_(&table), name_(std::move(name)), file_(&file) {}

    void require(std::string_view key) { required_.emplace_back(key); }  ///< The table must have this key.
    /// Tests whether the table has this key.
    bool has(std::string_view key) const { return table_->contains(key); }

    void take(std::string_view key, float& value, const Range& range);  ///< Accepts integers, too.
    /// A number, or `word`, which resets the value.
    void take(std::string_view key, std::optional<float>& value, const Range& range, std::string_view word);
    void take(std::string_view key, Vec3f& value, const Range& range);          ///< Three numbers.
    void take(std::string_view key, Rgb& value, const Range& range);            ///< Three numbers.
    void take(std::string_view key, std::uint32_t& value, const Range& range);  ///< A whole number.
    /// Three numbers of these magnitudes and any sign, or one number for all three.
    void take_factors(std::string_view key, Vec3d& value, const Range& magnitudes);
    /// Three rows of four numbers; an optional fourth row must be 0 0 0 1.
    void take_matrix(std::string_view key, std::array<std::array<double, 4>, 3>& value, const Range& range);
    /// Two whole numbers.
    void take(std::string_view key, std::array<std::uint32_t, 2>& value, const Range& range);
    void take(std::string_view key, std::string& value);  ///< Any string.
    void take(std::string_view key, bool& value);         ///< true or false.
    /// An existing file, relative to `folder`; or a name in TomlFile::given, unchanged.
    void take(std::string_view key, std::filesystem::path& value, const std::filesystem::path& folder);

    /// Returns null if absent or not a table.
    const toml::table* take_table(std::string_view key);
    const toml::array* take_array(std::string_view key);  ///< Returns null if absent or not an array.

    void finish();  ///< Reports unknown keys and missing required keys.

    /// Records an error at the value of a key, or at the table if it has no such key.
    void refuse(std::string_view key, std::string what);

    const toml::table& table() const { return *table_; }  ///< The parsed table.
    TomlFile& file() { return *file_; }                   ///< The file that contains the table.
    const std::string& name() const { return name_; }     ///< The table's name in messages.

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
