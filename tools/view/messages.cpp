#include "tools/view/messages.h"

#include "scenes/povray_finish.h"
#include "tools/view/message_reader.h"
#include "tools/view/scene_editor.h"

#include <map>

namespace haarfield {
namespace {

using Json = nlohmann::json;

constexpr Range shares{0, 1};

void read_keys(MessageReader& reader, TurnLight& edit) {
    reader.require("rotation");
    reader.take("rotation", edit.turn);
}

void read_keys(MessageReader& reader, NamedLights& lights) {
    reader.require("light");
    reader.take("light", lights.first);
    if (reader.has("second")) reader.take("second", lights.second.emplace());
    reader.take("share", lights.share, shares);
}

void read_keys(MessageReader& reader, MixLights& edit) {
    reader.require("share");
    reader.take("share", edit.share, shares);
}

void read_keys(MessageReader& reader, SetExposure& edit) {
    reader.require("stops");
    const Json* stops = reader.find("stops");
    if (stops && *stops == "auto") return;
    reader.take("stops", edit.stops.emplace(), {-60, 60});
}

void read_keys(MessageReader& reader, PartialPlace& place) {
    reader.require("object");
    reader.take("object", place.object);
    if (reader.has("translate")) reader.take_three("translate", place.translate.emplace(), coordinates);
    if (reader.has("rotation")) reader.take("rotation", place.rotate.emplace());
    if (reader.has("scale")) reader.take("scale", place.scale.emplace(1.0f), {1e-4, 1e4});
    if (!place.translate && !place.rotate && !place.scale)
        reader.refuse("translate", "at least one of translate, rotation and scale");
}

template <class T>
requires std::is_same_v<T, CloneObject> || std::is_same_v<T, DeleteObject>
void read_keys(MessageReader& reader, T& edit) {
    reader.require("object");
    reader.take("object", edit.object);
}

void read_keys(MessageReader& reader, SetMaterial& edit) {
    reader.require("name");
    reader.take("name", edit.name);
    if (reader.has("pigment") || reader.has("finish")) {
        edit.material.convention = LobeConvention::povray;
        reader.require("pigment");
        reader.require("finish");
        reader.take_three("pigment", edit.material.pigment, albedos);
        reader.take_part("finish", [&](MessageReader& finish) { take_povray_finish(finish, edit.material); });
        return;
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
}

void read_keys(MessageReader& reader, SetSky& edit) {
    for (const char* key : {"turbidity", "sun_elevation", "sun_azimuth"}) reader.require(key);
    reader.take("turbidity", edit.turbidity, {2, 10});
    reader.take("sun_elevation", edit.sun_elevation, {0, 90});
    reader.take("sun_azimuth", edit.sun_azimuth, {-360, 360});
    edit.sun_elevation = radians(edit.sun_elevation);
    edit.sun_azimuth = radians(edit.sun_azimuth);
}

void read_keys(MessageReader& reader, SetLamp& edit) {
    for (const char* key : {"name", "colour"}) reader.require(key);
    reader.take("name", edit.name);
    reader.take_three("colour", edit.colour, {0, 1e9});
    if (reader.has("position")) reader.take_three("position", edit.position.emplace(), coordinates);
}

void read_keys(MessageReader& reader, EditPartMaterial& part) {
    for (const char* key : {"object", "part"}) reader.require(key);
    reader.take("object", part.object);
    reader.take("part", part.part);
}

void read_keys(MessageReader& reader, SetView& look) {
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
}

void read_keys(MessageReader& reader, Select& select) {
    reader.require("object");
    const Json* object = reader.find("object");
    if (object && !object->is_null()) reader.take("object", select.object.emplace());
}

void read_keys(MessageReader& reader, FrameDisplayed& shown) {
    reader.require("frame");
    reader.take("frame", shown.frame);
}

void read_keys(MessageReader& reader, Save& save) {
    if (reader.has("name")) reader.take("name", save.name.emplace(), 100);
}

void read_keys(MessageReader& reader, StartTask& task) {
    static const std::map<std::string, TaskKind> kinds{
        {"bake", TaskKind::bake}, {"reference", TaskKind::reference}, {"picture", TaskKind::picture}};
    std::string name;
    reader.require("task");
    reader.take("task", name);
    const auto kind = kinds.find(name);
    if (kind == kinds.end()) return reader.refuse("task", "bake, reference or picture");
    task.kind = kind->second;
}

template <class T>
requires std::is_empty_v<T>
void read_keys(MessageReader&, T&) {}

template <class T>
Content read_content(MessageReader& reader) {
    T content{};
    read_keys(reader, content);
    return content;
}

/// The readers of all messages, by type.
const std::map<std::string, Content (*)(MessageReader&), std::less<>> content_readers{
    {"turn_light", &read_content<TurnLight>},
    {"light", &read_content<NamedLights>},
    {"mix", &read_content<MixLights>},
    {"exposure", &read_content<SetExposure>},
    {"place", &read_content<PartialPlace>},
    {"clone", &read_content<CloneObject>},
    {"delete", &read_content<DeleteObject>},
    {"material", &read_content<SetMaterial>},
    {"sky", &read_content<SetSky>},
    {"lamp", &read_content<SetLamp>},
    {"own_material", &read_content<EditPartMaterial>},
    {"look", &read_content<SetView>},
    {"select", &read_content<Select>},
    {"undo", &read_content<StepBack>},
    {"redo", &read_content<StepOn>},
    {"shown", &read_content<FrameDisplayed>},
    {"save", &read_content<Save>},
    {"start", &read_content<StartTask>},
    {"cancel", &read_content<CancelTask>},
    {"restore", &read_content<Restore>},
    {"discard", &read_content<Discard>},
    {"steer", &read_content<Steer>},
};

/// A visitor of a variant, composed of one function for each alternative.
template <class... Functions>
struct Overloads : Functions... {
    using Functions::operator()...;
};
template <class... Functions>
Overloads(Functions...) -> Overloads<Functions...>;  // clang deduces aggregates since version 17 only

}  // namespace

Result<WindowChange> SceneEditor::apply(PageId page, const Message& message) {
    const Variation light{Variation::Of::light, 0}, nothing;
    const auto unchanged = [] { return Result<WindowChange>(WindowChange::none); };
    const auto step = [&](bool has_stepped) -> Result<WindowChange> {
        if (!has_stepped) return Error{"", "there is nothing more to take back or to do again"};
        hand_ = {};
        return look_as_designed();
    };
    const Overloads change{
        [&](const TurnLight& edit) { return make_edit(edit, message, light); },
        [&](const MixLights& edit) { return make_edit(edit, message, light); },
        [&](const SetSky& edit) { return make_edit(edit, message, light); },
        [&](const SetExposure& edit) { return make_edit(edit, message, hand_); },
        [&](const SetMaterial& edit) { return make_edit(edit, message, nothing); },
        [&](const SetLamp& edit) { return make_edit(edit, message, nothing); },
        [&](const CloneObject& edit) { return make_edit(edit, message, nothing); },
        [&](const DeleteObject& edit) { return make_edit(edit, message, nothing); },
        [&](const EditPartMaterial& part) { return own_part(part, message); },
        [&](const NamedLights& lights) { return take_lights(lights, message); },
        [&](const SetView& look) { return take_look(look, message); },
        [&](const PartialPlace& place) -> Result<WindowChange> {
            const std::optional<std::size_t> at = place_of(history_.now(), place.object);
            if (!at) return Error{"", fmt::format("unknown object {}", place.object)};
            Placement placement = history_.now().scene.instances[*at].placement;
            if (place.translate) placement.translate = *place.translate;
            if (place.scale) placement.scale = *place.scale;
            if (place.rotate) placement.rotate = *place.rotate;
            return make_edit(PlaceObject{place.object, placement}, message,
                             place.rotate ? nothing : Variation{Variation::Of::object, place.object});
        },
        [&](const Select& selected) -> Result<WindowChange> {
            if (selected.object && !place_of(history_.now(), *selected.object))
                return Error{"", fmt::format("there is no object {}", *selected.object)};
            if (selected.object) likely_ = {Variation::Of::object, *selected.object};
            return unchanged();
        },
        [&](const StepBack&) { return step(history_.undo()); },
        [&](const StepOn&) { return step(history_.redo()); },
        [&](const Save& file) { return save(page, file, message); },
        [&](const Restore&) -> Result<WindowChange> {
            if (!left_) return Error{"", "there is no autosaved scene"};
            HF_TRY_DONE(live_.lights().know(left_->environment));
            HF_TRY_DONE(make_edit(RestoreScene{*left_}, message, nothing));
            left_.reset();
            for (const PageId each : pages_.all()) pages_.tell_left_scene(each, {});
            return look_as_designed();
        },
        [&](const Discard&) -> Result<WindowChange> {
            left_.reset();
            for (const PageId each : pages_.all()) pages_.tell_left_scene(each, {});
            HF_TRY_DONE(file_.autosave(nullptr));
            return unchanged();
        },
        // ViewSession processes these.
        [&](const StartTask&) { return unchanged(); },
        [&](const CancelTask&) { return unchanged(); },
        [&](const Steer&) { return unchanged(); },
        [&](const FrameDisplayed&) { return unchanged(); },
    };
    return std::visit(change, message.content);
}

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

std::vector<std::string> message_types() {
    std::vector<std::string> types(content_readers.size());
    std::ranges::transform(content_readers, types.begin(), [](const auto& row) { return row.first; });
    return types;
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
