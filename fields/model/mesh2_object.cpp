#include "fields/model/mesh2_object.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {
namespace {

constexpr double degree = pi / 180;

/// Rotates like POV-Ray: on the coordinates, for either handedness.
AffineMap turned(const Vec3d& degrees) {
    AffineMap result;
    for (int axis = 0; axis < 3; ++axis) {
        const double angle = degrees[axis] * degree, c = std::cos(angle), s = std::sin(angle);
        const int from = (axis + 1) % 3, to = (axis + 2) % 3;
        AffineMap turn;
        turn.axes[std::size_t(from)][from] = turn.axes[std::size_t(to)][to] = c;
        turn.axes[std::size_t(from)][to] = s;
        turn.axes[std::size_t(to)][from] = -s;
        result = turn * result;
    }
    return result;
}

AffineMap scaled(const Vec3d& factors) {
    AffineMap result;
    for (int axis = 0; axis < 3; ++axis)  // POV-Ray ignores a factor of 0
        result.axes[std::size_t(axis)][axis] = factors[axis] == 0 ? 1 : factors[axis];
    return result;
}

AffineMap moved(const std::array<double, 12>& matrix) {
    AffineMap result;
    for (std::size_t axis = 0; axis < 3; ++axis)
        result.axes[axis] = Vec3d(matrix[3 * axis], matrix[3 * axis + 1], matrix[3 * axis + 2]);
    result.origin = Vec3d(matrix[9], matrix[10], matrix[11]);
    return result;
}

/// True for words that occur in an object alone, or with `on` or `off`.
bool is_flag(std::string_view word) {
    constexpr std::array<std::string_view, 15> flags{
        "hollow",           "hierarchy",      "inverse",           "sturm",        "uv_mapping",
        "no_image",         "no_reflection",  "no_shadow",         "no_radiosity", "double_illuminate",
        "cutaway_textures", "ignore_photons", "all_intersections", "open",         "smooth"};
    return std::find(flags.begin(), flags.end(), word) != flags.end();
}

bool is_transformation(std::string_view word) {
    return word == "scale" || word == "rotate" || word == "translate" || word == "matrix" ||
           word == "transform";
}

/// Parses the items of a mesh2.
class Mesh2Parser {
public:
    explicit Mesh2Parser(PovrayText& text) : text_(text), begin_(text.place()) {}

    Mesh2 mesh() {
        text_.expect('{');
        while (!text_.failed() && !text_.take('}')) take_item();
        if (!text_.failed()) check();
        if (!text_.failed()) transform();
        return std::move(mesh_);
    }

private:
    void take_item() {
        if (text_.next() == '#') return take_directive();
        const std::size_t place = text_.place();
        const std::string_view word = text_.word();
        if (word == "vertex_vectors")
            take_list(place, word, mesh_.positions, [&] { return Vec3f(text_.vector()); });
        else if (word == "normal_vectors")
            take_list(place, word, mesh_.normals, [&] { return Vec3f(text_.vector()); });
        else if (word == "uv_vectors")
            take_list(place, word, mesh_.uvs, [&] { return text_.uv(); });
        else if (word == "texture_list")
            take_list(place, word, mesh_.textures, [&] { return texture(); });
        else if (word == "face_indices")
            take_list(place, word, mesh_.faces, [&] { return face(); });
        else if (word == "normal_indices")
            take_list(place, word, normal_indices_, [&] { return text_.indices(); });
        else if (word == "uv_indices")
            take_list(place, word, uv_indices_, [&] { return text_.indices(); });
        else
            take_modifier(place, word);
    }

    void take_modifier(std::size_t place, std::string_view word) {
        if (word == "inside_vector") {
            text_.vector();
        } else if (word == "clipped_by") {
            text_.fail_at(place, "clipped_by would cut the mesh; expected an uncut mesh");
        } else if (take_transformation(word, text_, transform_)) {
            return;
        } else if (!word.empty() && text_.next() == '{') {
            const std::string name = plain_name(text_);
            if (word == "texture" || word == "material") mesh_.material = name;
        } else if (is_flag(word)) {
            take_switch();
        } else if (word.empty()) {
            text_.fail("an item of a mesh2 or \"}\"");
        } else {
            text_.fail_at(place,
                          fmt::format("found \"{}\"; expected an item of a mesh2 or \"}}\": calls of macros "
                                      "and identifiers are not read",
                                      word.substr(0, 40)));
        }
    }

    /// Reads `on`, `off` and the like after a flag.
    void take_switch() {
        PovrayText after = text_;
        const std::string_view word = after.word();
        if (word == "on" || word == "off" || word == "yes" || word == "no" || word == "true" ||
            word == "false")
            text_ = after;
        else if (text_.next() >= '0' && text_.next() <= '9')
            text_.number();
    }

    /// Reads `#declare NAME = texture { ... }`, which Blender's exporter writes here.
    void take_directive() {
        const std::size_t place = text_.place();
        text_.expect('#');
        const std::string_view directive = text_.word();
        if (directive == "declare" || directive == "local") {
            const bool has_name = !text_.word().empty();
            const bool is_block = has_name && text_.take('=') && !text_.word().empty() && text_.next() == '{';
            if (is_block) {
                text_.skip_braces();
                text_.take(';');
                return;
            }
        }
        text_.fail_at(place,
                      fmt::format("found \"#{}\" inside a mesh2; expected plain data: no conditions, loops, "
                                  "macros, other files or values",
                                  directive.substr(0, 40)));
    }

    std::string texture() {
        const std::size_t place = text_.place();
        if (text_.word() != "texture") {
            text_.fail_at(place, "expected \"texture { ... }\" in a texture_list");
            return {};
        }
        return plain_name(text_);
    }

    Mesh2Face face() {
        Mesh2Face result;
        const std::size_t place = text_.place();
        result.positions = text_.indices();
        std::size_t count = 0;
        while (count < 3) {
            text_.take(',');
            const char c = text_.next();
            if (c < '0' || c > '9') break;
            result.textures[count++] = text_.count();
        }
        if (count == 1) result.textures[1] = result.textures[2] = result.textures[0];
        if (count == 2) text_.fail_at(place, "a face has two textures; expected none, one or three");
        return result;
    }

    /// Reads `{ N, item, item ... }`.
    template <class T, class TakeItem>
    void take_list(std::size_t place, std::string_view name, std::vector<T>& items, const TakeItem& item) {
        if (!items.empty()) return text_.fail_at(place, fmt::format("there is a second {}", name));
        constexpr std::size_t fewest_bytes = 2;  // "x,"
        text_.expect('{');
        const std::uint32_t count = text_.count();
        if (text_.failed()) return;
        if (count > text_.remaining() / fewest_bytes)
            return text_.fail_at(place, fmt::format("{} of {} items: the text is too short", name, count));
        while (text_.take(',')) {
        }
        // The count is untrusted, so the list grows only as items are read.
        while (!text_.failed() && text_.next() != '}' && items.size() < count) {
            items.push_back(item());
            text_.take(',');
        }
        if (text_.failed()) return;
        if (items.size() < count)
            return text_.fail_at(text_.place(),
                                 fmt::format("{} ends after {} of {} items", name, items.size(), count));
        if (!text_.take('}'))
            text_.fail(fmt::format("\"}}\" after the {} items of {} that begins in line {}", count, name,
                                   text_.line_at(place)));
    }

    void check() {
        if (mesh_.positions.empty() && mesh_.faces.empty())
            return fail("a mesh2 has neither vertex_vectors nor face_indices");
        if (!mesh_.normals.empty() && normal_indices_.empty() &&
            mesh_.normals.size() != mesh_.positions.size())
            return fail(fmt::format("a mesh2 has {} normals for {} vertices and no normal_indices",
                                    mesh_.normals.size(), mesh_.positions.size()));
        if (!mesh_.uvs.empty() && uv_indices_.empty() && mesh_.uvs.size() != mesh_.positions.size())
            return fail(fmt::format("a mesh2 has {} uv_vectors for {} vertices and no uv_indices",
                                    mesh_.uvs.size(), mesh_.positions.size()));
        // The first faces have normals, the others are flat.
        if (normal_indices_.size() > mesh_.faces.size())
            return fail(fmt::format("a mesh2 has {} normal_indices for {} faces", normal_indices_.size(),
                                    mesh_.faces.size()));
        if (!uv_indices_.empty() && uv_indices_.size() != mesh_.faces.size())
            return fail(fmt::format("a mesh2 has {} uv_indices for {} faces", uv_indices_.size(),
                                    mesh_.faces.size()));
        for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
            Mesh2Face& face = mesh_.faces[f];
            if (!normal_indices_.empty() ? f < normal_indices_.size() : !mesh_.normals.empty())
                face.normals = normal_indices_.empty() ? face.positions : normal_indices_[f];
            if (!mesh_.uvs.empty()) face.uvs = uv_indices_.empty() ? face.positions : uv_indices_[f];
            const bool good = check(f, "vertex", face.positions, mesh_.positions.size(), false) &&
                              check(f, "normal", face.normals, mesh_.normals.size(), true) &&
                              check(f, "uv vector", face.uvs, mesh_.uvs.size(), true) &&
                              check(f, "texture", face.textures, mesh_.textures.size(), true);
            if (!good) return;
        }
    }

    bool check(std::size_t face, std::string_view what, const std::array<std::uint32_t, 3>& indices,
               std::size_t count, bool may_be_missing) {
        for (const std::uint32_t index : indices)
            if (index >= count && !(may_be_missing && index == Mesh2Face::none)) {
                fail(fmt::format("face {} of a mesh2 has {} {}; there are {}, counted from 0", face, what,
                                 index, count));
                return false;
            }
        return true;
    }

    void transform() {
        if (transform_ == AffineMap()) return;
        for (Vec3f& p : mesh_.positions) p = Vec3f(transform_.point(Vec3d(p)));
        for (Vec3f& n : mesh_.normals) n = Vec3f(transform_.normal(Vec3d(n)));
        if (!transform_.is_mirrored()) return;
        for (Mesh2Face& face : mesh_.faces)
            for (auto* corners : {&face.positions, &face.normals, &face.uvs, &face.textures})
                std::swap((*corners)[1], (*corners)[2]);
    }

    /// Fails at the beginning of the mesh.
    void fail(const std::string& what) { text_.fail_at(begin_, what); }

    PovrayText& text_;
    std::size_t begin_;
    Mesh2 mesh_;
    AffineMap transform_;
    std::vector<std::array<std::uint32_t, 3>> normal_indices_, uv_indices_;
};

}  // namespace

Mesh2 mesh2_object(PovrayText& text) {
    return Mesh2Parser(text).mesh();
}

bool take_transformation(std::string_view word, PovrayText& text, AffineMap& transform) {
    if (word == "scale")
        transform = scaled(text.vector()) * transform;
    else if (word == "rotate")
        transform = turned(text.vector()) * transform;
    else if (word == "translate")
        transform.origin += text.vector();
    else if (word == "matrix")
        transform = moved(text.matrix()) * transform;
    else if (word == "transform") {
        text.expect('{');
        while (!text.failed() && !text.take('}')) {
            const std::size_t place = text.place();
            const std::string_view inner = text.word();
            if (inner == "transform" || !take_transformation(inner, text, transform))
                text.fail_at(place, "expected scale, rotate, translate or matrix in a transform");
        }
    } else
        return false;
    return true;
}

std::string plain_name(PovrayText& text) {
    PovrayText inside = text;
    text.skip_braces();
    inside.expect('{');
    const std::string name(inside.word());
    PovrayText after = inside;
    const bool is_plain = inside.next() == '}' || is_transformation(after.word());
    return is_plain && name != "uv_mapping" ? name : "";
}

}  // namespace haarfield
