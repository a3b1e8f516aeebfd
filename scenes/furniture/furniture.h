#pragma once
/// The furniture of the shipped scenes.
///
/// Each piece stands on y = 0 (the room's floor lies there), centred on the origin in x and z; metres. Parts
/// are closed shells that face outwards and go some way into each other, as joints do; where one enters
/// another it has a ring of vertices, so that no triangle reaches from the light into the dark inside.

#include "fields/mesh/mesh.h"

namespace haarfield {

/// A dining table of 1.6 x 0.9 m, 0.75 m high, on four turned legs. Materials: "top", "wood".
Mesh table_mesh();

/// A chair with turned legs and a slatted back, which faces +z; 0.46 m to the top of its pad, 0.93 m
/// to that of its back. Materials: "wood", "seat".
Mesh chair_mesh();

/// A room of 4.6 x 3.8 m, 2.5 m high, within walls of 0.15 m, its floor on y = 0. All light comes through a
/// window of 1.4 x 1.2 m in the wall at +x, with a frame and a mullion. Materials: "floor", "ceiling", "left"
/// (at -z), "right" (at +z), "wall" (all other sides), "frame".
Mesh room_mesh();

/// A square of 6 x 6 m, two triangles, which faces up. Material: "floor".
Mesh floor_mesh();

/// A floor of some 8 x 8 m in herringbone, which faces up: blocks of 0.78 x 0.156 m at 45 degrees to the axes,
/// in squares, so that no edge ends within another. Materials: "light", "medium", "dark", at random.
Mesh parquet_mesh();

}  // namespace haarfield
