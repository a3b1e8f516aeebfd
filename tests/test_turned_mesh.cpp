#include "fields/mesh/turned_mesh.h"

#include <gtest/gtest.h>

#include "tests/fixtures/example_meshes.h"

namespace haarfield {
namespace {

TEST(TurnedMesh, TurnsAllPartsAndTheirNormals) {
    const PreparedMesh box = prepared_as_is(box_mesh({0, 0, 0}, {1, 2, 3}));
    const PreparedMesh turned = turned_mesh(box, {0, float(pi / 2), 0});
    for (const auto& [before, after] :
         {std::pair(&box.original, &turned.original), std::pair(&box.fine, &turned.fine),
          std::pair(&box.coarse, &turned.coarse)}) {
        const Bounds bounds = mesh_bounds(*after);
        EXPECT_NEAR(bounds.upper.x, 3, 1e-6);
        EXPECT_NEAR(bounds.upper.y, 2, 1e-6);
        EXPECT_NEAR(bounds.lower.z, -1, 1e-6);
        EXPECT_EQ(before->triangles, after->triangles);
        for (std::size_t v = 0; v < after->normals.size(); ++v) {
            EXPECT_NEAR(after->normals[v].x, before->normals[v].z, 1e-6);
            EXPECT_NEAR(after->normals[v].z, -before->normals[v].x, 1e-6);
        }
    }
    EXPECT_EQ(turned_mesh(box, {0, 0, 0}).fine.positions, box.fine.positions);
}

}  // namespace
}  // namespace haarfield
