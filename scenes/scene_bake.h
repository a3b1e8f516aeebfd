#pragma once
/// Bakes a scene: shades its vertices and separates radiance from textures, for pictures and files.

#include "scenes/baked_instance.h"
#include "scenes/scene_entities.h"
#include "shading/bake/error_target.h"

#include <optional>

namespace haarfield {

/// The method of integrating light.
enum class Evaluator {
    tree,   ///< Wavelet product integrals.
    dense,  ///< Plain sums over texels, slow. Indirect light is that of `tree`.
    rays,   ///< Monte Carlo integration, with indirect light by paths.
};

/// The method of computing the colours of vertices.
enum class BakedColours {
    sampled,  ///< The radiance at the vertices.
    fitted,   ///< See fit_radiance.
};

/// The settings of a bake, besides RenderSettings.
struct BakeOptions {
    /// The target of target_bake; none: the other members choose the vertices.
    std::optional<double> error;
    bool everywhere = false;  ///< With `error`: it is measured over all surfaces, not over a picture.
    /// With `error`: ErrorTarget::most_face_size, if the scene has no fields.
    int most_face_size = 128;
    /// With `error`: ErrorTarget::stops_early.
    bool stops_early = false;
    Evaluator evaluator = Evaluator::tree;
    std::optional<float> refine;  ///< RefinementSettings::tolerance; none: at the fine meshes' vertices.
    std::optional<std::size_t> vertex_budget;  ///< None: usual_vertex_budget; with `error` search_budget.
    BakedColours colours = BakedColours::sampled;
    std::vector<std::string> passes;  ///< Members of pass_names.
    std::uint32_t samples = 1024;     ///< RaySettings::samples, for Evaluator::rays.
};

/// Returns the names of all passes: diffuse, indirect, irradiance, occlusion, own-shadow, specular.
std::vector<std::string> pass_names();

/// Checks options.
///
/// errors  unknown passes; options that exclude each other.
Result<Done> check_bake(const BakeOptions& options);

/// Returns the larger of RefinementSettings' default and 1.5 times the number of vertices of the models'
/// surfaces in all instances. Fine models thus retain vertices for places where the radiance changes.
std::size_t usual_vertex_budget(const SceneEntities& entities);

/// The outcome of a refinement; see Refinement.
struct RefinementOutcome {
    std::size_t vertex_budget = 0;  ///< The budget that was used.
    float largest_error = 0;
    std::size_t shaded_points = 0;
    int rounds = 0;
};

/// The outcome of a search; see TargetBake.
struct SearchOutcome {
    double target = 0;
    BakeError error;
    SearchEnd end = SearchEnd::reached;
    std::size_t vertex_budget = 0;  ///< The budget that was used.
    bool fitted = false;
    std::size_t cut_edges = 0;
    int directions = 0;
    int gathering_rays = 0;
    bool is_focused = false;  ///< IndirectLight::lit was used.
    int face_size = 0;
    int source_directions = 1;
    int light_coefficients = 0;
    std::size_t shaded_points = 0;
    int rounds = 0;
    bool is_everywhere = false;  ///< The error was measured over all surfaces.
    bool is_stopped = false;     ///< The search stopped early: nothing is baked.
};

/// The outcome of indirect light; see IndirectLight.
struct BounceOutcome {
    int computed = 0;
    double left_out = 0;
    std::size_t matrix_bytes = 0;
};

/// A pass of a bake.
struct BakedPass {
    std::string name;                      ///< A member of pass_names.
    SceneColours values;                   ///< For mesh files.
    std::vector<LayeredRadiance> layered;  ///< For POV-Ray; `instances` refers to it.
    std::vector<BakedInstance> instances;  ///< As POV-Ray displays the pass.
    bool has_environment = false;          ///< True: the environment is the background of the pass.
};

/// The scene's instances for writing, and the data that they refer to.
struct BakedScene {
    std::vector<RadiantMesh> refined;      ///< By instance. Empty if the entities' fine meshes are used.
    SceneRadiance fine;                    ///< Radiance of the fine meshes, by instance; or empty.
    std::vector<LayeredRadiance> layered;  ///< By instance.
    std::vector<BakedPass> passes;
    std::vector<BakedInstance> instances;
    std::optional<RefinementOutcome> refinement;  ///< Present if a refinement was requested.
    std::optional<SearchOutcome> search;          ///< Present if an error was requested.
    std::optional<BounceOutcome> bounces;         ///< Present if the scene has bounces.
};

/// Shades a scene.
///
/// scene, entities  must outlive the result. `shaded` is their shaded_scene.
/// options          must pass check_bake (asserted).
///                  With BakeOptions::error, the entities are those of search_start, with search_fields.
/// sharing          null: this process shades all points. If it is partial, the result must not be used. With
///                  BakeOptions::error, it divides the points at which the search starts.
/// pixels           for BakeOptions::error: the points of the fine meshes that are visible at the pixels of
///                  the picture, row by row from the top. Without any, the error is that of all surfaces.
/// errors           interrupted.
Result<BakedScene> baked_scene(const Scene& scene, const SceneEntities& entities, const ShadedScene& shaded,
                               const RenderSettings& settings, const BakeOptions& options,
                               const Progress& progress = {}, const PointSharing* sharing = nullptr,
                               std::span<const std::optional<MeshPoint>> pixels = {});

}  // namespace haarfield
