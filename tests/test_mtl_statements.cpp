#include "fields/model/mtl_statements.h"

#include <gtest/gtest.h>

#include "fields/model/mesh_reader.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

TEST(MtlStatements, OnlyThoseBeforeTheFirstMaterialAreLeftOut) {
    EXPECT_EQ(without_leading_statements("map_Kd a.png\r\n  \tnewmtl b\nKd 1 1 1\n"),
              "            \r\n  \tnewmtl b\nKd 1 1 1\n");
    EXPECT_EQ(without_leading_statements("newmtl"), "newmtl");
    EXPECT_EQ(without_leading_statements("newmtl a\nKd 1 0 0\nnewmtl b\n"), "newmtl a\nKd 1 0 0\nnewmtl b\n");
    EXPECT_EQ(without_leading_statements("# newmtl a\nnewmtls\nKd newmtl\n"),
              "          \n       \n         \n");
    EXPECT_EQ(without_leading_statements(""), "");
}

/// assimp 5.2 crashes on some of these statements.
TEST(MtlStatements, AnObjFileIsReadWhateverPrecedesTheFirstMaterial) {
    const TestFolder folder;
    write_text(folder / "model.obj", "mtllib model.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
    for (const char* statement : {"map_Kd a.png",
                                  "map_Ks a.png",
                                  "map_d a.png",
                                  "map_bump -bm 2 a.png",
                                  "bump a.png",
                                  "norm a.png",
                                  "refl a.png",
                                  "disp a.png",
                                  "Kd 1 2 3",
                                  "Ks 1",
                                  "Ka x",
                                  "Ke 1 1 1",
                                  "d 0.5",
                                  "Tr 1",
                                  "Ns 10",
                                  "Ni 1",
                                  "illum 2",
                                  "Tf 1 1 1",
                                  "Pr 1",
                                  "Pm 1",
                                  "aniso 1",
                                  "-s map_Kd 2 0 -o 1 a.png",
                                  "nonsense",
                                  "new",
                                  ""})
        for (const std::string& materials : {std::string("newmtl red\nKd 0.5 0 0\n"), std::string()}) {
            write_text(folder / "model.mtl", statement + ("\n" + materials));
            const Result<ImportedMesh> read = read_mesh(folder / "model.obj");
            ASSERT_TRUE(read) << statement << ": " << read.error().message();
            ASSERT_EQ(read->mesh.material_names.size(), 1u) << statement;
            if (!materials.empty()) {
                EXPECT_EQ(read->materials[0].diffuse, Rgb(0.5f, 0, 0)) << statement;
            }
        }
}

}  // namespace
}  // namespace haarfield
