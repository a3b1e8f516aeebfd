#pragma once
/// Messages of pages, as described in PROTOCOL.md.

#include "tools/view/design.h"

#include <nlohmann/json_fwd.hpp>

#include <string_view>

namespace haarfield {

/// One light of the shelf by name, or a mixture of two.
struct NamedLights {
    std::string first;
    std::optional<std::string> second;
    float share = 0.5f;  ///< Fraction of the second light.
};
/// A change of an object's placement. Components that are absent remain bit-identical.
struct PartialPlace {
    std::uint32_t object;
    std::optional<Vec3f> translate;
    std::optional<float> scale;
    std::optional<Rotation> rotate;
};
/// The view of the page, with the resolution and field of view of its window.
struct SetView {
    Camera camera;
};
/// The object that is likely to be edited next, or none.
struct Select {
    std::optional<std::uint32_t> object;
};
struct StepBack {};  ///< Undo.
struct StepOn {};    ///< Redo.
/// The page has displayed a frame and accepts the next.
struct FrameDisplayed {
    std::uint32_t frame;
};
/// Saves into the opened file, or into a new file next to it.
struct Save {
    std::optional<std::string> name;
};
enum class TaskKind { bake, reference, picture };
struct StartTask {
    TaskKind kind;
};
struct CancelTask {};
/// Assigns a new material of the scene to a part of a model.
struct EditPartMaterial {
    std::uint32_t object;
    std::uint32_t part;  ///< Index in the list `entities`.
};
struct Restore {};  ///< Restores the autosaved scene of an earlier session.
struct Discard {};  ///< Deletes the autosaved scene.
struct Steer {};    ///< The page takes over steering.

using Content =
    std::variant<TurnLight, NamedLights, MixLights, SetExposure, PartialPlace, CloneObject, DeleteObject,
                 SetMaterial, SetSky, SetLamp, EditPartMaterial, SetView, Select, StepBack, StepOn,
                 FrameDisplayed, Save, StartTask, CancelTask, Restore, Discard, Steer>;

/// A message of a page.
struct Message {
    std::string type;
    std::uint32_t number = 0;   ///< The page's number for the message. Frames and answers repeat it.
    std::uint32_t gesture = 0;  ///< See History::make.
    Content content;
};

/// The maximum length of a message. [bytes]
inline constexpr std::size_t longest_message = 1 << 16;

/// Reads a message.
///
/// errors  (without a place) invalid JSON, or not an object; an unknown type or key; a missing key; a value
///         of the wrong type or out of range, with what was expected.
Result<Message> read_message(std::string_view text);

/// Returns the types of all messages, in alphabetical order.
std::vector<std::string> message_types();

/// The type and the number of a message, which identify it in answers.
struct MessageHead {
    std::string type;          ///< Empty if missing or unknown.
    std::uint32_t number = 0;  ///< 0 if missing.
};

/// Reads the head of a text, including texts that read_message rejects.
MessageHead read_message_head(std::string_view text);

/// Returns an error as the answer to a message.
nlohmann::json error_answer(const Error& error, const MessageHead& to);

/// Returns a message to pages. Bytes that are not valid UTF-8 (file names, truncated texts) become U+FFFD.
std::string message_text(const nlohmann::json& message);

/// @name Values in messages @{
nlohmann::json json_of(const Vec3f& v);
nlohmann::json json_of(const Rotation& rotation);       ///< A quaternion: x, y, z, w.
nlohmann::json json_of(const SceneMaterial& material);  ///< With the keys of the scene file.
/// @}

}  // namespace haarfield
