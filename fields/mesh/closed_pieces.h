#pragma once
/// Closed pieces of a mesh: which enclose which, and which way their triangles face.

#include "fields/mesh/mesh.h"

#include <span>

namespace haarfield {

/// The side on which the closed pieces of a mesh are visible.
enum class ClosedFaces : std::uint8_t {
    outwards,  ///< Every closed piece is a solid: its triangles face outwards.
    /// Closed pieces face as their file has them: a room inwards, its furniture outwards. If none faces
    /// inwards in the file, those that no other closed piece encloses are turned inwards.
    inwards,
};

/// A piece whose triangles agree and traverse every edge as often in one direction as in the other.
struct ClosedPiece {
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Facing outwards.
    Bounds bounds;
    bool faces_inwards = false;  ///< In the file.
};

/// The winding number of a piece's surface around a point: 1 inside of an outward-facing simple piece, 0
/// outside.
///
/// accuracy  1e-6, but within some 1e-6 sizes of the surface.
/// cost      O(triangles).
/// source    van Oosterom and Strackee 1983: the solid angle of a triangle.
double winding_number(std::span<const Vec3f> positions,
                      std::span<const std::array<std::uint32_t, 3>> triangles, const Vec3d& point);

/// Tests whether one box lies within another; boxes may touch.
bool contains(const Bounds& outer, const Bounds& inner);

/// By piece: 1 if it faces inwards, as ClosedFaces::inwards defines it.
///
/// limits  the 64 largest pieces can face inwards.
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
    open,   ///< Of a piece with an edge that is not shared by exactly two triangles that agree.
    solid,  ///< Of a closed piece that faces outwards, or inwards within one that faces outwards: its cavity.
    room,   ///< Of any other closed piece: a wall without thickness.
};

/// By triangle. Pieces are connected by shared edges.
///
/// triangles  equal positions have one index.
/// limits     the 64 largest pieces that face inwards can be cavities.
std::vector<PieceKind> piece_kinds(std::span<const Vec3f> positions,
                                   const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace haarfield
