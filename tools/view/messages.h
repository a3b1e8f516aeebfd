#pragma once
/// What pages say: PROTOCOL.md has it in words.

#include "tools/view/design.h"

#include <nlohmann/json_fwd.hpp>

#include <string_view>

namespace haarfield {

/// A light by its name on the shelf, or two.
struct NamedLights {
    std::string first;
    std::optional<std::string> second;
    float share = 0.5f;  ///< Of the second.
};
/// Of an object's place what is not given stays as it is, to the last bit.
struct PartialPlace {
    std::uint32_t object;
    std::optional<Vec3f> translate;
    std::optional<float> scale;
    std::optional<Rotation> rotate;
};
/// Where the page looks from; resolution and angle are those of its window.
struct Look {
    Camera camera;
};
/// What the hand is likely to take next: an object, or nothing.
struct Select {
    std::optional<std::uint32_t> object;
};
struct StepBack {};  ///< Undo.
struct StepOn {};    ///< Redo.
/// The page shows a frame, and wants the next.
struct Shown {
    std::uint32_t frame;
};
/// Into the file that was opened, or beside it.
struct Save {
    std::optional<std::string> name;
};
enum class TaskKind { bake, reference, picture };
struct StartTask {
    TaskKind kind;
};
struct CancelTask {};
/// A part of a model gets a material of the scene.
struct OwnPart {
    std::uint32_t object;
    std::uint32_t part;  ///< As `entities` lists them.
};
struct Restore {};  ///< The autosaved scene of an earlier session.
struct Discard {};  ///< Deletes it.
struct Steer {};    ///< The page takes over.

using Content = std::variant<TurnLight, NamedLights, MixLights, SetExposure, PartialPlace, CloneObject,
                             DeleteObject, SetMaterial, SetSky, SetLamp, OwnPart, Look, Select, StepBack,
                             StepOn, Shown, Save, StartTask, CancelTask, Restore, Discard, Steer>;

/// One message of a page.
struct Message {
    std::string type;
    std::uint32_t number = 0;   ///< As the page counts its messages; frames and answers repeat it.
    std::uint32_t gesture = 0;  ///< See History::make.
    Content content;
};

/// The longest message. [bytes]
inline constexpr std::size_t longest_message = 1 << 16;

/// Reads a message.
///
/// errors  (without a place) no JSON, or no object of it; an unknown type; a key that the type does not have,
///         one that is missing, or a value of another kind or beyond its range, with what was wanted.
Result<Message> read_message(std::string_view text);

/// The type and the number of a message, by which answers refer to it.
struct MessageHead {
    std::string type;          ///< Empty if it is missing or unknown.
    std::uint32_t number = 0;  ///< 0 if it is missing.
};

/// Reads the head of any text, also of one that read_message refuses.
MessageHead read_message_head(std::string_view text);

/// An error, as an answer to a message.
nlohmann::json error_answer(const Error& error, const MessageHead& to);

/// A message to pages. Bytes that are no UTF-8 (names of files, texts that were cut) become U+FFFD.
std::string message_text(const nlohmann::json& message);

/// @name What messages say of values. @{
nlohmann::json json_of(const Vec3f& v);
nlohmann::json json_of(const Rotation& rotation);       ///< A quaternion: x, y, z, w.
nlohmann::json json_of(const SceneMaterial& material);  ///< With the keys of the scene file.
/// @}

}  // namespace haarfield
