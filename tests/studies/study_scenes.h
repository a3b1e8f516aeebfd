#pragma once
/// Generated scenes for measurements.

#include "scenes/scene.h"

namespace haarfield::baseline {

/// Returns chairs of the shipped scene in rows and columns on a floor of 40 m.
///
/// turned  rotate each by a random angle about the vertical, some also slightly about another axis, and scale
///         it by 0.7 to 1.3.
Scene crowd(const Scene& shipped, int rows, int columns, bool turned);

/// Returns a model of about 70,000 triangles with the bumps of a scan, on a floor of 3 m. Models are written
/// to the folder.
Scene scanned_model(const std::filesystem::path& folder);

/// Returns a model of 39 parts with about 30,000 triangles on a floor of 6 m, each part an entity.
Scene model_of_parts(const std::filesystem::path& folder);

/// Returns a model of 231 intersecting pieces with about 100,000 triangles, one entity, on a floor of 6 m.
Scene model_of_pieces(const std::filesystem::path& folder);

/// Returns 2,000 square cards in all directions, one entity, on a floor of 4 m.
Scene leaf_cards(const std::filesystem::path& folder);

}  // namespace haarfield::baseline
