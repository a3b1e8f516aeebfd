#pragma once
/// How `bake` shades: the options of it, and what it makes of a scene.

#include "bridge/baked_scene.h"
#include "scenes/scene_entities.h"
#include "shading/bake/mesh_refinement.h"
#include "tools/command.h"

#include <optional>

namespace haarfield {

struct BakeShadingOptions {
    std::string evaluator = "tree";
    std::optional<float> refine;
    std::size_t vertex_budget = RefinementSettings().vertex_budget;
    std::string colours = "sampled";
    std::vector<std::string> passes;  ///< As --pass names them.
};

/// Adds --evaluator, --refine, --vertex-budget, --colours and --pass.
void add_bake_shading_options(CLI::App& command, BakeShadingOptions& options);

/// What of the options can not be had together.
Result<Done> check_bake_shading(const BakeShadingOptions& options);

/// A pass of a bake.
struct BakedPass {
    std::string name;                      ///< As --pass has it.
    SceneRadiance values;                  ///< For meshes.
    std::vector<SeenRadiance> seen;        ///< For POV-Ray, of the instances that follow.
    std::vector<BakedInstance> instances;  ///< As POV-Ray is to show the pass.
    bool has_environment = false;          ///< Whether the environment is behind it.
};

/// The scene's instances as they are written, with what they refer to.
struct BakedScene {
    std::vector<RadiantMesh> refined;  ///< By instance; empty if the entities' fine meshes serve.
    SceneRadiance fine;                ///< Of the fine meshes, by instance; or empty.
    std::vector<SeenRadiance> seen;    ///< By instance; empty where surfaces are plain.
    std::vector<BakedPass> passes;
    std::vector<BakedInstance> instances;
};

/// Shades a scene.
///
/// scene, entities  must outlive the result, and `shaded` is made of them.
/// errors           interrupted.
Result<BakedScene> baked_scene(const Scene& scene, const SceneEntities& entities, const ShadedScene& shaded,
                               const RenderSettings& settings, const BakeShadingOptions& options,
                               CommandContext& context);

}  // namespace haarfield
