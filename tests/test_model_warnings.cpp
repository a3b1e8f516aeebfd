#include "scenes/model_warnings.h"

#include <gtest/gtest.h>

namespace haarfield {
namespace {

MeshFindings open_edges(std::uint64_t edges) {
    MeshFindings findings;
    findings.components = findings.open_components = 1;
    findings.boundary_edges = edges;
    return findings;
}

TEST(ModelWarnings, OneLinePerFileWithCountsAndNamesOfParts) {
    ModelWarnings warnings;
    for (const char* part : {"wing", "tail", "door", "wheel", "seat"})
        warnings.add_findings("plane.glb", part, open_edges(3));
    warnings.add_findings("plane.glb", "wing", open_edges(3));  // of a different shape
    warnings.add_findings("plane.glb", "screw", MeshFindings());
    warnings.add_findings("box.obj", "", open_edges(4));
    EXPECT_EQ(
        warnings.lines(),
        (std::vector<std::string>{
            "plane.glb: 15 open edges in 5 of 5 pieces in 5 parts: \"wing\", \"tail\", \"door\" and 2 more",
            "box.obj: 4 open edges in its only piece"}));
}

TEST(ModelWarnings, MaterialsAndImagesAreNamedOnce) {
    ModelWarnings warnings;
    for (int part = 0; part < 3; ++part) {
        warnings.add_unused("a.glb", {{"normal map", {"brass", "oak"}}, {"sheen", {"silk"}}});
        warnings.add_missing_image("a.glb", "oak.png");
        warnings.add_unmapped_image("a.glb", "silk.png");
    }
    EXPECT_EQ(
        warnings.lines(),
        (std::vector<std::string>{
            "a.glb: image \"oak.png\" not found next to the file or below; left out",
            "a.glb: no texture coordinates for image \"silk.png\"; left out",
            "a.glb: not used: normal map of 2 materials: \"brass\", \"oak\", sheen of material \"silk\""}));
}

}  // namespace
}  // namespace haarfield
