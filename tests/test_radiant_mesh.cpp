#include "shading/bake/radiant_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/fixtures/lit_box.h"

namespace haarfield {
namespace {

TEST(RadiantMesh, HasAtAFineMeshTheRadianceOfItsVertices) {
    const LitBox lit;
    const std::vector<Mesh> fine{lit.example.mesh(LitBox::floor).fine, lit.example.mesh(LitBox::box).fine};
    const auto found = *mesh_radiance(lit.shading, fine);
    const auto expected = total(*scene_radiance({lit.example.scene, lit.geometry, lit.light, lit.settings}));
    const auto& buried = lit.example.scene.entities[LitBox::box].occlusion->samples().buried;
    EXPECT_GT(std::count(buried.begin(), buried.end(), 1), 4);
    for (std::size_t i = 0; i < found.size(); ++i) {
        ASSERT_EQ(found[i].radiance.size(), expected[i].size());
        for (std::size_t v = 0; v < expected[i].size(); ++v)
            // The field rounds wavelets of visibility to 1/254.
            EXPECT_NEAR(found[i].radiance[v].total().x, expected[i][v].x, 0.01 * expected[i][v].x + 0.003)
                << i << ", " << v;
    }
}

}  // namespace
}  // namespace haarfield
