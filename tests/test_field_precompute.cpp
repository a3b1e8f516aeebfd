#include "fields/field/field_precompute.h"

#include <gtest/gtest.h>

#include "fields/field/entity_occlusion.h"
#include "fields/wavelets/haar_transform.h"
#include "scenes/furniture/furniture.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/field_fixtures.h"
#include "tests/fixtures/unpacked_face.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

VisibilityField field_of(const Mesh& mesh, const FieldSettings& settings) {
    const PreparedMesh prepared = prepared_as_is(mesh);
    return *precompute_field("example", prepared, EntityOcclusion(prepared), settings);
}

/// Returns the unoccluded fraction of the upper half of a local sample: the mean of the face +y.
float openness_above(const VisibilityField& field, std::size_t vertex) {
    const auto handle = static_cast<std::size_t>(field.local_handles[vertex]);
    return unpacked_face(field.pool, field.pool.cubemaps[handle][2]).scaling;
}

TEST(FieldPrecompute, DoesNotDependOnTheNumberOfThreads) {
    const Mesh mesh =
        joined_meshes(box_mesh({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f}, 3), sphere_mesh({0, 1.2f, 0}, 0.4f, 10));
    const FieldSettings settings{16, 20, 0, 300, 300};
    const VisibilityField wanted = field_of(mesh, settings);
    for (const std::size_t threads : {1u, 2u, 8u}) {
        const VisibilityField field = with_threads(threads, [&] { return field_of(mesh, settings); });
        EXPECT_EQ(field.pool.node_bytes, wanted.pool.node_bytes);
        EXPECT_EQ(field.pool.faces, wanted.pool.faces);
        EXPECT_EQ(field.pool.cubemaps, wanted.pool.cubemaps);
        EXPECT_EQ(field.local_handles, wanted.local_handles);
        EXPECT_EQ(field.planar_handles, wanted.planar_handles);
    }
}

TEST(FieldPrecompute, LocalFieldOfAFloorIsAHandfulOfNodes) {
    const VisibilityField field = field_of(square_mesh(6, 0, 60), {64, 70, 0, 6, 18});
    EXPECT_EQ(field.local_handles.size(), 61u * 61u);
    for (const std::int32_t handle : field.local_handles) EXPECT_EQ(handle, field.local_handles[0]);
    for (const std::uint32_t face : field.pool.cubemaps[std::size_t(field.local_handles[0])])
        EXPECT_EQ(field.pool.faces[face].node_count, 0);
}

TEST(FieldPrecompute, ConvexShapesDoNotShadowThemselves) {
    const Mesh sphere = sphere_mesh({0, 1, 0}, 0.5f, 24);
    const VisibilityField field = field_of(sphere, {32, 0, 0, 6, 18});
    EXPECT_EQ(openness_above(field, 0), 1);
    for (std::size_t v = 0; v < sphere.positions.size(); ++v) {
        if (sphere.normals[v].y < 0.99f) continue;
        EXPECT_EQ(openness_above(field, v), 1) << v;
    }
}

TEST(FieldPrecompute, ContactsAndCreasesDoNotLeak) {
    // A pillar that stands on a slab and extends into it. At the foot of the pillar, the slab occludes the
    // lower half. On the slab next to the pillar, the pillar occludes a quarter of the sphere.
    const Mesh slab = box_mesh({-1, -0.2f, -1}, {1, 0, 1}, 16);
    const Mesh pillar = box_mesh({-0.25f, 0, -0.25f}, {0.25f, 2, 0.25f}, 4);
    const Mesh mesh = joined_meshes(slab, pillar);
    const VisibilityField field = field_of(mesh, {32, 0, 0, 6, 18});
    int at_foot = 0, beside = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3f p = mesh.positions[v], n = mesh.normals[v];
        const auto handle = static_cast<std::size_t>(field.local_handles[v]);
        // Mean visibility over the part of a face above the vertex's horizon.
        const auto seen = [&](int face) {
            const auto texels = quadtree_texels(
                unpacked_face(field.pool, field.pool.cubemaps[handle][static_cast<std::size_t>(face)]), 32);
            double sum = 0, count = 0;
            for (int t = 0; t < 1024; ++t) {
                if (texel_direction(face, t % 32, t / 32, 32).dot(n) <= 0) continue;
                sum += texels[static_cast<std::size_t>(t)];
                ++count;
            }
            return sum / count;
        };
        if (v >= slab.positions.size() && p.y == 0 && n.x > 0.5f && std::abs(p.z) < 0.2f) {
            EXPECT_NEAR(seen(3), 0, 0.05) << "the slab below the pillar's foot at " << p;
            EXPECT_NEAR(seen(2), 1, 0.05) << "the sky above the pillar's foot at " << p;
            ++at_foot;
        }
        if (v < slab.positions.size() && n.y > 0.5f && std::abs(p.x - 0.25f) < 1e-5f &&
            std::abs(p.z) < 0.2f) {
            EXPECT_NEAR(seen(1), 0, 0.05) << "the pillar next to the slab at " << p;
            EXPECT_NEAR(seen(0), 1, 0.05) << "the sky in front of the pillar at " << p;
            ++beside;
        }
    }
    EXPECT_GT(at_foot, 0);
    EXPECT_GT(beside, 0);
}

TEST(LocalSamples, FindsVerticesBuriedInAnotherPiece) {
    const Mesh outer = box_mesh({-1, 0, -1}, {1, 1, 1}, 2),
               inner = box_mesh({-0.2f, 0.2f, -0.2f}, {0.2f, 0.8f, 0.2f}, 1),
               through = box_mesh({-0.1f, 0.5f, -0.1f}, {0.1f, 2, 0.1f}, 6);
    const PreparedMesh mesh = prepared_as_is(joined_meshes(joined_meshes(outer, inner), through));
    const LocalSamples samples = EntityOcclusion(mesh).samples();
    for (std::size_t v = 0; v < outer.positions.size(); ++v) EXPECT_FALSE(samples.buried[v]);
    for (std::size_t v = outer.positions.size(); v < outer.positions.size() + inner.positions.size(); ++v)
        EXPECT_TRUE(samples.buried[v]);
    for (std::size_t v = outer.positions.size() + inner.positions.size(); v < mesh.fine.positions.size();
         ++v) {
        const float y = mesh.fine.positions[v].y;
        if (y > 0.76f && y < 1.01f) continue;
        EXPECT_EQ(samples.buried[v] != 0, y < 1) << mesh.fine.positions[v];
    }
}

TEST(LocalSamples, OfATriangleThatEntersAnotherPieceLieWhereItComesOut) {
    // The lower corners of the pillar's sides are inside the block, and the sides emerge at its top, at y =
    // 1.
    const Mesh block = box_mesh({-1, 0, -1}, {1, 1, 1}, 4),
               pillar = box_mesh({-0.2f, 0.5f, -0.2f}, {0.2f, 3, 0.2f}, 1);
    const PreparedMesh mesh = prepared_as_is(joined_meshes(block, pillar));
    const EntityOcclusion occlusion(mesh);
    const LocalSamples& samples = occlusion.samples();
    int entering = 0;
    for (std::size_t v = block.positions.size(); v < mesh.fine.positions.size(); ++v) {
        if (mesh.fine.positions[v].y > 1 || mesh.fine.normals[v].y < -0.5f) continue;
        ASSERT_FALSE(samples.buried[v]);
        const Vec3f& sample = samples.points[v];
        EXPECT_GT(sample.y, 1) << v;
        EXPECT_LT(sample.y, 1.1f) << v;
        EXPECT_LT(std::abs((sample - mesh.fine.positions[v]).dot(mesh.fine.normals[v])), 0.001f) << v;
        ++entering;
    }
    EXPECT_EQ(entering, 8);
}

TEST(LocalSamples, OfTheShippedChairLieInNoneOfItsPieces) {
    ImportedMesh chair;
    chair.mesh = chair_mesh();
    const Result<PreparedMesh> mesh = prepare_mesh(std::move(chair), {12000, 0});
    ASSERT_TRUE(mesh) << mesh.error().message();
    const EntityOcclusion occlusion(*mesh);
    const LocalSamples& samples = occlusion.samples();
    std::size_t in_a_piece = 0;  // number of vertices
    for (std::size_t v = 0; v < mesh->fine.positions.size(); ++v) {
        if (samples.buried[v]) continue;
        in_a_piece += occlusion.in_original()(mesh->fine.positions[v]);
        EXPECT_FALSE(occlusion.in_original()(samples.points[v])) << mesh->fine.positions[v];
    }
    EXPECT_GT(in_a_piece, 50u);
}

TEST(LocalSamples, ASimplifiedOpenSurfaceDoesNotDarkenItsVertices) {
    // The coarse mesh covers the hollow of an open sheet, whose vertices would be dark below it.
    PreparedMesh mesh = prepared_as_is(square_mesh(2, 0, 8));
    for (Mesh* m : {&mesh.original, &mesh.fine})
        for (Vec3f& p : m->positions) p.y = 0.02f * (p.x * p.x + p.z * p.z);
    mesh.coarse = square_mesh(2, 0.04f);
    const EntityOcclusion occlusion(mesh);
    EXPECT_EQ(occlusion.own().triangles().size(), mesh.original.triangles.size());
    const VisibilityField field = *precompute_field("sheet", mesh, occlusion, {32, 0, 0, 6, 18});
    for (std::size_t v = 0; v < mesh.fine.positions.size(); ++v)
        EXPECT_GT(openness_above(field, v), 0.95f) << v;
    // A closed mesh is only viewed from outside, so the coarse one is sufficient.
    PreparedMesh box = prepared_as_is(box_mesh({0, 0, 0}, {1, 1, 1}, 4));
    box.coarse = box_mesh({0, 0, 0}, {1, 1, 1});
    EXPECT_EQ(EntityOcclusion(box).own().triangles().size(), 12u);
}

TEST(LocalSamples, SimplificationDoesNotOpenACreviceWhereItSavesLittle) {
    // A cushion a millimetre above a board. The simplified cushion is smaller and would leave the board's
    // vertices below its rim in the open.
    const auto seat = [](float half_cushion) {
        return joined_meshes(
            box_mesh({-1, 0, -1}, {1, 0.1f, 1}, 8),
            box_mesh({-half_cushion, 0.101f, -half_cushion}, {half_cushion, 0.2f, half_cushion}, 4));
    };
    PreparedMesh mesh = prepared_as_is(seat(0.55f));
    mesh.coarse = seat(0.45f);
    const EntityOcclusion occlusion(mesh);
    EXPECT_EQ(occlusion.own().positions(), occlusion.original().positions());
    const VisibilityField field = *precompute_field("seat", mesh, occlusion, {32, 0, 0, 6, 18});
    int below = 0;
    for (std::size_t v = 0; v < mesh.fine.positions.size(); ++v) {
        const Vec3f& p = mesh.fine.positions[v];
        if (p.y != 0.1f || mesh.fine.normals[v].y < 0.9f || std::abs(p.x) > 0.51f || std::abs(p.z) > 0.51f)
            continue;
        EXPECT_LT(openness_above(field, v), 0.05f) << p;
        ++below;
    }
    EXPECT_EQ(below, 25);
}

TEST(FieldKeys, ChangeWithMeshAndSettings) {
    const PreparedMesh mesh = prepared_as_is(box_mesh({0, 0, 0}, {1, 1, 1}));
    const FieldSettings settings;
    const FieldKeys keys = field_keys(mesh, settings);
    EXPECT_TRUE(field_keys(mesh, settings) == keys);
    PreparedMesh finer = mesh;
    finer.fine.triangles.pop_back();
    EXPECT_EQ(field_keys(finer, settings).surroundings, keys.surroundings)
        << "depends on the coarse mesh only";
    EXPECT_FALSE(field_keys(finer, settings).whole == keys.whole);
    PreparedMesh coarser = mesh;
    coarser.coarse.triangles.pop_back();
    PreparedMesh larger = mesh;
    larger.fine.positions[0].x += 1e-6f;  // the size of the samplers depends on the fine mesh
    for (const PreparedMesh* other : {&coarser, &larger}) {
        EXPECT_FALSE(field_keys(*other, settings).surroundings == keys.surroundings);
        EXPECT_FALSE(field_keys(*other, settings).whole == keys.whole);
    }
    for (const FieldSettings& other :
         {FieldSettings{32, 70, 0, 20000, 10000}, FieldSettings{64, 71, 0, 20000, 10000},
          FieldSettings{64, 70, 0.1f, 20000, 10000}, FieldSettings{64, 70, 0, 20001, 10000},
          FieldSettings{64, 70, 0, 20000, 10001}}) {
        EXPECT_FALSE(field_keys(mesh, other).surroundings == keys.surroundings);
        EXPECT_FALSE(field_keys(mesh, other).whole == keys.whole);
    }
    EXPECT_EQ(keys.whole.hex().size(), 32u);
}

TEST(FieldPrecompute, OfPartsIsBitIdenticalToTheUndividedField) {
    const PreparedMesh mesh = prepared_as_is(box_mesh({0, 0, 0}, {1, 1, 1}, 4));
    const EntityOcclusion occlusion(mesh);
    const FieldSettings settings{16, 0, 0.1f, 150, 150};
    const VisibilityField whole = *precompute_field("box", mesh, occlusion, settings);
    const std::uint64_t count = sample_count(mesh, settings);
    ASSERT_EQ(count,
              whole.planar_handles.size() + whole.spherical_handles.size() + whole.local_handles.size());
    for (const std::uint64_t parts : {1, 2, 7, 64}) {
        std::vector<SampleRun> runs;
        for (std::uint64_t part = 0; part < parts; ++part)
            if (parts != 7 || part % 3 != 1)  // unknown samples are computed
                runs.push_back(*field_samples("box", mesh, occlusion, settings, count * part / parts,
                                              count * (part + 1) / parts));
        const VisibilityField joined = *precompute_field("box", mesh, occlusion, settings, {}, {runs, {}});
        expect_same(joined, whole, std::to_string(parts) + " parts");
    }
}

TEST(FieldPrecompute, ReusesTheSurroundingsOfAnotherFineMesh) {
    const PreparedMesh mesh = prepared_as_is(box_mesh({0, 0, 0}, {1, 1, 1}, 4));
    PreparedMesh finer = mesh;
    finer.fine = box_mesh({0, 0, 0}, {1, 1, 1}, 7);
    const FieldSettings settings{16, 0, 0.1f, 150, 150};
    const SampleRun surroundings =
        surrounding_samples(*precompute_field("box", mesh, EntityOcclusion(mesh), settings));
    const EntityOcclusion occlusion(finer);
    const VisibilityField wanted = *precompute_field("box", finer, occlusion, settings);
    const VisibilityField field =
        *precompute_field("box", finer, occlusion, settings, {}, {{&surroundings, 1}, wanted.error});
    expect_same(field, wanted, "with known surroundings");
}

TEST(FieldPrecompute, ReportsSteadilyToTheEnd) {
    const PreparedMesh mesh = prepared_as_is(box_mesh({0, 0, 0}, {1, 1, 1}, 4));
    std::vector<std::uint64_t> reports;
    Progress progress;
    std::uint64_t whole = 0;
    progress.report = [&](std::string_view, std::uint64_t done, std::uint64_t total) {
        reports.push_back(done);
        whole = total;
    };
    const VisibilityField field =
        *precompute_field("box", mesh, EntityOcclusion(mesh), {16, 0, 0.1f, 1000, 1000}, progress);
    ASSERT_FALSE(reports.empty());
    EXPECT_EQ(whole,
              field.planar_handles.size() + field.spherical_handles.size() + field.local_handles.size());
    EXPECT_EQ(reports.back(), whole);
    std::uint64_t before = 0;
    for (const std::uint64_t done : reports) {
        EXPECT_GT(done, before);
        EXPECT_LE(done - before, 100u);
        before = done;
    }
}

TEST(FieldPrecompute, StopsInTheMiddle) {
    const PreparedMesh mesh = prepared_as_is(box_mesh({0, 0, 0}, {1, 1, 1}, 4));
    std::stop_source stop;
    std::uint64_t most = 0;
    Progress progress;
    progress.stop = stop.get_token();
    progress.report = [&](std::string_view, std::uint64_t done, std::uint64_t) {
        most = done;
        if (done > 500) stop.request_stop();
    };
    const auto field = precompute_field("box", mesh, EntityOcclusion(mesh), {}, progress);
    ASSERT_FALSE(field);
    EXPECT_EQ(field.error().code, ErrorCode::interrupted);
    EXPECT_LT(most, 1000u);
}

TEST(FieldPrecompute, StopsWhenAsked) {
    const PreparedMesh mesh = prepared_as_is(box_mesh({0, 0, 0}, {1, 1, 1}, 4));
    std::stop_source stop;
    stop.request_stop();
    const auto field = precompute_field("box", mesh, EntityOcclusion(mesh), {}, {{}, stop.get_token()});
    ASSERT_FALSE(field);
    EXPECT_EQ(field.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace haarfield
