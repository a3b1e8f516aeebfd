#include "fields/model/mesh2_file.h"

#include "fields/model/mesh2_object.h"
#include "fields/model/povray_light.h"
#include "fields/model/povray_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace haarfield {
namespace {

constexpr std::size_t most_places = 100000, deepest = 1000;

/// A block between braces.
struct Frame {
    std::string_view kind;             ///< The word before the brace.
    std::string_view name;             ///< Its name if it is declared, else "".
    std::size_t place = 0;             ///< Place of the opening brace.
    std::vector<PlacedMesh2> parts{};  ///< In the frame's coordinates.
    AffineMap transform{};
    std::string material{};
    /// Why its shape or its placement cannot be determined.
    std::optional<PovrayText::Failure> unreadable{};
};

/// An `#if` or similar directive.
struct Condition {
    bool is_known;  ///< True if its branches are known.
    std::size_t place;
    std::string_view word;  ///< "if", "macro" ...
};

bool opens_block(std::string_view directive) {
    constexpr std::array<std::string_view, 7> words{"if",  "ifdef",  "ifndef", "while",
                                                    "for", "switch", "macro"};
    return std::find(words.begin(), words.end(), directive) != words.end();
}

/// True for blocks that contain no objects, or only invisible ones.
bool holds_no_objects(std::string_view word) {
    constexpr std::array<std::string_view, 13> words{
        "pigment", "finish", "normal",     "interior",   "camera",   "light_source",    "global_settings",
        "media",   "fog",    "sky_sphere", "background", "function", "interior_texture"};
    return std::find(words.begin(), words.end(), word) != words.end();
}

class FileParser {
public:
    explicit FileParser(std::string_view text) : bytes_(text), text_(text) {}

    Result<Mesh2File> file() {
        frames_.push_back({});
        while (!text_.failed() && !text_.at_end()) take_one();
        if (!text_.failed())
            for (const Frame& frame : frames_)
                if (!frame.parts.empty() && &frame != &frames_.front())
                    text_.fail_at(frame.place,
                                  fmt::format("the {} that contains a mesh2 does not end", frame.kind));
        if (text_.failed()) return text_.error();
        if (file_.meshes.empty())
            return Error{"",
                         included_.empty()
                             ? std::string("has no mesh2")
                             : fmt::format("has no mesh2; other files are not read: see \"{}\"", included_)};
        place_the_rest();
        if (file_.placed.size() > most_places) return too_many();
        return std::move(file_);
    }

private:
    static Error too_many() { return {"", fmt::format("more than {} meshes placed", most_places)}; }

    void take_one() {
        if (text_.next() == '#') return take_directive();
        const std::string_view name = std::exchange(pending_, {});
        const std::size_t place = text_.place();
        if (text_.next() == '{') return open("block", name);
        if (text_.next() == '}') return close();
        const std::string_view word = text_.word();
        if (word.empty()) return text_.skip_one();
        if (word == "mesh2" && text_.next() == '{') return take_mesh(place, name);
        if (word == "light_source" && text_.next() == '{') return take_light(name);
        if ((word == "texture" || word == "material") && text_.next() == '{') {
            const std::string material = plain_name(text_);
            if (frames_.size() > 1) frames_.back().material = material;
        } else if (holds_no_objects(word) && text_.next() == '{') {
            text_.skip_braces();
        } else if (text_.next() == '{' && !(word == "transform" && frames_.size() > 1)) {
            open(word, name);
        } else if (frames_.size() > 1) {
            take_transformation_of_frame(word);
        }
    }

    /// A transformation that cannot be read is an error only if the object contains a mesh.
    void take_transformation_of_frame(std::string_view word) {
        Frame& frame = frames_.back();
        PovrayText after = text_;
        if (!take_transformation(word, after, frame.transform)) return;
        if (!after.failed())
            text_ = after;
        else if (!frame.unreadable)
            frame.unreadable = after.failure();
    }

    /// Lights that cannot be read are only counted.
    void take_light(std::string_view name) {
        const std::optional<ModelLight> light = povray_light(text_);
        text_.skip_braces();
        const bool may_be_there =
            name.empty() && frames_.size() == 1 && std::ranges::all_of(conditions_, &Condition::is_known);
        if (light && may_be_there)
            file_.lights.push_back(*light);
        else
            ++file_.unread_lights;
    }

    void take_mesh(std::size_t place, std::string_view name) {
        refuse_conditions(place);
        Mesh2 mesh = mesh2_object(text_);
        if (text_.failed() || mesh.faces.empty()) return;
        mesh.name = name;
        mesh.line = line_at(place);
        const PlacedMesh2 part{file_.meshes.size(), {}, ""};
        file_.meshes.push_back(std::move(mesh));
        if (name.empty()) {
            add(frames_.back(), part);
        } else {
            declare(name, {part});
        }
    }

    /// Returns the line of a place. Places must not decrease between calls.
    std::size_t line_at(std::size_t place) {
        for (; counted_ < place; ++counted_) line_ += bytes_[counted_] == '\n';
        return line_;
    }

    /// Fails if a mesh depends on a condition or a loop.
    void refuse_conditions(std::size_t place) {
        for (const Condition& condition : conditions_)
            if (!condition.is_known)
                text_.fail_at(
                    place,
                    fmt::format("a mesh is inside the #{} of line {}, which is not evaluated; expected "
                                "plain data",
                                condition.word, text_.line_at(condition.place)));
    }

    void add(Frame& frame, const PlacedMesh2& part) {
        if (++places_ > 4 * most_places) return text_.fail_at(frame.place, too_many().what);
        frame.parts.push_back(part);
    }

    void open(std::string_view kind, std::string_view name) {
        const std::size_t place = text_.place();
        text_.expect('{');
        if (frames_.size() > deepest) return text_.fail_at(place, "braces are nested too deeply");
        frames_.push_back({kind, name, place});
        if (kind != "object") return;
        PovrayText after = text_;
        const auto found = declared_.find(after.word());
        if (found == declared_.end() || after.next() == '{') return;
        refuse_conditions(place);
        if (text_.failed()) return;
        text_ = after;
        for (const PlacedMesh2& part : found->second) add(frames_.back(), part);
        used_.insert(found->first);
    }

    void close() {
        text_.expect('}');
        if (frames_.size() == 1) return;  // closes a block that several branches of a condition opened
        Frame frame = std::move(frames_.back());
        frames_.pop_back();
        if (frame.kind == "clipped_by")
            frames_.back().unreadable = {frame.place, "clipped_by would cut a mesh; expected an uncut mesh"};
        if (!frame.parts.empty()) {
            if (frame.unreadable) return text_.fail_at(frame.unreadable->place, frame.unreadable->what);
            if (frame.kind == "difference" || frame.kind == "intersection")
                return text_.fail_at(
                    frame.place, fmt::format("a mesh is cut by a {}; expected an uncut mesh", frame.kind));
        }
        for (PlacedMesh2& part : frame.parts) {
            part.transform = frame.transform * part.transform;
            if (part.material.empty()) part.material = frame.material;
            if (frame.name.empty()) add(frames_.back(), part);
        }
        if (frame.name.empty() || frame.parts.empty()) return;
        declare(frame.name, std::move(frame.parts));
    }

    void declare(std::string_view name, std::vector<PlacedMesh2> parts) {
        const auto [entry, is_new] = declared_.insert_or_assign(name, std::move(parts));
        if (is_new) order_.push_back(entry->first);
    }

    void take_directive() {
        const std::size_t place = text_.place();
        text_.expect('#');
        const std::string_view word = text_.word();
        if (word == "declare" || word == "local") {
            const std::string_view name = text_.word();
            names_.insert(name);
            pending_ = text_.take('=') ? name : std::string_view();
        } else if (word == "include") {
            const std::string_view name = text_.string();
            if (included_.empty()) included_ = name;
        } else if (word == "undef") {
            names_.erase(text_.word());
        } else if (word == "ifdef" || word == "ifndef") {
            text_.take('(');
            const std::string_view name = text_.word();
            const bool is_plain = text_.take(')');
            begin_condition({is_plain, place, word});
            if (is_plain && names_.contains(name) != (word == "ifdef")) skip_branch();
        } else if (opens_block(word)) {
            begin_condition({false, place, word});
        } else if (word == "else" || word == "elseif") {
            if (!conditions_.empty() && conditions_.back().is_known) skip_branch();
        } else if (word == "end") {
            if (!conditions_.empty()) conditions_.pop_back();
        }
    }

    void begin_condition(const Condition& condition) {
        if (conditions_.size() > deepest)
            return text_.fail_at(condition.place, "conditions are nested too deeply");
        conditions_.push_back(condition);
    }

    /// Skips from within a condition to after its next `#else`, or to its `#end`.
    void skip_branch() {
        std::size_t depth = 0;
        while (!text_.at_end()) {
            if (text_.next() != '#') {
                text_.skip_one();
                continue;
            }
            const PovrayText before = text_;
            text_.expect('#');
            const std::string_view word = text_.word();
            if (opens_block(word)) ++depth;
            if (depth == 0 && word == "else") return;
            if (word == "end" && depth-- == 0) {
                text_ = before;
                return;
            }
        }
    }

    /// Places the remaining meshes as they are declared, preferably in objects that no other object uses.
    void place_the_rest() {
        file_.placed = std::move(frames_.front().parts);
        std::vector<bool> stands(file_.meshes.size(), false);
        for (const PlacedMesh2& part : file_.placed) stands[part.mesh] = true;
        for (const bool only_unused : {true, false})
            for (const std::string_view name : order_) {
                const std::vector<PlacedMesh2>& parts = declared_[name];
                if (only_unused && used_.contains(name)) continue;
                if (std::all_of(parts.begin(), parts.end(),
                                [&](const PlacedMesh2& p) { return stands[p.mesh]; }))
                    continue;
                for (const PlacedMesh2& part : parts) {
                    stands[part.mesh] = true;
                    file_.placed.push_back(part);
                }
            }
        for (std::size_t i = 0; i < stands.size(); ++i)  // their names were declared again
            if (!stands[i]) file_.placed.push_back({i, {}, ""});
    }

    std::string_view bytes_;
    PovrayText text_;
    Mesh2File file_;
    std::vector<Frame> frames_;  ///< The outermost frame is the file.
    std::vector<Condition> conditions_;
    std::map<std::string_view, std::vector<PlacedMesh2>> declared_;
    std::vector<std::string_view> order_;  ///< In the order of first declarations.
    std::set<std::string_view> names_, used_;
    std::string_view pending_;   ///< The name of the current declaration.
    std::string_view included_;  ///< The first included file.
    std::size_t places_ = 0, counted_ = 0, line_ = 1;
};

}  // namespace

Result<Mesh2File> read_mesh2(std::string_view text) {
    Result<Mesh2File> file = FileParser(text).file();
    if (file) file->left_handed = is_left_handed(text);
    return file;
}

bool is_left_handed(std::string_view text) {
    if (text.substr(0, text.find("\n\n")).find("radiance, right-handed") != text.npos) return false;
    PovrayText words(text);
    bool in_camera = false;
    while (!words.at_end()) {
        if (words.next() == '}') in_camera = false;
        const std::size_t place = words.place();
        const std::string_view word = words.word();
        if (word == "camera") {
            in_camera = true;
        } else if (word == "right" && in_camera) {
            words.take('<');
            if (words.next() == '-') return false;
        } else if (words.place() == place) {
            words.skip_one();
        }
    }
    return true;
}

bool mentions_mesh2(std::string_view text) {
    return text.find("mesh2") != text.npos;
}

}  // namespace haarfield
