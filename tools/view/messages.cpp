#include "tools/view/messages.h"

#include "fields/base/range.h"
#include "scenes/povray_finish.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <map>
#include <set>

namespace haarfield {
namespace {

using Json = nlohmann::json;

constexpr Range shares{0, 1};

/// Reads the keys of a message. After the first error, all further reads do nothing.
class MessageReader {
public:
    explicit MessageReader(const Json& object, std::string name = "")
        : object_(object), name_(std::move(name)) {}

    bool has(const char* key) const { return object_.contains(key); }

    void take(const char* key, float& value, const Range& range) {
        if (const Json* found = find(key)) value = static_cast<float>(number(*found, key, range));
    }

    void take(const char* key, std::uint32_t& value) {
        const Json* found = find(key);
        if (!found) return;
        if (found->is_number_unsigned() && found->get<std::uint64_t>() <= 0xffffffffu)
            value = found->get<std::uint32_t>();
        else
            refuse(key, "a whole number from 0 to 4294967295");
    }

    void take(const char* key, std::string& value, std::size_t longest = 200) {
        const Json* found = find(key);
        if (!found) return;
        if (found->is_string() && !found->get_ref<const std::string&>().empty() &&
            found->get_ref<const std::string&>().size() <= longest)
            value = found->get<std::string>();
        else
            refuse(key, fmt::format("a text of 1 to {} bytes", longest));
    }

    /// Reads a vector or a colour.
    template <class Vector>
    void take_three(const char* key, Vector& value, const Range& range) {
        std::array<double, 3> numbers{};
        if (take_list(key, numbers, range))
            for (int i = 0; i < 3; ++i) value[i] = static_cast<float>(numbers[std::size_t(i)]);
    }

    void take(const char* key, Rotation& value) {
        std::array<double, 4> q{};
        if (!take_list(key, q, {-1e3, 1e3})) return;
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (!(length > 1e-6)) return refuse(key, "a quaternion x, y, z, w that is not 0");
        const double x = q[0] / length, y = q[1] / length, z = q[2] / length, w = q[3] / length;
        Rotation given;
        given.row = {Vec3d(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
                     Vec3d(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
                     Vec3d(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y))};
        value = as_degrees(given);  // a saved scene then has bit-identical values
    }

    /// Reads an object whose keys are read by `use`.
    template <class Use>
    void take_part(const char* key, const Use& use) {
        const Json* found = find(key);
        if (!found) return;
        if (!found->is_object()) return refuse(key, "an object");
        MessageReader part(*found, name_ + key + ".");
        use(part);
        part.finish();
        if (!error_) error_ = part.error_;
    }

    void require(const char* key) {
        if (!error_ && !has(key)) error_ = Error{"", fmt::format("{}{} is missing", name_, key)};
    }

    void refuse(const char* key, const std::string& wanted) {
        // The message omits values that are long or unusual.
        if (!error_) error_ = Error{"", fmt::format("{}{} is invalid; expected {}", name_, key, wanted)};
    }

    /// Rejects keys that were not read.
    void finish() {
        for (const auto& [key, value] : object_.items())
            if (!error_ && !known_.contains(key))
                error_ = Error{"", fmt::format("unknown key: {}{}", name_, key.substr(0, 40))};
    }

    const std::optional<Error>& error() const { return error_; }

    const Json* find(const char* key) {
        known_.insert(key);
        const auto found = object_.find(key);
        return error_ || found == object_.end() ? nullptr : &*found;
    }

private:
    double number(const Json& value, const char* key, const Range& range) {
        if (value.is_number() && range.contains(value.get<double>())) return value.get<double>();
        refuse(key, "a number in " + range.text());
        return range.lowest;
    }

    template <std::size_t n>
    bool take_list(const char* key, std::array<double, n>& numbers, const Range& range) {
        const Json* found = find(key);
        if (!found) return false;
        if (!found->is_array() || found->size() != n) {
            refuse(key, fmt::format("{} numbers in {}", n, range.text()));
            return false;
        }
        for (std::size_t i = 0; i < n; ++i) numbers[i] = number((*found)[i], key, range);
        return !error_;
    }

    const Json& object_;
    std::string name_;
    std::set<std::string, std::less<>> known_;
    std::optional<Error> error_;
};

Content turned_light(MessageReader& reader) {
    TurnLight edit{};
    reader.require("rotation");
    reader.take("rotation", edit.turn);
    return edit;
}

Content named_lights(MessageReader& reader) {
    NamedLights lights{};
    reader.require("light");
    reader.take("light", lights.first);
    if (reader.has("second")) reader.take("second", lights.second.emplace());
    reader.take("share", lights.share, shares);
    return lights;
}

Content mixed_lights(MessageReader& reader) {
    MixLights edit{};
    reader.require("share");
    reader.take("share", edit.share, shares);
    return edit;
}

Content exposure(MessageReader& reader) {
    SetExposure edit{};
    reader.require("stops");
    const Json* stops = reader.find("stops");
    if (stops && *stops == "auto") return edit;
    reader.take("stops", edit.stops.emplace(), {-60, 60});
    return edit;
}

Content place(MessageReader& reader) {
    PartialPlace place{};
    reader.require("object");
    reader.take("object", place.object);
    if (reader.has("translate")) reader.take_three("translate", place.translate.emplace(), coordinates);
    if (reader.has("rotation")) reader.take("rotation", place.rotate.emplace());
    if (reader.has("scale")) reader.take("scale", place.scale.emplace(1.0f), {1e-4, 1e4});
    if (!place.translate && !place.rotate && !place.scale)
        reader.refuse("translate", "at least one of translate, rotation and scale");
    return place;
}

template <class ObjectEdit>
Content of_object(MessageReader& reader) {
    ObjectEdit edit{};
    reader.require("object");
    reader.take("object", edit.object);
    return edit;
}

Content material(MessageReader& reader) {
    SetMaterial edit{};
    reader.require("name");
    reader.take("name", edit.name);
    if (reader.has("pigment") || reader.has("finish")) {
        edit.material.convention = LobeConvention::povray;
        reader.require("pigment");
        reader.require("finish");
        reader.take_three("pigment", edit.material.pigment, albedos);
        reader.take_part("finish", [&](MessageReader& finish) { take_povray_finish(finish, edit.material); });
        return edit;
    }
    reader.take_three("diffuse", edit.material.diffuse, albedos);
    reader.take_three("specular", edit.material.specular, albedos);
    reader.take("shininess", edit.material.shininess, shininesses);
    reader.take_three("emission", edit.material.emission, emissions);
    std::string convention = "physical";
    reader.take("convention", convention);
    if (convention == "povray")
        edit.material.convention = LobeConvention::povray;
    else if (convention != "physical")
        reader.refuse("convention", "physical or povray");
    return edit;
}

Content sky(MessageReader& reader) {
    SetSky edit{};
    for (const char* key : {"turbidity", "sun_elevation", "sun_azimuth"}) reader.require(key);
    reader.take("turbidity", edit.turbidity, {2, 10});
    reader.take("sun_elevation", edit.sun_elevation, {0, 90});
    reader.take("sun_azimuth", edit.sun_azimuth, {-360, 360});
    edit.sun_elevation = radians(edit.sun_elevation);
    edit.sun_azimuth = radians(edit.sun_azimuth);
    return edit;
}

Content lamp(MessageReader& reader) {
    SetLamp edit{};
    for (const char* key : {"name", "colour"}) reader.require(key);
    reader.take("name", edit.name);
    reader.take_three("colour", edit.colour, {0, 1e9});
    if (reader.has("position")) reader.take_three("position", edit.position.emplace(), coordinates);
    return edit;
}

Content own_part(MessageReader& reader) {
    EditPartMaterial part{};
    for (const char* key : {"object", "part"}) reader.require(key);
    reader.take("object", part.object);
    reader.take("part", part.part);
    return part;
}

Content look(MessageReader& reader) {
    SetView look{};
    for (const char* key : {"position", "target", "vertical_fov", "width", "height"}) reader.require(key);
    reader.take_three("position", look.camera.position, coordinates);
    reader.take_three("target", look.camera.target, coordinates);
    float degrees = 35;
    reader.take("vertical_fov", degrees, {0.01, 179, false, false});
    look.camera.vertical_fov = radians(degrees);
    std::uint32_t width = 640, height = 480;
    reader.take("width", width);
    reader.take("height", height);
    constexpr std::uint32_t most = 16384;
    if (width < 1 || height < 1 || width > most || height > most)
        reader.refuse("width", "width and height in [1, 16384]");
    look.camera.width = static_cast<int>(std::clamp(width, 1u, most));
    look.camera.height = static_cast<int>(std::clamp(height, 1u, most));
    if (!((look.camera.target - look.camera.position).length() > 1e-6f))
        reader.refuse("target", "a place that differs from position");
    return look;
}

Content selection(MessageReader& reader) {
    Select select;
    reader.require("object");
    const Json* object = reader.find("object");
    if (object && !object->is_null()) reader.take("object", select.object.emplace());
    return select;
}

Content shown(MessageReader& reader) {
    FrameDisplayed shown{};
    reader.require("frame");
    reader.take("frame", shown.frame);
    return shown;
}

Content save(MessageReader& reader) {
    Save save;
    if (reader.has("name")) reader.take("name", save.name.emplace(), 100);
    return save;
}

Content task(MessageReader& reader) {
    static const std::map<std::string, TaskKind> kinds{
        {"bake", TaskKind::bake}, {"reference", TaskKind::reference}, {"picture", TaskKind::picture}};
    std::string name;
    reader.require("task");
    reader.take("task", name);
    const auto kind = kinds.find(name);
    if (kind == kinds.end()) reader.refuse("task", "bake, reference or picture");
    return StartTask{kind == kinds.end() ? TaskKind::bake : kind->second};
}

using ContentReader = Content (*)(MessageReader&);

const std::map<std::string, ContentReader, std::less<>> content_readers{
    {"turn_light", &turned_light},
    {"light", &named_lights},
    {"mix", &mixed_lights},
    {"exposure", &exposure},
    {"place", &place},
    {"clone", &of_object<CloneObject>},
    {"delete", &of_object<DeleteObject>},
    {"material", &material},
    {"sky", &sky},
    {"lamp", &lamp},
    {"own_material", &own_part},
    {"look", &look},
    {"select", &selection},
    {"undo", [](MessageReader&) -> Content { return StepBack{}; }},
    {"redo", [](MessageReader&) -> Content { return StepOn{}; }},
    {"shown", &shown},
    {"save", &save},
    {"start", &task},
    {"cancel", [](MessageReader&) -> Content { return CancelTask{}; }},
    {"restore", [](MessageReader&) -> Content { return Restore{}; }},
    {"discard", [](MessageReader&) -> Content { return Discard{}; }},
    {"steer", [](MessageReader&) -> Content { return Steer{}; }},
};

}  // namespace

Result<Message> read_message(std::string_view text) {
    if (text.size() > longest_message)
        return Error{"", fmt::format("found a message of {} bytes; expected at most {}", text.size(),
                                     longest_message)};
    const Json object = Json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!object.is_object()) return Error{"", "found no JSON object; expected a message"};
    MessageReader reader(object);
    Message message;
    reader.require("type");
    reader.take("type", message.type);
    reader.take("number", message.number);
    reader.take("gesture", message.gesture);
    if (reader.error()) return *reader.error();
    const auto known = content_readers.find(message.type);
    if (known == content_readers.end()) return Error{"", "type is unknown; expected a type of PROTOCOL.md"};
    message.content = known->second(reader);
    reader.finish();
    if (reader.error()) return *reader.error();
    return message;
}

MessageHead read_message_head(std::string_view text) {
    MessageHead head;
    if (text.size() > longest_message) return head;
    const Json object = Json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!object.is_object()) return head;
    MessageReader reader(object);
    reader.take("type", head.type);
    if (!content_readers.contains(head.type)) head.type.clear();
    MessageReader(object).take("number", head.number);
    return head;
}

Json error_answer(const Error& error, const MessageHead& to) {
    Json answer{{"type", "error"}, {"message", error.message()}};
    if (!to.type.empty()) answer["about"] = to.type;
    if (to.number > 0) answer["number"] = to.number;
    return answer;
}

std::string message_text(const Json& message) {
    return message.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json json_of(const Vec3f& v) {
    return {v.x, v.y, v.z};
}

Json json_of(const Rotation& rotation) {
    // The largest of the four components is computed first (Shepperd 1978).
    const auto& r = rotation.row;
    const double trace = r[0].x + r[1].y + r[2].z;
    std::array<double, 4> q{};
    if (trace > 0) {
        const double s = 2 * std::sqrt(1 + trace);
        q = {(r[2].y - r[1].z) / s, (r[0].z - r[2].x) / s, (r[1].x - r[0].y) / s, s / 4};
        return q;
    }
    const int i = r[1].y > r[0].x ? (r[2].z > r[1].y ? 2 : 1) : (r[2].z > r[0].x ? 2 : 0);
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const auto at = [&](int row, int column) { return r[std::size_t(row)][column]; };
    const double s = 2 * std::sqrt(1 + at(i, i) - at(j, j) - at(k, k));
    q[std::size_t(i)] = s / 4;
    q[std::size_t(j)] = (at(j, i) + at(i, j)) / s;
    q[std::size_t(k)] = (at(k, i) + at(i, k)) / s;
    q[3] = (at(k, j) - at(j, k)) / s;
    return q;
}

Json json_of(const SceneMaterial& material) {
    const std::optional<FinishKeys> finish = finish_of(material);
    if (!finish)
        return {{"diffuse", json_of(material.diffuse)},
                {"specular", json_of(material.specular)},
                {"shininess", material.shininess},
                {"emission", json_of(material.emission)},
                {"convention", material.convention == LobeConvention::povray ? "povray" : "physical"}};
    Json keys;
    for (const FinishKey& key : *finish) keys[key.key] = key.value;
    return {{"pigment", json_of(material.pigment)}, {"finish", keys}};
}

}  // namespace haarfield
