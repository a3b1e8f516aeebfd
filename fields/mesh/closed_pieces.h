#pragma once
/// Closed pieces of a mesh: which enclose which, and to which side their triangles face.

#include "fields/mesh/mesh.h"

#include <span>

namespace haarfield {

/// The side on which the closed pieces of a mesh are visible.
enum class ClosedFaces : std::uint8_t {
    outwards,  ///< Every closed piece is a solid: its triangles face outwards.
    /// Closed pieces face as in their file: a room inwards, its furniture outwards. If none faces inwards in
    /// the file, the pieces that no other closed piece encloses are flipped inwards.
    inwards,
};

/// A piece whose triangles are consistently oriented and traverse every edge equally often in both
/// directions.
struct ClosedPiece {
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Facing outwards.
    Bounds bounds;
    bool faces_inwards = false;  ///< Orientation in the file.
};

/// Returns the winding number of a piece's surface around a point: 1 inside an outward-facing simple piece, 0
/// outside.
///
/// accuracy  1e-6, except within about 1e-6 sizes of the surface.
/// cost      O(triangles).
/// source    van Oosterom and Strackee 1983: the solid angle of a triangle.
double winding_number(std::span<const Vec3f> positions,
                      std::span<const std::array<std::uint32_t, 3>> triangles, const Vec3d& point);

/// Tests whether one box lies within another; boxes may touch.
bool contains(const Bounds& outer, const Bounds& inner);

/// Returns one flag per piece: 1 if it faces inwards as defined by ClosedFaces::inwards.
///
/// limits  only the 64 largest pieces can face inwards.
std::vector<std::uint8_t> inward_pieces(std::span<const Vec3f> positions,
                                        std::span<const ClosedPiece> pieces);

/// Finds the rooms of a mesh, largest first: closed pieces that face inwards in the file and
///  - enclose another closed piece or one of the points; or
///  - lie in a closed piece that faces outwards, so that there is a wall between the two; or
///  - are as large as the mesh, with every triangle visible from the middle, or with vertical walls between a
///    level floor and a level ceiling: empty rooms.
/// Any other piece that faces inwards is considered a solid that is inside out by mistake.
///
/// contents  points of objects, lights and cameras that a room may enclose, in the frame of the mesh.
/// up        in the frame of the mesh; unit length.
/// limits    the 64 largest pieces can be rooms.
std::vector<std::size_t> rooms(std::span<const Vec3f> positions, std::span<const ClosedPiece> pieces,
                               std::span<const Vec3f> contents, const Vec3d& up = {0, 1, 0});

/// The way in which a triangle blocks light.
enum class PieceKind : std::uint8_t {
    open,  ///< The piece has an edge that is not shared by exactly two consistently oriented triangles.
    /// The piece is closed and faces outwards, or is a cavity: it faces inwards, within a piece that faces
    /// outwards.
    solid,
    room,  ///< Any other closed piece: a wall without thickness.
};

/// Returns the kind of each triangle. Pieces are connected by shared edges.
///
/// triangles  equal positions must have one index.
/// limits     only the 64 largest inward-facing pieces can be cavities.
std::vector<PieceKind> piece_kinds(std::span<const Vec3f> positions,
                                   const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace haarfield
