#include "fields/model/polygon_file.h"

#include "fields/base/srgb.h"
#include "fields/model/text_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <span>

namespace haarfield {
namespace {

/// Returns the number that a whole word represents. Overflow results in infinity.
std::optional<double> number(std::string_view word) {
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size() || failure == std::errc::invalid_argument) return std::nullopt;
    if (failure == std::errc::result_out_of_range) {
        const bool tiny = word.find("e-") != word.npos || word.find("E-") != word.npos;
        return tiny ? 0 : std::numeric_limits<double>::infinity();
    }
    return value;
}

/// Returns a number as an index or a count below a limit.
std::optional<std::uint32_t> index_below(double value, std::size_t limit) {
    if (!(value >= 0 && value < static_cast<double>(limit)) || value != std::floor(value))
        return std::nullopt;
    return static_cast<std::uint32_t>(value);
}

enum class Scalar { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::optional<Scalar> scalar_named(std::string_view name) {
    constexpr std::array<std::pair<std::string_view, Scalar>, 16> names{{{"char", Scalar::int8},
                                                                         {"int8", Scalar::int8},
                                                                         {"uchar", Scalar::uint8},
                                                                         {"uint8", Scalar::uint8},
                                                                         {"short", Scalar::int16},
                                                                         {"int16", Scalar::int16},
                                                                         {"ushort", Scalar::uint16},
                                                                         {"uint16", Scalar::uint16},
                                                                         {"int", Scalar::int32},
                                                                         {"int32", Scalar::int32},
                                                                         {"uint", Scalar::uint32},
                                                                         {"uint32", Scalar::uint32},
                                                                         {"float", Scalar::float32},
                                                                         {"float32", Scalar::float32},
                                                                         {"double", Scalar::float64},
                                                                         {"float64", Scalar::float64}}};
    for (const auto& [known, scalar] : names)
        if (known == name) return scalar;
    return std::nullopt;
}

/// The numbers after the header of a PLY file, in order.
class PlyNumbers {
public:
    enum class Form { text, little_endian, big_endian };

    PlyNumbers(std::string_view bytes, Form form) : bytes_(bytes), form_(form) {}

    /// Returns the next number; nothing at the end of the file or if it is invalid.
    std::optional<double> next(Scalar scalar) {
        if (form_ == Form::text) return number(next_word(bytes_));
        switch (scalar) {
            case Scalar::int8: return binary<std::int8_t>();
            case Scalar::uint8: return binary<std::uint8_t>();
            case Scalar::int16: return binary<std::int16_t>();
            case Scalar::uint16: return binary<std::uint16_t>();
            case Scalar::int32: return binary<std::int32_t>();
            case Scalar::uint32: return binary<std::uint32_t>();
            case Scalar::float32: return binary<float>();
            case Scalar::float64: return binary<double>();
        }
        return std::nullopt;
    }

private:
    template <class T>
    std::optional<double> binary() {
        std::array<char, sizeof(T)> raw;
        if (bytes_.size() < raw.size()) return std::nullopt;
        std::copy_n(bytes_.begin(), raw.size(), raw.begin());
        bytes_.remove_prefix(raw.size());
        if ((form_ == Form::big_endian) != (std::endian::native == std::endian::big))
            std::reverse(raw.begin(), raw.end());
        return static_cast<double>(std::bit_cast<T>(raw));
    }

    std::string_view bytes_;
    Form form_;
};

struct PlyProperty {
    std::string_view name;
    Scalar scalar;
    std::optional<Scalar> count;  ///< For lists: the type of the count.
};

struct PlyElement {
    std::string_view name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;
};

struct PlyHeader {
    PlyNumbers::Form form = PlyNumbers::Form::text;
    std::vector<PlyElement> elements;
};

/// Reads a line of the header: its keyword and the words after it. False if it is invalid.
bool read_header_line(std::string_view keyword, std::string_view words, std::size_t file_bytes,
                      PlyHeader& header) {
    if (keyword.empty() || keyword == "comment" || keyword == "obj_info") return true;
    const std::string_view first = next_word(words);
    if (keyword == "format") {
        using Form = PlyNumbers::Form;
        if (first == "ascii") header.form = Form::text;
        if (first == "binary_little_endian") header.form = Form::little_endian;
        if (first == "binary_big_endian") header.form = Form::big_endian;
        return first == "ascii" || first.starts_with("binary_");
    }
    if (keyword == "element") {
        const std::optional<double> value = number(next_word(words));
        // Each element is at least a byte or a line long.
        const auto count = value ? index_below(*value, file_bytes) : std::nullopt;
        if (first.empty() || !count) return false;
        header.elements.push_back({first, *count, {}});
        return true;
    }
    if (keyword != "property" || header.elements.empty()) return false;
    PlyProperty property{};
    std::optional<Scalar> scalar = scalar_named(first);
    if (first == "list") {
        property.count = scalar_named(next_word(words));
        if (!property.count) return false;
        scalar = scalar_named(next_word(words));
    }
    property.name = next_word(words);
    if (!scalar || property.name.empty()) return false;
    property.scalar = *scalar;
    header.elements.back().properties.push_back(property);
    return true;
}

/// Reads the header and removes it from `bytes`.
Result<PlyHeader> read_ply_header(std::string_view& bytes) {
    const std::size_t file_bytes = bytes.size();
    if (next_line(bytes) != "ply") return Error{"", "does not begin with \"ply\""};
    PlyHeader header;
    for (int line_number = 2; !bytes.empty(); ++line_number) {
        const std::string_view line = next_line(bytes);
        std::string_view words = line;
        const std::string_view keyword = next_word(words);
        if (keyword == "end_header") return header;
        if (!read_header_line(keyword, words, file_bytes, header))
            return Error{"",
                         fmt::format("line {} of the header is \"{}\"; expected a format, a property, or an "
                                     "element with a count that the file can hold",
                                     line_number, line.substr(0, 80))};
    }
    return Error{"", "ends within its header"};
}

/// The position, normal, colour and image coordinates of a vertex.
using PlyVertex = std::array<double, 11>;

/// Returns the index of a property in PlyVertex; nothing for other properties.
std::optional<std::size_t> vertex_slot(std::string_view name) {
    constexpr std::array<std::string_view, 11> names{"x",   "y",     "z",    "nx", "ny", "nz",
                                                     "red", "green", "blue", "s",  "t"};
    if (name == "u" || name == "texture_u") name = "s";
    if (name == "v" || name == "texture_v") name = "t";
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return std::nullopt;
    return static_cast<std::size_t>(found - names.begin());
}

bool has_property(const PlyElement& element, std::size_t slot) {
    return std::any_of(element.properties.begin(), element.properties.end(),
                       [&](const PlyProperty& p) { return !p.count && vertex_slot(p.name) == slot; });
}

bool is_corner_list(const PlyElement& element, const PlyProperty& property) {
    return element.name == "face" && property.count &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// Reads an element. False if the file ends or a number is invalid. Corners are not checked.
bool read_element(const PlyElement& element, PlyNumbers& numbers, PlyVertex& vertex,
                  std::vector<double>& corners) {
    for (const PlyProperty& property : element.properties) {
        std::size_t count = 1;
        if (property.count) {
            const std::optional<double> listed = numbers.next(*property.count);
            const auto checked = listed ? index_below(*listed, std::size_t(1) << 32) : std::nullopt;
            if (!checked) return false;
            count = *checked;
        }
        const bool keep = is_corner_list(element, property);
        for (std::size_t i = 0; i < count; ++i) {
            const std::optional<double> value = numbers.next(property.scalar);
            if (!value) return false;
            if (keep) corners.push_back(*value);
            if (const auto slot = vertex_slot(property.name); slot && !property.count) vertex[*slot] = *value;
        }
    }
    return true;
}

Vec3f vector_of(std::span<const double, 3> values) {
    return {static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2])};
}

/// Converts a colour to linear. Integers are sRGB, scaled by the largest value of their type.
Rgb colour_of(std::span<const double, 3> values, Scalar scalar) {
    const double largest = scalar == Scalar::float32 || scalar == Scalar::float64 ? 0
                           : scalar == Scalar::uint16 || scalar == Scalar::int16  ? 65535
                                                                                  : 255;
    if (largest == 0) return Rgb(vector_of(values));
    Rgb colour;
    for (std::size_t c = 0; c < 3; ++c)
        colour[int(c)] = srgb_decoded(static_cast<float>(values[c] / largest));
    return colour;
}

/// Returns an error if a corner is not the index of a position.
std::optional<Error> corner_error(const PolygonFile& file, const std::vector<double>& corners) {
    for (const double corner : corners)
        if (!index_below(corner, file.positions.size()))
            return Error{"", fmt::format("face {} has the corner {:g}; there are {} vertices",
                                         file.face_corners.size(), corner, file.positions.size())};
    return std::nullopt;
}

void add_face(PolygonFile& file, const std::vector<double>& corners) {
    for (const double corner : corners) file.corners.push_back(static_cast<std::uint32_t>(corner));
    file.face_corners.push_back(static_cast<std::uint32_t>(corners.size()));
}

}  // namespace

Result<PolygonFile> read_ply(std::string_view bytes) {
    HF_TRY(const PlyHeader header, read_ply_header(bytes));
    PlyNumbers numbers(bytes, header.form);
    PolygonFile file;
    std::vector<double> corners;
    for (const PlyElement& element : header.elements) {
        if (element.properties.empty()) continue;
        const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
        const bool has_normals = has_property(element, 3),
                   has_uvs = has_property(element, 9) && has_property(element, 10);
        const auto colour = std::find_if(element.properties.begin(), element.properties.end(),
                                         [](const PlyProperty& p) { return p.name == "red"; });
        for (std::size_t i = 0; i < element.count; ++i) {
            PlyVertex vertex{};
            corners.clear();
            if (!read_element(element, numbers, vertex, corners))
                return Error{"", fmt::format("{} {} of {} is cut short or has an invalid number",
                                             element.name, i, element.count)};
            if (is_vertex) file.positions.push_back(vector_of(std::span(vertex).first<3>()));
            if (is_vertex && has_normals)
                file.normals.push_back(vector_of(std::span(vertex).subspan<3, 3>()));
            if (is_vertex && colour != element.properties.end())
                file.colours.push_back(colour_of(std::span(vertex).subspan<6, 3>(), colour->scalar));
            if (is_vertex && has_uvs)
                file.uvs.emplace_back(static_cast<float>(vertex[9]), static_cast<float>(vertex[10]));
            if (!is_face) continue;
            if (const auto error = corner_error(file, corners)) return *error;
            add_face(file, corners);
        }
    }
    if (file.normals.size() != file.positions.size()) file.normals.clear();
    if (file.colours.size() != file.positions.size()) file.colours.clear();
    if (file.uvs.size() != file.positions.size()) file.uvs.clear();
    return file;
}

namespace {

/// The non-empty lines of an OFF file, without comments.
class OffLines {
public:
    explicit OffLines(std::string_view text) : text_(text) {}

    /// Returns the next line; empty at the end.
    std::string_view next() {
        while (!text_.empty()) {
            ++line_number_;
            std::string_view line = next_line(text_);
            line = line.substr(0, line.find('#'));
            if (line.find_first_not_of(blanks) != line.npos) return line;
        }
        return {};
    }

    Error error(std::string_view wanted) const {
        return {"", fmt::format("line {}: expected {}", line_number_, wanted)};
    }

private:
    std::string_view text_;
    int line_number_ = 0;
};

/// Removes numbers from the front of a line. False if there are fewer.
bool take_numbers(std::string_view& line, std::span<double> values) {
    for (double& value : values) {
        const std::optional<double> found = number(next_word(line));
        if (!found) return false;
        value = *found;
    }
    return true;
}

}  // namespace

Result<PolygonFile> read_off(std::string_view bytes) {
    OffLines lines(bytes);
    std::string_view line = lines.next();
    std::string_view kind = next_word(line);
    std::string_view rest = line;
    const std::string_view after = next_word(rest);
    if (!kind.ends_with("OFF") || after == "BINARY") return lines.error("OFF, as text");
    if (after.empty()) line = lines.next();
    kind.remove_suffix(3);
    if (kind.starts_with("ST")) kind.remove_prefix(2);
    if (kind.starts_with('C')) kind.remove_prefix(1);
    const bool has_normals = kind.starts_with('N');
    if (has_normals) kind.remove_prefix(1);
    const bool has_weights = kind == "4";
    if (!kind.empty() && !has_weights) return lines.error("OFF with any of ST, C, N and 4 before it");

    std::array<double, 2> counts{};
    if (!take_numbers(line, counts)) return lines.error("the numbers of vertices and faces");
    const auto vertices = index_below(counts[0], bytes.size()), faces = index_below(counts[1], bytes.size());
    if (!vertices || !faces) return lines.error("no more vertices and faces than the file can hold");
    PolygonFile file;
    for (std::uint32_t v = 0; v < *vertices; ++v) {
        line = lines.next();
        std::array<double, 3> position{}, normal{};
        double weight = 1;
        if (!take_numbers(line, position) || (has_weights && !take_numbers(line, {&weight, 1})) ||
            (has_normals && !take_numbers(line, normal)))
            return lines.error("a vertex's coordinates");
        for (double& x : position) x /= weight;
        file.positions.push_back(vector_of(position));
        if (has_normals) file.normals.push_back(vector_of(normal));
    }
    std::vector<double> corners;
    for (std::uint32_t f = 0; f < *faces; ++f) {
        line = lines.next();
        double count = 0;
        const bool counted = take_numbers(line, {&count, 1});
        const auto size = counted ? index_below(count, line.size() + 1) : std::nullopt;
        if (!size) return lines.error("a face's corners");
        corners.resize(*size);
        if (!take_numbers(line, corners)) return lines.error("as many corners as the face has");
        if (const auto error = corner_error(file, corners)) return *error;
        add_face(file, corners);
    }
    return file;
}

}  // namespace haarfield
