#pragma once
/// Prepares the search for a bake with a wanted error: its start, its limits and the points that it measures.
/// Repeats a search that stopped early.

#include "scenes/scene_bake.h"

#include <functional>

namespace haarfield {

/// Vertices of all instances at the start of a search. Small objects have more if their files have more.
inline constexpr std::uint32_t search_start_vertices = 10000;

/// Returns the numbers of start vertices of successive searches: search_start_vertices, and many more if the
/// budget allows. All searches but the last one have BakeOptions::stops_early: where light is reflected
/// between folds of a bright surface, few vertices do not describe it well enough.
///
/// vertex_budget  BakeOptions::vertex_budget.
std::vector<std::uint32_t> search_starts(std::optional<std::size_t> vertex_budget);

/// Returns the scene with the fine vertices from which a search starts. Entity::fine_vertices change in
/// proportion; with search_start_vertices, they only become smaller.
///
/// vertices  of search_starts.
Scene search_start(const Scene& scene, std::uint32_t vertices = search_start_vertices);

/// One bake: from the fine vertices of search_start, or from the scene's own without a start.
using BakeAttempt =
    std::function<Result<BakedScene>(std::optional<std::uint32_t> start, const BakeOptions& options)>;

/// Bakes once without BakeOptions::error. With it, searches from each of search_starts in turn, until one
/// search is not stopped early.
///
/// errors  those of the attempts.
Result<BakedScene> repeated_bake(const BakeOptions& options, const BakeAttempt& attempt);

/// Returns the samples of fields that a search uses: none if every object can be rasterized at each point,
/// the surroundings in scenes of many objects or with Occlusion::fields. The result does not depend on the
/// fields that are stored.
FieldExtent search_fields(const Scene& scene, Occlusion occlusion);

/// The smallest default vertex budget of a search. Few scenes need as many vertices for 1 %.
inline constexpr std::size_t search_vertices = 200000;

/// Returns the default vertex budget of a search: the largest of search_vertices, usual_vertex_budget, and
/// the number of vertices that the scene asks for with Entity::fine_vertices over all instances.
std::size_t search_budget(const Scene& scene, const SceneEntities& entities);

/// Returns the displayed points of a picture, with the colours of images.
///
/// shaded  a scene of these entities.
/// pixels  of the fine meshes, row by row from the top; none where no object is visible.
std::vector<DisplayedPoint> displayed_points(const SceneEntities& entities, const ShadedScene& shaded,
                                             std::span<const std::optional<MeshPoint>> pixels);

/// Returns points over the area of all surfaces, with the colours of images.
std::vector<DisplayedPoint> displayed_area(const SceneEntities& entities, const ShadedScene& shaded);

/// Returns the reason for which a search ended before its target, and a remedy.
std::string reason_of(SearchEnd end, std::size_t vertex_budget);

}  // namespace haarfield
