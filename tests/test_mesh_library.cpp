#include "fields/field/mesh_library.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fields/field/library_files.h"
#include "scenes/scene_entities.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

/// Returns a sphere on a sheet: it has a coarse mesh, coarser ones, backs and findings.
ImportedMesh sphere_on_sheet() {
    ImportedMesh imported;
    imported.mesh = joined_meshes(sphere_mesh({0, 1, 0}, 0.5f, 70), upright_square_mesh(1, 3));
    imported.mesh.uvs.assign(imported.mesh.positions.size(), {0.25f, 0.5f});
    imported.findings.polygons = 7;
    return imported;
}

constexpr MeshPreparation wanted{.fine_vertices = 7000, .coarse_triangles = 2000};

void expect_same(const Mesh& a, const Mesh& b) {
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_EQ(a.vertex_materials, b.vertex_materials);
    EXPECT_EQ(a.material_names, b.material_names);
    EXPECT_EQ(a.uvs, b.uvs);
    EXPECT_EQ(a.colours, b.colours);
    EXPECT_EQ(a.original_vertices, b.original_vertices);
}

TEST(MeshLibrary, ReturnsTheMeshThatWasAdded) {
    const TestFolder folder;
    const ContentHash key = preparation_key(sphere_on_sheet(), wanted);
    EXPECT_FALSE(find_library_mesh(folder.path(), key));
    const PreparedMesh mesh = *prepare_mesh(sphere_on_sheet(), wanted);
    const EntityOcclusion occlusion(mesh);
    ASSERT_TRUE(add_library_mesh(folder.path(), "sphere", key, mesh, occlusion));

    const auto found = find_library_mesh(folder.path(), key);
    ASSERT_TRUE(found);
    expect_same(found->mesh.original, mesh.original);
    expect_same(found->mesh.backs, mesh.backs);
    expect_same(found->mesh.fine, mesh.fine);
    expect_same(found->mesh.coarse, mesh.coarse);
    EXPECT_EQ(found->mesh.findings.summary(), mesh.findings.summary());
    EXPECT_FALSE(found->mesh.opaque);
    EXPECT_EQ(found->occlusion.samples->points, occlusion.samples().points);
    EXPECT_EQ(found->occlusion.samples->buried, occlusion.samples().buried);
    ASSERT_GE(occlusion.coarser().size(), 1u);
    ASSERT_EQ(found->occlusion.coarser->size(), occlusion.coarser().size());
    expect_same((*found->occlusion.coarser)[0].mesh, occlusion.coarser()[0].mesh);
    EXPECT_EQ((*found->occlusion.coarser)[0].distance, occlusion.coarser()[0].distance);
    EXPECT_EQ(*read_library_mesh_entity(folder / folder.files()[0]), "sphere");
}

TEST(MeshLibrary, TheKeyDependsOnMeshAndPreparation) {
    const auto key = [](const auto& change) {
        ImportedMesh imported = sphere_on_sheet();
        MeshPreparation preparation = wanted;
        change(imported, preparation);
        return preparation_key(imported, preparation).hex();
    };
    const std::string same = key([](ImportedMesh&, MeshPreparation&) {});
    EXPECT_EQ(key([](ImportedMesh&, MeshPreparation&) {}), same);
    EXPECT_NE(key([](ImportedMesh& mesh, MeshPreparation&) { mesh.mesh.positions[9].y += 1e-3f; }), same);
    EXPECT_NE(key([](ImportedMesh& mesh, MeshPreparation&) { mesh.mesh.uvs[9].x = 0; }), same);
    EXPECT_NE(key([](ImportedMesh& mesh, MeshPreparation&) { mesh.findings.polygons = 8; }), same);
    EXPECT_NE(key([](ImportedMesh&, MeshPreparation& to) { to.fine_vertices = 7001; }), same);
    EXPECT_NE(key([](ImportedMesh&, MeshPreparation& to) { to.coarse_triangles = chosen_by_distance; }),
              same);
    EXPECT_NE(key([](ImportedMesh&, MeshPreparation& to) { to.faces = ClosedFaces::inwards; }), same);
    EXPECT_NE(key([](ImportedMesh&, MeshPreparation& to) { to.split_crossed = false; }), same);
    EXPECT_NE(key([](ImportedMesh&, MeshPreparation& to) { to.opacity.push_back({1, 1, {0}}); }), same);
}

TEST(MeshLibrary, DamagedFilesAreMissing) {
    const TestFolder folder;
    const ContentHash key = preparation_key(sphere_on_sheet(), wanted);
    PreparedMesh mesh = *prepare_mesh(sphere_on_sheet(), wanted);
    const EntityOcclusion occlusion(mesh);
    ASSERT_TRUE(add_library_mesh(folder.path(), "sphere", key, mesh, occlusion));
    const std::filesystem::path file = folder / folder.files()[0];
    const std::string bytes = text_of(file);
    for (const std::size_t at : {bytes.size() / 3, bytes.size() - 20}) {
        std::string changed = bytes;
        changed[at] = char(changed[at] ^ 4);
        write_text(file, changed);
        EXPECT_FALSE(find_library_mesh(folder.path(), key)) << at;
    }
    write_text(file, bytes.substr(0, bytes.size() / 2));
    EXPECT_FALSE(find_library_mesh(folder.path(), key));

    // The checksum of these files is correct.
    mesh.fine.triangles[5][1] = static_cast<std::uint32_t>(mesh.fine.positions.size());
    ASSERT_TRUE(add_library_mesh(folder.path(), "sphere", key, mesh, occlusion));
    EXPECT_FALSE(find_library_mesh(folder.path(), key)) << "an index out of range";
    mesh.fine.triangles[5][1] = 0;
    mesh.fine.vertex_materials[3] = 7;
    ASSERT_TRUE(add_library_mesh(folder.path(), "sphere", key, mesh, occlusion));
    EXPECT_FALSE(find_library_mesh(folder.path(), key)) << "no such material";
    mesh.fine.vertex_materials[3] = 0;
    mesh.coarse.positions[0].x = INFINITY;
    ASSERT_TRUE(add_library_mesh(folder.path(), "sphere", key, mesh, occlusion));
    EXPECT_FALSE(find_library_mesh(folder.path(), key)) << "an infinite position";
}

TEST(MeshLibrary, ScenesUseIt) {
    const TestFolder folder;
    std::string text;
    const Mesh sphere = sphere_mesh({0, 1, 0}, 0.5f, 30);
    for (const Vec3f& p : sphere.positions) text += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
    for (const auto& [a, b, c] : sphere.triangles) text += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
    write_text(folder / "sphere.obj", text);
    Scene scene;
    Entity& entity = scene.entities.emplace_back();
    entity.name = "sphere";
    entity.mesh = folder / "sphere.obj";
    entity.fine_vertices = 2000;
    entity.planar_samples = entity.spherical_samples = 50;
    scene.instances.push_back({"sphere", 0, {}});
    SceneEntityOptions options;
    options.fields_folder = folder / "fields";
    options.face_size = 16;
    const auto made = prepare_scene_entities(scene, options);
    ASSERT_TRUE(made) << made.error().message();
    const std::vector<std::string> files = folder.files();
    const auto stored = std::ranges::find_if(files, [](auto& name) { return name.ends_with(mesh_ending); });
    ASSERT_NE(stored, files.end());
    // Change a finding, to see that the next scene gets the file's mesh.
    LibraryMesh changed = *read_library_mesh(folder / *stored);
    changed.mesh.findings.polygons = 99;
    const std::uint64_t key =
        std::stoull(stored->substr(stored->size() - mesh_ending.size() - 16, 16), nullptr, 16);
    ASSERT_TRUE(add_library_mesh(options.fields_folder, "sphere", {0, key}, changed.mesh,
                                 EntityOcclusion(changed.mesh, changed.occlusion)));
    EXPECT_EQ(folder.files(), files);
    const auto found = prepare_scene_entities(scene, options);
    ASSERT_TRUE(found) << found.error().message();
    EXPECT_TRUE(found->entities[0]->reused);
    EXPECT_EQ(found->entities[0]->mesh.findings.polygons, 99u);
    expect_same(found->entities[0]->mesh.fine, made->entities[0]->mesh.fine);
    expect_same(found->entities[0]->mesh.coarse, made->entities[0]->mesh.coarse);
    EXPECT_EQ(found->entities[0]->occlusion->samples().points,
              made->entities[0]->occlusion->samples().points);
}

}  // namespace
}  // namespace haarfield
