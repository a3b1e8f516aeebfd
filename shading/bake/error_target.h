#pragma once
/// A bake whose vertices and rays are chosen for a wanted error.

#include "shading/bake/bake_error.h"

namespace haarfield {

/// The wanted error, and the limits of the search.
struct ErrorTarget {
    double error = 0.01;                                             ///< BakeError::total.
    std::size_t vertex_budget = RefinementSettings().vertex_budget;  ///< Over all instances.
    bool by_view = true;                                             ///< RefinementSettings::by_view.
    /// The largest RenderSettings::face_size that the search chooses freely; the settings have the smallest.
    int usual_face_size = 0;
    /// The largest one that it may choose where the target is not reached otherwise.
    int most_face_size = 0;
    /// True: the search stops when it finds that indirect light is not accurate enough; before the
    /// refinement, if it can. It does not stop where the cause is that bounces
    /// are left out.
    bool stops_early = false;
};

/// The reason for which a search ended.
enum class SearchEnd {
    reached,        ///< The target is reached.
    vertex_budget,  ///< The vertex budget is used up.
    short_edges,    ///< Edges between the points with large errors are too short to be split.
    little_gain,    ///< More vertices reduced the error too little, several times.
    direct_light,   ///< The direct light where it is computed is not accurate enough.
    indirect_light  ///< The indirect light where it is computed is not accurate enough.
};

/// A bake to a target error, and the choices that were made.
struct TargetBake {
    std::vector<RadiantMesh> meshes;        ///< By instance.
    std::optional<IndirectLight> indirect;  ///< Present if there are bounces.
    BakeError error;
    SearchEnd end = SearchEnd::reached;
    bool fitted = false;         ///< True: colours are fitted; false: they are the radiance at the vertices.
    std::size_t cut_edges = 0;   ///< DiscontinuityMeshes::cut_edges; 0: meshes are not cut.
    int directions = 0;          ///< BounceSettings::directions; 0 without bounces.
    int gathering_rays = 0;      ///< IndirectLight::gathering_rays; 0 without bounces.
    int face_size = 0;           ///< RenderSettings::face_size.
    int source_directions = 1;   ///< SourceRule::direction_factor.
    int light_coefficients = 0;  ///< RenderSettings::light_coefficients.
    int rounds = 0;              ///< Refinement::rounds.
    std::size_t shaded_points = 0;  ///< Refinement::shaded_points.
    bool is_stopped = false;        ///< By ErrorTarget::stops_early: the meshes are of no use.
};

/// Bakes a scene to a target error with few vertices.
///
/// The search starts with the fine meshes of the entities. First, it measures direct light at a few points.
/// While the upper end of the 90 % interval of its error exceeds half of the target, it tries more
/// directions of suns and windows, then larger faces, and then all wavelets of the light. Where its error
/// alone nearly exceeds the target, it tries the largest faces. It chooses the fewest gathering rays whose
/// noise is below a quarter of the target. It then measures the shading as a whole. While the error of
/// indirect light is too large, it repeats it, first with focused_indirect_light, then with four times as
/// many directions each time, and keeps the most accurate one. It then refines the meshes in steps.
/// Whenever the vertices are 4 % more, it measures interpolation with sampled and with fitted colours;
/// whenever they are 50 % more (300 % where it does not help, or earlier where it is likely to), also with
/// meshes that are cut along hard shadow edges. It stops when the upper end of the 90 % interval of
/// interpolation is below what the shading leaves of the target. Other points measure the reported error.
/// If it exceeds the target, the refinement continues, at most twice. Where the shading alone exceeds the
/// target, interpolation may have half of its error.
///
/// direct      the scene without indirect light; its settings contain the bounces. Scenes with fields need
///             the face size of their fields. Its sharing divides the direct light of the fine meshes; if it
///             is partial, the search ends after them, and the result must not be used.
/// population  the points at which the bake is displayed.
/// accuracy    bit-identical for any number of threads.
/// cost        that of the refinement; measurements take 2 to 3 s of processor time for a target of 1 %,
///             and some 10 s each in rooms where paths are noisy.
/// errors      interrupted.
Result<TargetBake> target_bake(const PointShading& direct, const ErrorTarget& target,
                               std::vector<DisplayedPoint> population, const Progress& progress = {});

/// Measures a bake of the fine meshes' vertices.
///
/// shading     with its indirect light, if there is any.
/// radiance    of the bake, by instance and vertex.
/// accuracy    as for BakeErrorMeter::shading_error.
/// errors      interrupted.
Result<BakeError> vertex_bake_error(const PointShading& shading, const SceneRadiance& radiance,
                                    std::vector<DisplayedPoint> population, double accuracy,
                                    const Progress& progress = {});

}  // namespace haarfield
