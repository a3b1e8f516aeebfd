#pragma once
/// Transparent objects as filters of light: their parts with the fractions of light that pass each surface.

#include "bridge/povray_import/object_surfaces.h"

namespace haarfield {

/// A part of a transparent object, such as the wine in a glass.
struct FilterPart {
    ObjectSurface surface;  ///< Its colours are the filters at the vertices if `vertex_colours`, else unused.
    Rgb filter{1.0f};       ///< Fraction of light that passes each surface; with vertex colours: white.
    Rgb absorption{0.0f};   ///< Coefficient inside, per unit of the scene.
    bool vertex_colours = false;
};

/// Divides transparent objects into parts whose surfaces filter light equally.
///
/// Surfaces inside an object, such as those between glass and wine in a union, belong to the parts. Each part
/// is closed. If more than a tenth of the grid's lines cross it an odd number of times, it is a sheet. If an
/// object's filter varies in more than six colours, the object is one part with vertex colours.
///
/// requests  grids of the objects, sorted by object.
/// measured  the same objects with their filters and absorption, by add_pigments.
/// errors    those of SceneQueries::answer.
/// cost      as object_surfaces and two runs of POV-Ray; for objects of several parts, four further runs and
///           5 us per crossing.
Result<std::vector<FilterPart>> filter_parts(const SceneQueries& queries,
                                             std::span<const GridRequest> requests,
                                             std::span<const ObjectSurface> measured, double object_seconds,
                                             const Progress& progress = {});

}  // namespace haarfield
