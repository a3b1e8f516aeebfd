#pragma once
/// The same scene for POV-Ray's own ray tracer: what the baked one is compared with.

#include "bridge/povray/emitter_lamps.h"
#include "bridge/povray/lamp_text.h"
#include "bridge/povray/light_dome.h"
#include "bridge/povray/povray_scene.h"
#include "scenes/scene_entities.h"

#include <memory>
#include <span>

namespace haarfield {

/// One object. Mesh and materials must outlive the call; instances
/// that share both share them in the file too.
struct ReferenceInstance {
    std::string name;                     ///< Unlike all others of the scene.
    const Mesh* mesh = nullptr;           ///< PreparedMesh::original, with its normals.
    std::span<const Material> materials;  ///< By the mesh's material index.
    Placement placement;
    /// By the mesh's materials, which are theirs; none: plain ones. Must outlive the call.
    std::span<const Surface> surfaces{};
    std::vector<Emitter> emitters{};  ///< What of it lights others, in its own frame: emitters_of.
};

/// A scene's instances; their meshes and materials are those of the entities.
///
/// originals  original_entities of the scene, which must outlive the result.
std::vector<ReferenceInstance> reference_instances(const Scene& scene, const SceneEntities& originals);

/// What a scene file may be told by a declaration: to be lit by one of its two sets of lights, twice as
/// bright. Without either, both light it.
inline constexpr const char* first_lights_alone = "First_Lights_Alone";
inline constexpr const char* second_lights_alone = "Second_Lights_Alone";  ///< And the other set.

/// Or, with both of them, to be lit by its background instead: radiosity_picture.
inline constexpr const char* by_radiosity = "By_Radiosity";

/// Of scenes with bounces, too: these are left out; and of the sets of lights those few are there under which
/// bounces are gathered, as they do not need the many that make shadows smooth.
inline constexpr const char* without_bounces = "Without_Bounces";
inline constexpr const char* few_lights_alone = "Few_Lights_Alone";
inline constexpr int few_lights_of_bounces = 64;  ///< At most, of both sets.

/// With neither set of lights: all light sources are off, and POV-Ray's radiosity gathers the light of the
/// emitters itself, followed as often as the scene's bounces. With direct_light_alone, too: without bounces.
inline constexpr const char* emitters_by_radiosity = "Emitters_By_Radiosity";
inline constexpr const char* direct_light_alone = "Direct_Light_Alone";

/// Light that goes from one diffuse surface to another, by POV-Ray's radiosity.
///
/// accuracy  closed furnaces to 0.3 %; boxes under a sky within 2 %. Not the same from run to run with
///           several threads. Highlights send nothing on.
struct ReferenceBounces {
    int limit = 0;  ///< Bounces, at most 20 (asserted); 0: direct light alone.

    /// An object of a baked scene, as its include declares it.
    struct BakedObject {
        std::filesystem::path include;
        std::string name;
    };
    /// If there are any, these send light instead of the scene's own objects, once: what the picture shows
    /// then is what the bake must be, if it is right. Each is there beside the object that it was made of.
    std::vector<BakedObject> baked{};
};

/// What write_reference_scene wrote.
struct ReferenceFiles {
    std::filesystem::path scene;                    ///< `NAME.pov`
    std::vector<std::filesystem::path> includes;    ///< The meshes, one file each.
    std::vector<std::filesystem::path> images;      ///< Of textures; see write_textures.
    int lights = 0;                                 ///< Written, of both sets; black ones are not.
    int lamps = 0;                                  ///< Of the scene's own.
    bool has_bounces = false;                       ///< Of lights, gathered under few of them.
    bool has_emitters = false;                      ///< Surfaces that light others, as lamps.
    std::shared_ptr<const LampSets> emitter_lamps;  ///< Their direct light; null: no emitters.
    double world_scale = 1;                         ///< POV-Ray units per metre, a power of two.
    std::vector<std::string> warnings;              ///< Where POV-Ray can not show a material as meant.
};

/// Writes `NAME.pov` and `NAME_mesh_<k>.inc`, each atomically, the scene file last.
///
/// light       two domes of half the lights each, independent of each other (LightDomeOptions::cut_share),
///             as parallel light sources with shadows, colour irradiance/pi: rendered one at a time, they
///             tell how far the reference itself can be trusted (reference_picture.h).
/// lights      of both domes together, at most; >= 16 (asserted). A black environment has none.
/// emitters    in each set as so many lamps as its dome has lights, half of them where the points that the
///             camera shows need them: emitter_lamps.
/// lamps       beside both: the same light_sources, formula by formula. What one looks like casts no shadow
///             of any light, with a warning where there are others: POV-Ray knows no less.
/// materials   POV-Ray's own terms: `diffuse`, `phong` and `phong_size`, `specular` (blinn) and `roughness`,
///             `metallic`. In the povray convention that is exact. In the physical one the highlight is
///             scaled by (n+2)/2 and lacks the cosine: a warning says so. A coloured highlight is
///             exact: see reference_scene.cpp. Textures, colours of vertices and emission are POV-Ray's own.
///             An image tints a metal's highlights at each pixel.
/// scale       the world is magnified, so that POV-Ray's absolute shadow tolerance (1e-3 units) does
///             not matter: the median object is 10 to 1000 units.
/// errors      as write_baked_scene; a material index that `materials` does not have; material values out of
///             their ranges; metallic highlights that are coloured, or not as the diffuse term is.
Result<ReferenceFiles> write_reference_scene(const std::filesystem::path& folder,
                                             const std::string& scene_name, const Camera& camera,
                                             std::span<const ReferenceInstance> instances,
                                             const Environment& environment, int lights = 1024,
                                             const ReferenceBounces& bounces = {},
                                             std::span<const Lamp> lamps = {});

}  // namespace haarfield
