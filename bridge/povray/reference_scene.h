#pragma once
/// Writes the scene for POV-Ray's own ray tracer, as the reference for the baked scene.

#include "bridge/povray/emitter_lamps.h"
#include "bridge/povray/lamp_text.h"
#include "bridge/povray/light_dome.h"
#include "bridge/povray/povray_scene.h"
#include "scenes/scene_entities.h"

#include <memory>
#include <span>

namespace haarfield {

/// One object. Mesh and materials must outlive the call. Instances that share both also share them in the
/// file.
struct ReferenceInstance {
    std::string name;                     ///< Unique in the scene.
    const Mesh* mesh = nullptr;           ///< PreparedMesh::original, with normals.
    std::span<const Material> materials;  ///< By the mesh's material index.
    Placement placement;
    /// By the mesh's materials; must contain these materials. Empty: plain surfaces. Must outlive the call.
    std::span<const Surface> surfaces{};
    std::vector<Emitter> emitters{};  ///< The object's emitters in its own frame: emitters_of.
};

/// Returns a scene's instances, with the meshes and materials of the entities.
///
/// originals  original_entities of the scene, which must outlive the result.
std::vector<ReferenceInstance> reference_instances(const Scene& scene, const SceneEntities& originals);

/// Declarations that control a scene file. This declaration selects the first of the two sets of lights, with
/// twice the brightness. Without a declaration, both sets light the scene.
inline constexpr const char* first_dome_only = "First_Lights_Alone";
inline constexpr const char* second_dome_only = "Second_Lights_Alone";  ///< Selects the second set.

/// With both declarations above: the background lights the scene by radiosity instead; see radiosity_picture.
inline constexpr const char* by_radiosity = "By_Radiosity";

/// For scenes with bounces: omits the indirect light.
inline constexpr const char* without_bounces = "Without_Bounces";

/// For scenes with bounces: reduces each set to the few lights under which bounces are gathered. Bounces need
/// fewer lights than smooth shadows do.
inline constexpr const char* reduced_lights_alone = "Few_Lights_Alone";
inline constexpr int reduced_lights_of_bounces = 64;  ///< At most, in both sets together.

/// Emitters_By_Radiosity, with both sets of lights deselected: all light sources are off. POV-Ray's radiosity
/// gathers the emitters' light, with as many bounces as the scene has.
inline constexpr const char* emitters_by_radiosity = "Emitters_By_Radiosity";

/// With Emitters_By_Radiosity: removes the bounces.
inline constexpr const char* direct_light_only = "Direct_Light_Alone";

/// Indirect light between diffuse surfaces, computed by POV-Ray's radiosity.
///
/// accuracy  closed furnaces to 0.3 %; boxes under a sky within 2 %. Not deterministic with several threads.
///           Specular reflection adds no indirect light.
struct ReferenceBounces {
    int limit = 0;  ///< Number of bounces, at most 20 (asserted); 0: direct light alone.

    /// An object of a baked scene, as declared by its include.
    struct BakedObject {
        std::filesystem::path include;
        std::string name;
    };
    /// If not empty, these objects emit their baked light, and this light is gathered once instead of bounces
    /// between the scene's objects. The picture then shows what a correct bake must contain. Each object is
    /// at the place of its original.
    std::vector<BakedObject> baked{};
};

/// The files that write_reference_scene wrote.
struct ReferenceFiles {
    std::filesystem::path scene;                  ///< `NAME.pov`
    std::vector<std::filesystem::path> includes;  ///< One file per mesh.
    std::vector<std::filesystem::path> images;    ///< Texture images; see write_textures.
    int lights = 0;             ///< Number of lights in both sets; black ones are not written.
    int lamps = 0;              ///< Number of the scene's own lamps.
    bool has_bounces = false;   ///< The lights' bounces are gathered under reduced_lights_of_bounces.
    bool has_emitters = false;  ///< Emissive surfaces light the scene, as lamps.
    std::shared_ptr<const LampSets> emitter_lamps;  ///< The emitters' direct light; null: no emitters.
    double world_scale = 1;                         ///< POV-Ray units per metre, a power of two.
    std::vector<std::string> warnings;              ///< Materials that POV-Ray cannot render exactly.
};

/// Writes `NAME.pov` and `NAME_mesh_<k>.inc`, each atomically, the scene file last.
///
/// light       two domes of half the lights each, independent of each other (LightDomeOptions::cut_share), as
///             parallel light sources with shadows and the colour irradiance/pi. Rendered separately, they
///             give the error of the reference (reference_picture.h).
/// lights      maximum number of both domes together, >= 16 (asserted). A black environment has none.
/// emitters    represented in each set by as many lamps as its dome has lights, half of them placed for the
///             points that the camera shows: emitter_lamps.
/// lamps       become POV-Ray's light_sources, in addition to both sets. The object that shows the shape of a
///             lamp (Lamp::looks_like) casts no shadow from any light, because POV-Ray has no finer control.
///             A warning reports this if there are other lights.
/// assumed_gamma  as Scene::assumed_gamma.
/// filters     cast the shadows of POV-Ray's transparent objects in all lights, and are not visible.
/// materials   POV-Ray's own terms: `diffuse`, `phong` and `phong_size`, `specular` (blinn) and `roughness`,
///             `metallic`, which are exact in the povray convention. In the physical convention the specular
///             lobe is scaled by (n+2)/2 and lacks the cosine, with a warning. A coloured specular lobe is
///             exact: see reference_scene.cpp. Textures, vertex colours and emission use POV-Ray's own
///             features. An image tints a metal's specular lobes at each pixel.
/// scale       the world is magnified so that the median object has 10 to 1000 units, and POV-Ray's absolute
///             shadow tolerance (1e-3 units) does not matter.
/// errors      as write_baked_scene; a material index outside `materials`; material values out of range;
///             metallic specular lobes that are coloured or differ in colour from the diffuse term.
Result<ReferenceFiles> write_reference_scene(
    const std::filesystem::path& folder, const std::string& scene_name, const Camera& camera,
    std::span<const ReferenceInstance> instances, const Environment& environment, int lights = 1024,
    const ReferenceBounces& bounces = {}, std::span<const Lamp> lamps = {},
    std::span<const SceneFilter> filters = {}, double assumed_gamma = 1);

}  // namespace haarfield
