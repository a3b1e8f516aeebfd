#pragma once
/// A scene, baked: shaded with all that its surfaces want, ready to be written.

#include "scenes/baked_instance.h"
#include "scenes/scene_entities.h"
#include "shading/bake/mesh_refinement.h"

#include <optional>

namespace haarfield {

/// How direct light is integrated. All add the same indirect light.
enum class Evaluator {
    tree,   ///< Wavelet product integrals.
    dense,  ///< Plain sums over texels, slow.
    rays,   ///< Monte Carlo integration.
};

/// How colours of vertices are chosen.
enum class BakedColours {
    sampled,  ///< The radiance at the vertices.
    fitted,   ///< See fit_radiance.
};

/// How a bake shades.
struct BakeOptions {
    Evaluator evaluator = Evaluator::tree;
    std::optional<float> refine;  ///< RefinementSettings::tolerance; none: at the fine meshes' vertices.
    std::optional<std::size_t> vertex_budget;  ///< With `refine`; none: usual_vertex_budget.
    BakedColours colours = BakedColours::sampled;
    std::vector<std::string> passes;  ///< Of pass_names.
    std::uint32_t samples = 1024;     ///< At each vertex, by Evaluator::rays.
};

/// The passes that there are: diffuse, indirect, irradiance, occlusion, own-shadow, specular.
std::vector<std::string> pass_names();

/// Refuses passes that are not known and options that exclude each other.
Result<Done> check_bake(const BakeOptions& options);

/// The default of RefinementSettings, or half as many vertices again as the models' surfaces have in all
/// instances: so that fine models leave some for where the radiance changes.
std::size_t usual_vertex_budget(const SceneEntities& entities);

/// How a refinement ended: see Refinement.
struct RefinementOutcome {
    std::size_t vertex_budget = 0;  ///< That it had.
    float largest_error = 0;
    std::size_t shaded_points = 0;
    int rounds = 0;
};

/// What bounces came to: see IndirectLight.
struct BounceOutcome {
    int computed = 0;
    double left_out = 0;
    std::size_t matrix_bytes = 0;
};

/// A pass of a bake.
struct BakedPass {
    std::string name;                      ///< Of pass_names.
    SceneColours values;                   ///< For meshes.
    std::vector<SeenRadiance> seen;        ///< For POV-Ray, of the instances that follow.
    std::vector<BakedInstance> instances;  ///< As POV-Ray is to show the pass.
    bool has_environment = false;          ///< Whether the environment is behind it.
};

/// The scene's instances as they are written, with what they refer to.
struct BakedScene {
    std::vector<RadiantMesh> refined;  ///< By instance; empty if the entities' fine meshes serve.
    SceneRadiance fine;                ///< Of the fine meshes, by instance; or empty.
    std::vector<SeenRadiance> seen;    ///< By instance.
    std::vector<BakedPass> passes;
    std::vector<BakedInstance> instances;
    std::optional<RefinementOutcome> refinement;  ///< If it was asked for.
    std::optional<BounceOutcome> bounces;         ///< If there are any.
};

/// Shades a scene.
///
/// scene, entities  must outlive the result, and `shaded` is made of them.
/// options          check_bake finds nothing wrong (asserted).
/// sharing          null: this process shades all points. If it is partial, the result is of no use.
/// errors           interrupted.
Result<BakedScene> baked_scene(const Scene& scene, const SceneEntities& entities, const ShadedScene& shaded,
                               const RenderSettings& settings, const BakeOptions& options,
                               const Progress& progress = {}, const PointSharing* sharing = nullptr);

}  // namespace haarfield
