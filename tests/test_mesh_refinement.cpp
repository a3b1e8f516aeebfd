#include "shading/bake/mesh_refinement.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "shading/bake/bounced_radiance.h"
#include "tests/fixtures/lit_box.h"
#include "tests/fixtures/mesh_measures.h"
#include "tests/fixtures/random_numbers.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

using Place = std::array<float, 3>;

Place place(const Vec3f& p) {
    return {p.x, p.y, p.z};
}

/// Returns the triangles at each edge between two places.
std::map<std::pair<Place, Place>, std::vector<std::uint32_t>> triangles_by_edge(const Mesh& mesh) {
    std::map<std::pair<Place, Place>, std::vector<std::uint32_t>> edges;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const Place a = place(mesh.positions[mesh.triangles[t][k]]),
                        b = place(mesh.positions[mesh.triangles[t][(k + 1) % 3]]);
            edges[std::minmax(a, b)].push_back(t);
        }
    return edges;
}

double channel_sum(const Outgoing& radiance) {
    const Rgb c = radiance.total();
    return double(c.x) + double(c.y) + double(c.z);
}

double rms_error_on_floor(const LitBox& lit, const RadiantMesh& floor) {
    std::mt19937 random(11);
    const auto across = [&] { return uniform(random, -1.9f, 1.9f); };
    std::vector<InstancePoint> points;
    for (int i = 0; i < 1500; ++i) {
        const Vec3f p{across(), 0, across()};
        points.push_back({LitBox::floor, {p, Vec3f(0, 1, 0), p + Vec3f(0, 1e-4f, 0), 0}});
    }
    const auto exact = *point_radiance(lit.shading, points);
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3f& p = points[i].point.position;
        sum += std::pow(channel_sum(radiance_on(floor, p.x, p.z)) - channel_sum(exact[i]), 2);
    }
    return std::sqrt(sum / double(points.size()));
}

TEST(MeshRefinement, HoldsItsToleranceInTheMiddleOfEveryLongestEdge) {
    const LitBox lit;
    const auto start = lit.radiant(10);
    double mean = 0, vertices = 0;
    for (const RadiantMesh& mesh : start) {
        for (const Outgoing& value : mesh.radiance) mean += channel_sum(value);
        vertices += double(mesh.radiance.size());
    }
    mean /= vertices;
    for (const float tolerance : {0.03f, 0.01f}) {
        const auto refined = *refined_radiance(lit.shading, {tolerance, 1000000}, start);
        EXPECT_LE(refined.largest_error, tolerance);
        EXPECT_GT(refined.rounds, 1);
        const RadiantMesh& floor = refined.meshes[LitBox::floor];
        EXPECT_GT(floor.radiance.size(), start[LitBox::floor].radiance.size());
        std::vector<InstancePoint> middles;
        std::vector<Outgoing> interpolated;
        for (std::uint32_t t = 0; t < floor.mesh.triangles.size(); ++t) {
            std::pair<float, std::size_t> longest{0, 0};
            for (std::size_t k = 0; k < 3; ++k)
                longest = std::max(longest, {(floor.mesh.positions[floor.mesh.triangles[t][(k + 1) % 3]] -
                                              floor.mesh.positions[floor.mesh.triangles[t][k]])
                                                 .length(),
                                             k});
            if (longest.first < 4e-3f) continue;  // too short to be split
            const std::uint32_t a = floor.mesh.triangles[t][longest.second],
                                b = floor.mesh.triangles[t][(longest.second + 1) % 3];
            const Vec3f middle = (floor.mesh.positions[a] + floor.mesh.positions[b]) * 0.5f;
            middles.push_back({LitBox::floor, {middle, Vec3f(0, 1, 0), middle + Vec3f(0, 2.8e-4f, 0), 0}});
            interpolated.push_back((floor.radiance[a] + floor.radiance[b]) * 0.5f);
        }
        const auto exact = *point_radiance(lit.shading, middles);
        // Edges of equal length, and the sample's position in the triangles, allow for a few exceptions.
        std::size_t beyond = 0;
        for (std::size_t i = 0; i < middles.size(); ++i)
            beyond += std::abs(channel_sum(exact[i]) - channel_sum(interpolated[i])) >
                      1.1 * tolerance * (channel_sum(interpolated[i]) + mean);
        EXPECT_LE(double(beyond), 0.01 * double(middles.size())) << "tolerance " << tolerance;
    }
}

/// Adds a lamp without extent, whose shadows have hard edges.
void add_hard_light(LitBox& lit) {
    Lamp lamp;
    lamp.position = {2, 3, 1.5f};
    lamp.colour = Rgb(3.0f);
    lit.example.scene.lamps = {lamp};
    lit.light = scene_light(lit.example.scene, lit.example.scene.environment, lit.settings, {});
}

TEST(MeshRefinement, CutsFollowHardShadowEdges) {
    LitBox lit;
    add_hard_light(lit);
    const std::vector<RadiantMesh> start = lit.radiant(24);
    const MeshRefiner refiner(lit.shading, {0.01f, 100000, false, true}, start);
    const DiscontinuityMeshes cut = *refiner.cut(100000);
    EXPECT_GT(cut.cut_edges(), 30u);
    EXPECT_LT(rms_error_on_floor(lit, cut.meshes()[LitBox::floor]),
              0.4 * rms_error_on_floor(lit, start[LitBox::floor]));

    std::size_t vertices = 0, before = 0;
    for (std::size_t i = 0; i < start.size(); ++i) {
        const RadiantMesh& mesh = cut.meshes()[i];
        vertices += mesh.radiance.size();
        before += start[i].radiance.size();
        EXPECT_NEAR(surface_area(mesh.mesh), surface_area(start[i].mesh), 1e-5 * surface_area(mesh.mesh));
        EXPECT_EQ(mesh.mesh.positions.size(), mesh.radiance.size());
        EXPECT_EQ(mesh.samples.points.size(), mesh.radiance.size());
        for (const auto& [edge, triangles] : triangles_by_edge(mesh.mesh)) {
            const auto& [a, b] = edge;
            const bool is_border = i == LitBox::floor && ((a[0] == b[0] && std::abs(a[0]) == 2) ||
                                                          (a[2] == b[2] && std::abs(a[2]) == 2));
            EXPECT_EQ(triangles.size(), is_border ? 1u : 2u);
        }
    }
    EXPECT_EQ(vertices, before + cut.added_vertices());
    EXPECT_LE(refiner.cut(before + 11)->added_vertices(), 11u);
    EXPECT_GE(refiner.cut(before + 11)->added_vertices(), 10u);

    std::mt19937 random(3);
    const Mesh &uncut = start[LitBox::floor].mesh, &parts = cut.meshes()[LitBox::floor].mesh;
    for (std::uint32_t t = 0; t < uncut.triangles.size(); ++t) {
        const float u = uniform(random, 0.01f, 0.49f), v = uniform(random, 0.01f, 0.49f);
        const std::array<float, 3> weights{1 - u - v, u, v};
        const auto found = cut.located(LitBox::floor, t, weights);
        Vec3f wanted(0.0f), there(0.0f);
        for (std::size_t k = 0; k < 3; ++k) {
            wanted += uncut.positions[uncut.triangles[t][k]] * weights[k];
            there += parts.positions[found.corners[k]] * found.weights[k];
            EXPECT_GE(found.weights[k], -1e-4f);
        }
        EXPECT_LT((wanted - there).length(), 1e-4f);
    }
}

TEST(MeshRefinement, CutsFirstTheEdgesThatAreLongInTheWorld) {
    LitBox lit;
    lit.example.scene.instances[LitBox::floor].placement.scale = 10;
    lit.geometry = *shading_geometry(lit.example.scene, lit.settings);
    add_hard_light(lit);
    // Edges of the floor are shorter than those of the box in the frames of their entities.
    const std::vector<RadiantMesh> start = lit.radiant(96);
    const MeshRefiner refiner(lit.shading, {0.01f, 100000, false, true}, start);
    const auto added_to = [&](std::size_t instance, const DiscontinuityMeshes& cut) {
        return cut.meshes()[instance].radiance.size() - start[instance].radiance.size();
    };
    EXPECT_GT(added_to(LitBox::box, *refiner.cut(100000)), 0u);
    const DiscontinuityMeshes few = *refiner.cut(refiner.vertices() + 11);
    EXPECT_GE(added_to(LitBox::floor, few), 10u);
    EXPECT_EQ(added_to(LitBox::box, few), 0u);
}

TEST(MeshRefinement, SmoothRadianceIsNotCut) {
    const LitBox lit;
    const MeshRefiner refiner(lit.shading, {0.01f, 100000, false, true}, lit.radiant(80));
    EXPECT_EQ(refiner.cut(100000)->cut_edges(), 0u);
    EXPECT_EQ(refiner.cut(100000, CutSearch::all)->cut_edges(), 0u);
}

TEST(MeshRefinement, SamplePointsAreThoseOfTheShading) {
    const LitBox lit;
    const Refinement refined = *refined_radiance(lit.shading, {0.05f, 3000}, lit.radiant(4));
    std::vector<SampledMesh> meshes;
    for (const RadiantMesh& mesh : refined.meshes) meshes.push_back({&mesh.mesh, &mesh.samples});
    const SceneColours again = total(*vertex_radiance(lit.shading, meshes, {}));
    std::size_t shaded = 0;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        ASSERT_EQ(meshes[i].samples->buried.size(), again[i].size());
        for (std::size_t v = 0; v < again[i].size(); ++v) {
            if (meshes[i].samples->buried[v]) continue;
            ++shaded;
            EXPECT_NEAR(again[i][v].x, refined.meshes[i].radiance[v].total().x, 1e-5f) << i << ", " << v;
        }
    }
    EXPECT_GT(shaded, 500u);
}

TEST(MeshRefinement, NeedsHalfOfTheVerticesOfAnEvenMesh) {
    const LitBox lit;
    const RadiantMesh even = lit.radiant(60)[LitBox::floor];
    const RadiantMesh refined =
        refined_radiance(lit.shading, {0.004f, 100000}, lit.radiant(12))->meshes[LitBox::floor];
    EXPECT_LT(2 * refined.radiance.size(), even.radiance.size());
    EXPECT_LT(rms_error_on_floor(lit, refined), rms_error_on_floor(lit, even));
}

TEST(MeshRefinement, SpendsItsBudgetAndNoMore) {
    const LitBox lit;
    const auto start = lit.radiant(6);
    const std::size_t begun = start[0].radiance.size() + start[1].radiance.size();
    for (const std::size_t budget : {begun / 2, begun, begun + 37, std::size_t(2000)}) {
        const auto refined = *refined_radiance(lit.shading, {1e-4f, budget}, start);
        std::size_t vertices = 0;
        for (const RadiantMesh& mesh : refined.meshes) {
            EXPECT_EQ(mesh.radiance.size(), mesh.mesh.positions.size());
            vertices += mesh.radiance.size();
        }
        EXPECT_LE(vertices, std::max(budget, begun));
        EXPECT_GE(vertices + 8, std::max(budget, begun));
    }
}

TEST(MeshRefinement, LeavesNoCracks) {
    const LitBox lit;
    const auto start = lit.radiant(6);
    const auto refined = *refined_radiance(lit.shading, {0.01f, 6000}, start);
    const Mesh &box = refined.meshes[LitBox::box].mesh, &floor = refined.meshes[LitBox::floor].mesh;
    ASSERT_GT(box.triangles.size(), 2 * start[LitBox::box].mesh.triangles.size());
    for (const auto& [edge, triangles] : triangles_by_edge(box)) EXPECT_EQ(triangles.size(), 2u);
    for (const auto& [edge, triangles] : triangles_by_edge(floor)) {
        const bool is_border = (edge.first[0] == edge.second[0] && std::abs(edge.first[0]) == 2) ||
                               (edge.first[2] == edge.second[2] && std::abs(edge.first[2]) == 2);
        EXPECT_EQ(triangles.size(), is_border ? 1u : 2u);
    }
    EXPECT_NEAR(surface_area(box) / surface_area(start[LitBox::box].mesh), 1, 1e-5);
    EXPECT_NEAR(surface_area(floor), 16, 1e-4);
    for (const RadiantMesh& mesh : refined.meshes)
        for (const auto& triangle : mesh.mesh.triangles) {
            double longest = 0;
            for (std::size_t k = 0; k < 3; ++k)
                longest = std::max(longest, double((mesh.mesh.positions[triangle[k]] -
                                                    mesh.mesh.positions[triangle[(k + 1) % 3]])
                                                       .length()));
            const double twice_area =
                (mesh.mesh.positions[triangle[1]] - mesh.mesh.positions[triangle[0]])
                    .cross(mesh.mesh.positions[triangle[2]] - mesh.mesh.positions[triangle[0]])
                    .length();
            EXPECT_GT(twice_area / (longest * longest), 0.15);  // half of the smallest at the start
        }
}

TEST(MeshRefinement, LocatesPointsOfTheStart) {
    const LitBox lit;
    const std::vector<RadiantMesh> start = lit.radiant(6);
    MeshRefiner refiner(lit.shading, {0.005f, 4000}, start);
    while (*refiner.step()) continue;
    std::mt19937 random(5);
    std::vector<MeshPoint> points;
    for (std::uint32_t k = 0; k < 500; ++k) {
        const std::uint32_t i = k % 2;
        const float u = uniform(random, 0.0f, 1.0f), v = uniform(random, 0.0f, 1 - u);
        points.push_back({i, k % std::uint32_t(start[i].mesh.triangles.size()), u, v});
    }
    std::vector<MeshRefiner::Located> located;
    for (const MeshPoint& point : points) located.push_back(refiner.located(point));
    const Refinement refined = std::move(refiner).finished();
    std::size_t moved = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Mesh &before = start[points[k].instance].mesh, &after = refined.meshes[points[k].instance].mesh;
        Vec3f at(0.0f), found(0.0f);
        for (std::size_t c = 0; c < 3; ++c) {
            at += before.positions[before.triangles[points[k].triangle][c]] * points[k].weights()[c];
            found += after.positions[located[k].corners[c]] * located[k].weights[c];
            EXPECT_GE(located[k].weights[c], -1e-6f);
        }
        EXPECT_LT((at - found).length(), 1e-6f) << "point " << k;
        moved += located[k].corners != before.triangles[points[k].triangle];
        EXPECT_GE(located[k].difference, 0.0f);
    }
    EXPECT_GT(moved, 100u);
}

TEST(MeshRefinement, ForetellsDifferencesBeforeEdgesAreShaded) {
    const LitBox lit;
    const std::vector<RadiantMesh> start = lit.radiant(6);
    const MeshRefiner refiner(lit.shading, {0.005f, 4000}, start);
    const RadiantMesh& floor = start[LitBox::floor];
    for (std::uint32_t t = 0; t < floor.mesh.triangles.size(); ++t) {
        const auto& corners = floor.mesh.triangles[t];
        float largest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Rgb along =
                floor.radiance[corners[k]].total() - floor.radiance[corners[(k + 1) % 3]].total();
            largest = std::max(largest, std::abs(along.x) + std::abs(along.y) + std::abs(along.z));
        }
        EXPECT_NEAR(refiner.located({LitBox::floor, t, 0.3f, 0.3f}).difference, largest / 4, 1e-5f);
    }
}

TEST(MeshRefinement, SplitsFewerEdgesOutsideOfThePicture) {
    const LitBox lit;
    const std::vector<RadiantMesh> start = lit.radiant(6);
    // The box is in the middle of the floor: both halves have the same amount of shadow edges, roughly.
    const auto share_with = [&](bool right_is_visible) {
        VertexMask visible;
        for (const RadiantMesh& mesh : start) visible.emplace_back(mesh.radiance.size(), true);
        for (std::size_t v = 0; v < visible[LitBox::floor].size(); ++v)
            visible[LitBox::floor][v] = (start[LitBox::floor].mesh.positions[v].x > 0) == right_is_visible;
        MeshRefiner refiner(lit.shading, {0.002f, 2000}, start, visible);
        while (*refiner.step()) continue;
        const Refinement refined = std::move(refiner).finished();
        const std::vector<Vec3f>& positions = refined.meshes[LitBox::floor].mesh.positions;
        return double(std::ranges::count_if(positions, [](const Vec3f& p) { return p.x > 0; })) /
               double(positions.size());
    };
    EXPECT_GT(share_with(true), 1.3 * share_with(false));
}

TEST(MeshRefinement, SplitsEdgesNextToTheEyeThatAreShortForTheirMesh) {
    // The shadow of a box on a ground of 1,000 m.
    ExampleScene example;
    const Mesh ground = square_mesh(1000, 0, 2);
    example.scene.instances = {{example.add_entity(ground, matte(0.5f)), {}},
                               {example.add_entity(box_mesh({0, 0.1f, 0}, {1, 1, 1}), matte(0.5f)), {}}};
    example.scene.environment = environment(
        [](const Vec3d& d) { return 0.3 + 60 * std::pow(std::max(0.0, d.dot(Vec3d(0.6, 0.8, 0))), 300); });
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    const ShadingGeometry geometry = *shading_geometry(example.scene, settings);
    const SceneLight light = scene_light(example.scene.environment, settings);
    const auto shortest_edge = [&](const Vec3f& eye) {
        example.scene.eye = eye;
        const PointShading shading{example.scene, geometry, light, settings};
        MeshRefiner refiner(shading, {0.01f, 3000, true},
                            *mesh_radiance(shading, std::vector{ground, example.mesh(1).fine}));
        for (bool can_refine = true; can_refine;) can_refine = *refiner.step();
        const Mesh refined = std::move(refiner).finished().meshes[0].mesh;
        float shortest = INFINITY;
        for (const auto& [a, b, c] : refined.triangles)
            shortest = std::min(shortest, (refined.positions[a] - refined.positions[b]).length());
        return shortest;
    };
    const float usual = 1e-4f * 707;
    EXPECT_LT(shortest_edge({2, 2, 2}), 0.8f * usual);
    EXPECT_GT(shortest_edge({2, 900, 2}), 0.95f * usual);
}

TEST(MeshRefinement, WeighsErrorsByTheTintsOfSurfaces) {
    LitBox lit;
    const auto vertices_at_right = [&] {
        const Refinement refined =
            *refined_radiance(lit.shading, {0.01f, 100000, false, true}, lit.radiant(8));
        return std::ranges::count_if(refined.meshes[LitBox::floor].mesh.positions,
                                     [](const Vec3f& p) { return p.x > 0.1f; });
    };
    const auto untinted = vertices_at_right();
    std::vector<Rgb> tints;
    for (const Vec3f& p : lit.example.scene.entities[LitBox::floor].mesh->positions)
        tints.emplace_back(p.x > 0.1f ? 0.05f : 1.0f);
    lit.example.scene.entities[LitBox::floor].tints = tints;
    EXPECT_LT(3 * vertices_at_right(), 2 * untinted);
}

TEST(MeshRefinement, DividesTrianglesAroundKnownPointsThatItMisses) {
    const LitBox lit;
    const std::vector<RadiantMesh> start = lit.radiant(4);
    const auto shortest_edge_around = [&](const MeshPoint& at,
                                          std::span<const MeshRefiner::KnownPoint> known) {
        MeshRefiner refiner(lit.shading, {0.05f, 100000, false, true}, start);
        refiner.add_known(known);
        while (*refiner.step()) {
        }
        const auto corners = refiner.located(at).corners;
        const RadiantMesh mesh = std::move(refiner).finished().meshes[LitBox::floor];
        double shortest = 4;
        for (std::size_t k = 0; k < 3; ++k)
            shortest = std::min(
                shortest,
                double(
                    (mesh.mesh.positions[corners[k]] - mesh.mesh.positions[corners[(k + 1) % 3]]).length()));
        return shortest;
    };
    // A point that is black unlike all others, so that no triangle is small enough.
    const MeshPoint at{LitBox::floor, 0, 0.3f, 0.4f};
    const MeshRefiner::KnownPoint black{at, {}};
    EXPECT_GT(shortest_edge_around(at, {}), 0.1);
    EXPECT_LT(shortest_edge_around(at, {&black, 1}), 0.01);
}

TEST(MeshRefinement, ALowerToleranceContinuesIt) {
    const LitBox lit;
    MeshRefiner refiner(lit.shading, {0.05f, 100000, false, true}, lit.radiant(10));
    while (*refiner.step()) {
    }
    const std::size_t before = refiner.vertices();
    refiner.set_tolerance(0.01f);
    EXPECT_TRUE(*refiner.step());
    EXPECT_GT(refiner.vertices(), before);
}

TEST(MeshRefinement, AStepEndsAtTheWantedNumberOfVertices) {
    const LitBox lit;
    MeshRefiner refiner(lit.shading, {0.002f, 4000}, lit.radiant(6));
    for (int step = 0; step < 5; ++step) {
        const std::size_t wanted = refiner.vertices() + 20;
        ASSERT_TRUE(*refiner.step({}, wanted));
        EXPECT_LT(refiner.vertices(), wanted + 20);
        EXPECT_FALSE(refiner.is_budget_used_up());
    }
}

TEST(MeshRefinement, InterpolatesIndirectIrradianceWhereItVariesSlowly) {
    const LitBox lit;
    RenderSettings settings = lit.settings;
    settings.bounces.most = 3;
    PointShading shading{lit.example.scene, lit.geometry, lit.light, settings};
    IndirectLight indirect = *scene_indirect_light(shading);
    VertexMask all;
    for (const ShadedInstance& instance : lit.example.scene.instances)
        all.emplace_back(lit.example.scene.entities[instance.entity].mesh->positions.size(), true);
    ASSERT_TRUE(gather_irradiance(shading, all, indirect));
    shading.indirect = &indirect;
    std::vector<RadiantMesh> start =
        *mesh_radiance(shading, std::vector{lit.example.mesh(0).fine, lit.example.mesh(1).fine});
    for (std::size_t i = 0; i < start.size(); ++i)
        for (std::size_t v = 0; v < start[i].radiance.size(); ++v)
            start[i].irradiance.push_back({indirect.irradiance[i][v], indirect.nearness[i][v]});
    const Refinement refined = *refined_radiance(shading, {0.01f, 3000}, start);
    const RadiantMesh& floor = refined.meshes[LitBox::floor];
    std::vector<InstancePoint> points;
    for (std::size_t v = start[LitBox::floor].radiance.size(); v < floor.radiance.size(); ++v)
        if (!floor.samples.buried[v])
            points.push_back({LitBox::floor,
                              {floor.mesh.positions[v], floor.mesh.normals[v], floor.samples.points[v], 0}});
    const std::vector<Outgoing> gathered = *point_radiance(shading, points);
    double squares = 0, sum = 0;
    std::size_t differ = 0, next = 0;
    for (std::size_t v = start[LitBox::floor].radiance.size(); v < floor.radiance.size(); ++v) {
        if (floor.samples.buried[v]) continue;
        const Outgoing& exact = gathered[next++];
        squares += std::pow(channel_sum(floor.radiance[v]) - channel_sum(exact), 2);
        sum += std::pow(channel_sum(exact), 2);
        differ += floor.radiance[v] != exact;
    }
    EXPECT_LT(std::sqrt(squares / sum), 0.002);
    EXPECT_GT(differ, 0u) << "nothing was interpolated";
    EXPECT_LT(differ, points.size()) << "nothing was gathered";
}

TEST(MeshRefinement, IsBitIdenticalForAnyNumberOfThreads) {
    const LitBox lit;
    std::vector<Refinement> results;
    for (const std::size_t threads : {1u, 3u}) {
        results.push_back(with_threads(threads, [&] {
            return *refined_radiance(lit.shading, {0.02f, 3000}, lit.radiant(6));
        }));
    }
    for (std::size_t i = 0; i < results[0].meshes.size(); ++i) {
        EXPECT_EQ(results[0].meshes[i].mesh.positions, results[1].meshes[i].mesh.positions);
        EXPECT_EQ(results[0].meshes[i].mesh.triangles, results[1].meshes[i].mesh.triangles);
        EXPECT_EQ(results[0].meshes[i].radiance, results[1].meshes[i].radiance);
    }
}

TEST(MeshRefinement, CanBeInterrupted) {
    const LitBox lit;
    const auto start = lit.radiant(6);
    std::stop_source stop;
    Progress progress;
    progress.stop = stop.get_token();
    progress.report = [&](std::string_view, std::uint64_t, std::uint64_t) { stop.request_stop(); };
    const auto refined = refined_radiance(lit.shading, {1e-4f, 100000}, start, progress);
    ASSERT_FALSE(refined);
    EXPECT_EQ(refined.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace haarfield
