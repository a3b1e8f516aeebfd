#pragma once
/// The furniture of the shipped scenes. [m]
///
/// Each piece stands on y = 0, the room's floor, and is centred on the origin in x and z. Its components are
/// closed shells that face outwards and overlap slightly, as joints do. A component has a ring of vertices
/// where it enters another, so that no triangle extends from the lit surface into the other's interior.

#include "fields/mesh/mesh.h"

namespace haarfield {

/// A dining table of 1.6 x 0.9 m, 0.75 m high, on four turned legs. Materials: "top", "wood".
Mesh table_mesh();

/// A chair with turned legs and a slatted back, facing +z. The pad is 0.46 m high, the back 0.93 m.
/// Materials: "wood", "seat".
Mesh chair_mesh();

/// A room of 4.6 x 3.8 m, 2.5 m high, with walls of 0.15 m and its floor on y = 0. All light enters through a
/// window of 1.4 x 1.2 m in the wall at +x, with a frame and a mullion. Materials: "floor", "ceiling", "left"
/// (at -z), "right" (at +z), "wall" (all other sides), "frame".
Mesh room_mesh();

/// A square of 6 x 6 m, two triangles, facing up. Material: "floor".
Mesh floor_mesh();

/// A herringbone floor of about 8 x 8 m that faces up: blocks of 0.78 x 0.156 m at 45 degrees to the axes, in
/// squares, so that no edge ends within another. Materials: "light", "medium", "dark", at random.
Mesh parquet_mesh();

}  // namespace haarfield
