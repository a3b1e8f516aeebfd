#pragma once
/// POV-Ray scenes whose objects can be queried one by one.

#include "bridge/povray_import/scene_tokens.h"

#include <filesystem>
#include <map>
#include <set>
#include <string>

namespace haarfield {

/// A statement of a scene that creates objects, or a light.
struct SceneStatement {
    std::string file;      ///< Name of its file.
    std::size_t line = 0;  ///< From 1.
    std::string keyword;   ///< `sphere`, `light_source` ... or the name of a macro.
    std::string name;      ///< NAME of `object { NAME ... }`, or a macro's name; otherwise empty.
};

/// Something in a scene that an import leaves out.
struct UnusedStatement {
    std::string keyword;  ///< `media`, `subsurface` ...
    std::string file;     ///< Of its first occurrence.
    std::size_t line = 0;
    std::size_t count = 0;
};

/// A scene, rewritten so that each top-level object can be queried. The rewritten text uses these names:
///
/// HF_A[HF_N]   the objects, in the order in which POV-Ray creates them, also in loops.
/// HF_Put(id)   a macro that is called after each object; `id` is an index in `statements`. It must increase
///              HF_N.
/// HF_Light(id) a macro that is called before the lines of each light are written, in a survey.
/// HF_Survey, HF_Lights, HF_Sky, HF_Camera, HF_Settings, HF_Extras
///              numbers that switch parts of the scene on (1) or off (0): the evaluation of lights and camera
///              positions; lights; background, sky_sphere, fog and rainbow; cameras; global_settings;
///              interiors, media, photons and radiosity.
/// HF_F         a file handle, open for writing in a survey.
///
/// `hf_prelude.inc` declares them. It is included at the beginning, behind a leading `#version`, and
/// `hf_suffix.inc` at the end. SceneQueries writes both.
struct WrappedScene {
    /// A rewritten file.
    struct File {
        std::string name, text;
        std::string emissive_text;  ///< With finishes that emit the pigment times HF_E, and nothing else.
    };
    std::vector<File> files;  ///< The main file first. Their names begin with `hf_`.
    std::vector<SceneStatement> statements;
    std::vector<UnusedStatement> unused;  ///< In the order of their first occurrence.
    std::set<std::string> declared;       ///< Names of objects that the scene declares.
    bool has_camera = false;              ///< A file has a `camera` statement.
};

/// Files that are included in front of a scene, or instead of one.
struct WrapOptions {
    /// Folders in which includes are searched for after the scene's.
    std::vector<std::filesystem::path> library{"/usr/share/povray/include", "/usr/share/povray-3.7/include",
                                               "/usr/local/share/povray-3.7/include"};
    /// If set, the scene is an include file that declares this object, which is then the only one.
    std::string object{};
};

/// Rewrites a scene. The text is not evaluated: macros, loops and conditions work because POV-Ray runs them.
///
/// At the top level, an object `sphere {...}` becomes `#declare HF_A[HF_N]=sphere {...} HF_Put(id)`. The call
/// of a macro becomes a union. Statements that POV-Ray forbids in a union, such as `camera`, leave the union
/// if they are at the top level of a macro. Included files with literal names are rewritten as well.
///
/// errors  as InputFile::open; unterminated comments and strings (with the line); files of more than 64 MB;
///         more than 1000 included files. Other faults of the scene are left to POV-Ray.
/// cost    proportional to the text. Reads the scene and the files that it includes.
/// source  the prototype rewrote 392 of the 396 scenes of Debian's povray-examples.
Result<WrappedScene> wrapped_scene(const std::filesystem::path& scene, const WrapOptions& options = {});

}  // namespace haarfield
