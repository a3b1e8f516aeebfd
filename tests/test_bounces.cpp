#include <gtest/gtest.h>

#include "fields/base/spiral.h"
#include "shading/bake/bounced_radiance.h"
#include "shading/bake/path_tracer.h"
#include "shading/bounces/gathering_directions.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/relative_error.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

Mesh inside_out(Mesh mesh) {
    for (Vec3f& normal : mesh.normals) normal = -normal;
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    return mesh;
}

/// Returns the lower half of a sphere, facing inwards.
Mesh bowl_mesh(int segments) {
    Mesh mesh = inside_out(sphere_mesh({0, 0, 0}, 1, segments));
    std::erase_if(mesh.triangles, [&](const auto& triangle) {
        return std::ranges::any_of(triangle, [&](std::uint32_t v) { return mesh.positions[v].y > 1e-6f; });
    });
    Mesh bowl = mesh;
    bowl.positions.clear();
    bowl.normals.clear();
    bowl.vertex_materials.clear();
    std::vector<std::uint32_t> number(mesh.positions.size(), ~0u);
    for (auto& triangle : bowl.triangles)
        for (std::uint32_t& v : triangle) {
            if (number[v] == ~0u) {
                number[v] = static_cast<std::uint32_t>(bowl.positions.size());
                bowl.positions.push_back(mesh.positions[v]);
                bowl.normals.push_back(mesh.normals[v]);
                bowl.vertex_materials.push_back(0);
            }
            v = number[v];
        }
    return bowl;
}

RenderSettings bouncing(int most = any_bounces) {
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    settings.bounces.most = most;
    return settings;
}

/// A scene with everything that bounces need.
struct Bouncing : ExampleScene {
    Bouncing(const Mesh& mesh, const Material& material) {
        scene.instances.push_back({add_entity(mesh, material), {}});
        scene.environment = environment([](const Vec3d&) { return 1.0; });
    }
    const ShadingGeometry& geometry() {
        if (!geometry_) geometry_ = std::move(*shading_geometry(scene, bouncing()));
        return *geometry_;
    }
    const FineSurface& surface() {
        if (!surface_) surface_ = std::make_shared<const FineSurface>(scene);
        return *surface_;
    }
    const LightTransport& transport() {
        if (!transport_) transport_ = *LightTransport::make(scene, geometry(), surface(), 64);
        return *transport_;
    }
    std::shared_ptr<const FineSurface> shared_surface() { return surface(), surface_; }

private:
    std::optional<ShadingGeometry> geometry_;
    std::shared_ptr<const FineSurface> surface_;
    std::optional<LightTransport> transport_;
};

TEST(Bounces, ClosedFurnaceSumsTheWholeSeries) {
    for (const Mesh& mesh : {sphere_mesh({0, 0, 0}, 1, 12), box_mesh({-1, -1, -1}, {1, 1, 1}, 6)})
        for (const float albedo : {0.5f, 0.8f}) {
            Bouncing furnace(inside_out(mesh), matte(albedo));
            const std::vector<Rgb> direct(mesh.positions.size(), Rgb(1.0f));
            const std::vector<Rgb> reflectance = row_reflectances(furnace.scene, furnace.geometry());
            const Result<BouncedLight> all =
                bounced_light(furnace.transport(), reflectance, direct, bouncing().bounces);
            for (const Rgb& radiance : all->radiance)
                EXPECT_NEAR(radiance.x * (1 - albedo), 1, 1e-3) << mesh.positions.size() << ", " << albedo;
            const Result<BouncedLight> two =
                bounced_light(furnace.transport(), reflectance, direct, bouncing(2).bounces);
            EXPECT_EQ(two->bounces, 2);
            for (const Rgb& radiance : two->radiance)
                EXPECT_NEAR(radiance.x, 1 + albedo + albedo * albedo, 3e-3);
        }
}

TEST(Bounces, BowlUnderAUniformSkyHasItsClosedForm) {
    // Every point of a sphere receives the same fraction of the light of every other: L = r f / (1 - r (1 -
    // f)), where f = 1/2 is the open fraction of the sphere.
    for (const float albedo : {0.5f, 0.8f}) {
        Bouncing bowl(bowl_mesh(48), matte(albedo));
        const SceneColours radiance = total(*scene_radiance(bowl.scene, bouncing()));
        const double wanted = albedo * 0.5 / (1 - albedo * 0.5);
        RelativeError error;
        double mean = 0;
        for (const Rgb& r : radiance[0]) {
            error.add(Vec3d(r), Vec3d(wanted));
            mean += double(r.x) / double(radiance[0].size());
        }
        EXPECT_NEAR(mean / wanted, 1, 0.003) << albedo;
        EXPECT_LT(error.rmse(), 0.02) << albedo;
    }
}

TEST(Bounces, AgreeWithPathTracing) {
    Bouncing bowl(bowl_mesh(48), matte(0.8f));
    const RayScene rays(bowl.scene);
    const PathTracer tracer(rays, bowl.surface());
    const EntityOcclusion& occlusion = *bowl.scene.entities[0].occlusion;
    const Mesh& mesh = *bowl.scene.entities[0].mesh;
    double mean = 0;
    constexpr std::uint32_t points = 40;
    for (std::uint32_t v = 0; v < points; ++v) {
        const std::uint32_t at = v * 31 % static_cast<std::uint32_t>(mesh.positions.size());
        const PathTracer::Estimate found =
            tracer.indirect_irradiance(occlusion.samples().points[at], mesh.normals[at], 0, 1024, v);
        EXPECT_GT(found.deviation.x, 0);
        mean += double(found.irradiance.x) / points;
    }
    EXPECT_NEAR(mean / (pi * (2.0 / 3 / 0.8 - 0.5)), 1, 0.01);
}

TEST(Bounces, PathsInAnEmittingFurnaceHaveTheClosedForm) {
    // Every wall of a closed box emits radiance 2: E = pi 2 (a + a^2 + ...), by light that was reflected.
    constexpr float albedo = 0.6f;
    const Mesh walls = inside_out(box_mesh({-1, -1, -1}, {1, 1, 1}, 3));
    Bouncing furnace(walls, matte(albedo));
    for (const auto& [a, b, c] : walls.triangles)
        furnace.scene.entities[0].emitters.push_back(
            {{walls.positions[a], walls.positions[b], walls.positions[c]}, Rgb(2.0f)});
    const RayScene rays(furnace.scene);
    const PathTracer tracer(rays, furnace.surface());
    double mean = 0;
    constexpr std::uint32_t points = 40;
    for (std::uint32_t v = 0; v < points; ++v) {
        const std::uint32_t at = v * 2 % static_cast<std::uint32_t>(walls.positions.size());
        const Vec3f from = furnace.scene.entities[0].occlusion->samples().points[at] * 0.98f;
        mean += double(tracer.indirect_irradiance(from, walls.normals[at], 0, 4096, v).irradiance.x) / points;
    }
    EXPECT_NEAR(mean / (pi * 2 * albedo / (1 - albedo)), 1, 0.01);
}

TEST(Bounces, VerticesInsideOtherInstancesReflectNoBlack) {
    // A box that is sunk into a coarse floor: many of the rays from its walls hit triangles of the floor that
    // have corners inside the box.
    Bouncing room(square_mesh(4, 0, 10), matte(0.8f));
    const std::size_t box =
        room.add_entity(box_mesh({-0.6f, -0.1f, -0.6f}, {0.6f, 1, 0.6f}, 12), matte(0.5f));
    room.scene.instances.push_back({box, {}});
    const SceneLight light = scene_light(room.scene.environment, bouncing());
    const RenderSettings settings = bouncing();
    const IndirectLight indirect = *scene_indirect_light({room.scene, room.geometry(), light, settings});
    const RayScene rays(room.scene);
    const PathTracer tracer(rays, room.surface());
    const ShadedEntity& entity = room.scene.entities[box];
    double found = 0, wanted = 0;
    for (std::uint32_t v = 0; v < entity.mesh->positions.size(); ++v) {
        const Vec3f& place = entity.mesh->positions[v];
        if (place.y < 0.05f || place.y > 0.5f || std::abs(entity.mesh->normals[v].y) > 0.1f) continue;
        found += double(indirect.irradiance[1][v].x);
        wanted += double(tracer
                             .indirect_irradiance(entity.occlusion->samples().points[v],
                                                  entity.mesh->normals[v], 0, 1024, v)
                             .irradiance.x);
    }
    EXPECT_NEAR(found / wanted, 1, 0.02);
}

TEST(Bounces, ZeroBouncesAreDirectLightOnly) {
    Bouncing bowl(bowl_mesh(12), matte(0.5f));
    std::optional<IndirectLight> indirect;
    const SceneLight light = scene_light(bowl.scene.environment, bouncing(0));
    const RenderSettings settings = bouncing(0);
    const PointShading shading{bowl.scene, bowl.geometry(), light, settings};
    EXPECT_EQ(total(*bounced_radiance(shading, indirect)), total(*scene_radiance(shading)));
    EXPECT_FALSE(indirect);
}

TEST(Bounces, BacksAndOccludersSendNoLight) {
    // A square above another one: the back of the upper one blocks light from below.
    Bouncing scene(square_mesh(2, 0, 4), matte(0.5f));
    scene.scene.instances.push_back({0, {{0, 1, 0}}});  // faces up, so that its back is visible from below
    const std::vector<Rgb> direct(2 * 25, Rgb(1.0f));
    for (const Rgb& arriving : scene.transport().irradiance(direct)) EXPECT_EQ(arriving, Rgb(0.0f));
}

TEST(Bounces, EveryOtherRowIsUpdated) {
    Bouncing bowl(bowl_mesh(16), matte(0.5f));
    const std::size_t rows = bowl.geometry().entities[0].order.size();
    std::vector<Rgb> radiance(rows);
    for (std::size_t row = 0; row < rows; ++row) radiance[row] = Rgb(float(row % 7), 1.0f, float(row % 3));
    const std::vector<Rgb> all = bowl.transport().irradiance(radiance);
    for (const std::size_t first : {0, 1}) {
        std::vector<Rgb> updated(rows, Rgb(-1.0f));
        bowl.transport().update_irradiance(radiance, first, updated);
        for (std::size_t row = 0; row < rows; ++row)
            EXPECT_EQ(updated[row], row % 2 == first ? all[row] : Rgb(-1.0f)) << row;
    }
}

TEST(Bounces, GatheringDirectionsAreThoseOfASpiralInCompactPackets) {
    for (int rays = least_gathering_rays; rays <= most_gathering_rays; rays *= 2) {
        const std::span<const Vec3f> found = gathering_directions(rays);
        ASSERT_EQ(found.size(), std::size_t(rays));
        const auto less = [](const Vec3f& a, const Vec3f& b) {
            return std::tie(a.z, a.x, a.y) < std::tie(b.z, b.x, b.y);
        };
        std::vector<Vec3f> sorted(found.begin(), found.end()), spiral;
        for (int k = 0; k < rays; ++k)
            spiral.push_back(
                Vec3f(spiral_direction(std::size_t(k), std::sqrt((double(k) + 0.5) / double(rays)))));
        std::sort(sorted.begin(), sorted.end(), less);
        std::sort(spiral.begin(), spiral.end(), less);
        EXPECT_EQ(sorted, spiral);

        // The unit disc below the directions has an area of pi, of which a packet covers its share.
        double square_radii = 0;
        for (std::size_t first = 0; first < found.size(); first += 16) {
            Vec3f centre(0.0f);
            for (const Vec3f& d : found.subspan(first, 16)) centre += d / 16.0f;
            for (const Vec3f& d : found.subspan(first, 16))
                square_radii += double((d - centre).x * (d - centre).x + (d - centre).y * (d - centre).y);
        }
        if (rays >= 256) {
            EXPECT_LT(square_radii / rays, 16.0 / rays) << rays;
        }
    }
}

TEST(Bounces, HitsOfPacketsAreThoseOfSingleRays) {
    ExampleScene example;
    example.add_entity(sphere_mesh({0, 0, 0}, 1, 12), matte(0.5f));
    example.add_entity(box_mesh({-1, -1, -1}, {1, 1, 1}, 3), matte(0.5f));
    example.scene.instances = {{0, {{0, 0.2f, 0}, 0.5f, rotation_xyz({0.3f, 0.8f, -0.4f})}},
                               {1, {{2, 0, 1}, 0.7f}},
                               {1, {{0, -3, 0}, 2, rotation_xyz({1.3f, -0.2f, 0.4f})}}};
    const FineSurface surface(example.scene);
    int met = 0, backs = 0;
    for (const Vec3f& from : {Vec3f(0.9f, 0.1f, -0.3f), Vec3f(0, 0.2f, 0), Vec3f(0, -1.8f, 1)})
        for (const std::size_t count : {16, 5, 1}) {
            const std::span<const Vec3f> all = gathering_directions(256);
            for (std::size_t first = 0; first + count <= all.size(); first += count) {
                const std::span<const Vec3f> directions = all.subspan(first, count);
                const FineSurface::Hits hits = surface.first_hits(example.scene, from, directions);
                for (std::size_t k = 0; k < count; ++k) {
                    const std::optional<SurfaceHit> wanted =
                        surface.first_hit(example.scene, from, directions[k]);
                    ASSERT_EQ(hits[k].has_value(), wanted.has_value());
                    if (!wanted) continue;
                    EXPECT_EQ(hits[k]->instance, wanted->instance);
                    EXPECT_EQ(hits[k]->is_back, wanted->is_back);
                    EXPECT_NEAR(hits[k]->distance, wanted->distance, 1e-5f * wanted->distance);
                    ++met;
                    backs += wanted->is_back;
                }
                for (std::size_t k = count; k < FineSurface::packet; ++k) EXPECT_FALSE(hits[k]);
            }
        }
    EXPECT_GT(met, 500);
    EXPECT_GT(backs, 100);
}

TEST(Bounces, PointsGatherTheRadianceAroundThem) {
    // A point of a bowl sees one half of the sphere, which has half of its irradiance.
    Bouncing bowl(bowl_mesh(48), matte(0.5f));
    BouncedLight bounced;
    const std::vector<Rgb> values(bowl.geometry().entities[0].order.size(), Rgb(2.0f, 3.0f, 4.0f));
    bounced.irradiance = bounced.radiance = values;
    const IndirectLight indirect = indirect_light(bowl.scene, bowl.geometry(), bowl.shared_surface(),
                                                  bowl.transport(), std::move(bounced));
    const ShadedEntity& entity = bowl.scene.entities[0];
    double sum = 0;
    int count = 0;
    for (std::uint32_t v = 0; v < entity.mesh->positions.size(); v += 7) {
        if (entity.mesh->positions[v].y > -0.05f) continue;
        const Rgb found = indirect.irradiance_at(bowl.scene, 0, surface_point(entity, v));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(double(found[c]) / (pi / 2 * (2 + c)), 1, 0.05) << v;
        sum += double(found.x) / pi;
        ++count;
    }
    EXPECT_NEAR(sum / count, 1, 0.01);
}

TEST(Bounces, LaterBouncesOfGroupsAgreeWithThoseOfAllRows) {
    // A box on the floor of a room, with a spot of light on a wall.
    Bouncing room(joined_meshes(inside_out(box_mesh({-1, -1, -1}, {1, 1, 1}, 24)),
                                box_mesh({-0.6f, -0.99f, -0.5f}, {0, -0.2f, 0.1f}, 12)),
                  matte(0.8f));
    const VertexRows rows(room.scene, room.geometry());
    const Mesh& mesh = *room.scene.entities[0].mesh;
    std::vector<Rgb> direct(rows.count());
    for (std::size_t row = 0; row < direct.size(); ++row)
        direct[row] = Rgb((mesh.positions[rows[row].vertex] - Vec3f(1, 0.4f, 0.2f)).length() < 0.4f ? 1 : 0);
    const std::vector<Rgb> reflectance = row_reflectances(room.scene, room.geometry());
    const CoarseTransport coarse = room.transport().coarse();
    EXPECT_LT(3 * coarse.share.size(), rows.count());
    for (const int most : {1, 2, 3, any_bounces}) {
        const BouncedLight all =
                               *bounced_light(room.transport(), reflectance, direct, bouncing(most).bounces),
                           grouped = *bounced_light(room.transport(), coarse, reflectance, direct,
                                                    bouncing(most).bounces);
        double difference = 0, whole = 0, sum = 0;
        for (std::size_t row = 0; row < rows.count(); ++row) {
            difference += double(std::abs(all.irradiance[row].x - grouped.irradiance[row].x));
            whole += double(all.irradiance[row].x);
            sum += double(grouped.irradiance[row].x);
        }
        EXPECT_GT(whole, 0);
        EXPECT_LT(difference, (most < 3 ? 0 : 0.01) * whole + 1e-9) << most;
        EXPECT_NEAR(sum / whole, 1, 0.005) << most;
        if (most < any_bounces) {
            EXPECT_EQ(grouped.bounces, most);
        }
    }
}

TEST(Bounces, SmoothingPreservesUniformLightAndContacts) {
    // A floor with a wall on it: the light from the wall changes quickly at its foot.
    Bouncing scene(joined_meshes(square_mesh(2, 0, 16), box_mesh({-1, 0, -0.1f}, {1, 1, 0.1f}, 16)),
                   matte(0.5f));
    std::vector<Rgb> even(scene.geometry().entities[0].order.size(), Rgb(3.0f));
    scene.transport().smooth(even);
    for (const Rgb& value : even) EXPECT_NEAR(value.x, 3, 1e-5);
    std::vector<Rgb> uneven(even.size(), Rgb(0.0f));
    for (std::size_t row = 0; row < uneven.size(); row += 2) uneven[row] = Rgb(1.0f);
    std::vector<Rgb> smooth = uneven;
    scene.transport().smooth(smooth);
    const VertexRows rows(scene.scene, scene.geometry());
    const Mesh& mesh = *scene.scene.entities[0].mesh;
    for (std::size_t row = 0; row < smooth.size(); ++row) {
        const Vec3f& place = mesh.positions[rows[row].vertex];
        if (place.y == 0 && std::abs(place.x) < 0.9f && std::abs(place.z) > 0.1f &&
            std::abs(place.z) < 0.3f) {
            EXPECT_EQ(smooth[row], uneven[row]) << place.x << ", " << place.z;
        }
    }
}

TEST(Bounces, SpecularLobesReflectTheirSurroundings) {
    // At the centre of a wall of a box that emits uniformly: int cos^n / pi = 2 / (n + 1) along the normal.
    Bouncing furnace(inside_out(box_mesh({-1, -1, -1}, {1, 1, 1}, 4)), matte(0.5f));
    BouncedLight bounced;
    bounced.irradiance = bounced.radiance =
        std::vector<Rgb>(furnace.geometry().entities[0].order.size(), Rgb(1.0f));
    const IndirectLight indirect = indirect_light(furnace.scene, furnace.geometry(), furnace.shared_surface(),
                                                  furnace.transport(), bounced);
    VertexBrdf brdf;
    brdf.normal = brdf.mirror = {0, 1, 0};
    brdf.specular = Rgb(static_cast<float>(1 / pi));
    for (const float exponent : {10.0f, 60.0f}) {
        brdf.lobes[0] = {LobeAxis::mirror, 1, exponent};
        EXPECT_NEAR(indirect.outgoing(furnace.scene, {0, -0.99f, 0}, brdf, Rgb(0.0f)).specular.x,
                    2 / (exponent + 1), 0.01 / exponent);
        // About the half vector, seen along the normal: int (N.H)^m / pi dw = 8 int c^(m+1) dc = 8 / (m + 2),
        // as far as light comes from above.
        brdf.lobes[0] = {LobeAxis::half_vector, 1, exponent};
        const double below = std::pow(std::sqrt(0.5), double(exponent) + 2);
        EXPECT_NEAR(
            indirect.outgoing(furnace.scene, {0, -0.99f, 0}, brdf, Rgb(0.0f)).specular.x * (exponent + 2) / 8,
            1 - below, 0.05);
    }
}

TEST(Bounces, DiffuseComponentIsTheRadianceOfDiffuseMaterials) {
    Material material = glossy(20, LobeConvention::povray);
    material.diffuse = Rgb(0.3f, 0.4f, 0.5f);
    Bouncing shining(bowl_mesh(12), material);
    shining.scene.eye = {0, 3, 1};
    const SceneLight light = scene_light(shining.scene.environment, bouncing());
    const RenderSettings settings = bouncing();
    const SceneColours found =
        diffuse_component(*scene_radiance({shining.scene, shining.geometry(), light, settings}));
    ShadedScene dull = shining.scene;
    dull.entities[0].materials[0].specular = Rgb(0.0f);
    const SceneColours wanted = total(*scene_radiance({dull, shining.geometry(), light, settings}));
    for (std::size_t v = 0; v < wanted[0].size(); ++v)
        EXPECT_LE((found[0][v] - wanted[0][v]).length(), 1e-3f * wanted[0][v].length()) << v;
}

TEST(Bounces, AreBitIdenticalForAnyNumberOfThreads) {
    Bouncing bowl(bowl_mesh(24), matte(0.7f));
    const auto radiance_by = [&](std::size_t threads) {
        return with_threads(threads, [&] { return total(*scene_radiance(bowl.scene, bouncing())); });
    };
    const SceneColours wanted = radiance_by(1);
    EXPECT_EQ(radiance_by(2), wanted);
    EXPECT_EQ(radiance_by(8), wanted);
}

TEST(Bounces, CanBeInterrupted) {
    Bouncing bowl(bowl_mesh(24), matte(0.7f));
    std::stop_source stop;
    stop.request_stop();
    const Result<LightTransport> made =
        LightTransport::make(bowl.scene, bowl.geometry(), bowl.surface(), 64, {{}, stop.get_token()});
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace haarfield
