#include "tests/bench/shipped_kernels.h"

#include <memory>

#include "shading/bake/dense_renderer.h"
#include "shading/transfer/light_transfer.h"
#include "shading/transfer/motion_transfer.h"
#include "shading/transfer/view_transfer.h"
#include "tests/fixtures/furnished_room.h"
#include "tests/fixtures/random_numbers.h"
#include "tests/fixtures/relative_error.h"
#include "tests/fixtures/vertex_example.h"

namespace haarfield::bench {
namespace {

using furnished::Room;
using furnished::settings;

/// Glossy vertices at one place, rotated in all directions. Every other one is near an occluder.
class TurnedVertices {
public:
    TurnedVertices() {
        std::mt19937 random(1);
        for (VertexBrdf& brdf : brdfs_) {
            brdf.normal = random_direction(random);
            brdf.mirror = (random_direction(random) + brdf.normal).normalized();
            brdf.diffuse = Rgb(0.3f, 0.2f, 0.1f);
            brdf.specular = Rgb(0.1f, 0.2f, 0.3f);
            brdf.lobes = {{{LobeAxis::mirror, 1, 30}, {LobeAxis::half_vector, 0.5f, 20}}};
        }
    }
    void shade() {
        for_each([&](const ShadedVertex& vertex) {
            return outgoing_radiance(*example_.light, vertex, memory_).total();
        });
    }
    void multiply() {
        for_each([&](const ShadedVertex& vertex) {
            radiance_integrand(*example_.light, vertex, memory_, product_);
            return integral_of(product_);
        });
    }
    void multiply_highlights() {
        for_each([&](const ShadedVertex& vertex) {
            const Rgb diffuse = specular_integrand(*example_.light, vertex, memory_, product_).diffuse;
            return diffuse + integral_of(product_);
        });
    }
    double error() const {
        RelativeError sum;
        for (std::size_t i = 0; i < brdfs_.size(); ++i)
            sum.add(Vec3d(radiance_[i]), example_.expected(brdfs_[i], cones(i)));
        return sum.rmse();
    }
    std::size_t count() const { return brdfs_.size(); }

private:
    BlockedCones cones(std::size_t vertex) const { return vertex % 2 ? BlockedCones(near_) : BlockedCones(); }

    template <class Radiance>
    void for_each(const Radiance& radiance) {
        for (std::size_t i = 0; i < brdfs_.size(); ++i)
            radiance_[i] = radiance(example_.shaded(brdfs_[i], cones(i)));
    }

    VertexExample example_{1};
    BlockedConeList near_ = cones_of_a_square();
    std::array<VertexBrdf, 8> brdfs_;
    std::array<Rgb, 8> radiance_;
    WalkMemory<std::uint8_t> memory_;
    std::vector<WaveletBlock<3>> product_;
};

TurnedVertices& turned_vertices() {
    static TurnedVertices made;
    return made;
}

/// A room with a sun.
struct SunnyRoom : Room {
    SunnyRoom() {
        const Vec3f towards_sun = Vec3f(0.4f, 0.7f, 0.5f).normalized();
        scene.environment.suns.push_back({towards_sun, 0.01f, Rgb(1, 0.9f, 0.7f)});
    }
};

/// The room that the other kernels shade, and their results.
struct Subject {
    static constexpr TransferSettings pruning{0.01f};
    static constexpr std::size_t moving = 3;  ///< Index of the instance.

    SunnyRoom room;
    RgbCubemapTree smooth = room.light();
    DenseCoefficients coefficients = dense_coefficients(smooth, Room::size);
    SceneLight light = scene_light(room.scene.environment, settings());
    std::size_t vertices = VertexRows(room.scene, room.geometry()).count();
    SceneColours radiance;
    std::optional<LightTransfer> by_light;
    std::optional<ViewTransfer> by_view;
    std::optional<MotionTransfer> by_motion;

    void shade() { radiance = total(*scene_radiance({room.scene, room.geometry(), light, settings()})); }
    void make_light() {
        by_light = *light_transfer(room.scene, room.geometry(), settings(), pruning, coefficients);
    }
    void make_view() {
        by_view = *view_transfer(room.scene, room.geometry(), settings(), pruning, smooth, light.sources);
    }
    void make_motion() {
        by_motion =
            *motion_transfer(room.scene, room.geometry(), settings(), pruning, smooth, light.lights, moving);
    }
    void shade_light() {
        if (!by_light) make_light();
        (void)shade_frame(*by_light, room.scene, room.geometry(), coefficients, light.lights,
                          FrameQuality::still, radiance);
    }
    void shade_view() {
        if (!by_view) make_view();
        (void)shade_frame(*by_view, room.scene, room.geometry(), radiance);
    }
    void shade_motion() {
        if (!by_motion) make_motion();
        (void)shade_frame(*by_motion, room.scene, room.geometry(), settings(), FrameQuality::still, radiance);
    }

    /// Returns the error of the current radiance at one vertex in five, against sums over the texels of
    /// rasterized visibility and rays to all points of the sun.
    double error() const {
        const DenseScene dense(room.scene, Room::size);
        DenseShader shader(dense);
        const VertexRows rows(room.scene, room.geometry());
        RelativeError sum;
        for (std::size_t row = 0; row < rows.count(); row += 5) {
            const auto [instance, vertex] = rows[row];
            if (rows.is_buried({instance, vertex})) continue;
            const ShadedEntity& entity = room.scene.entities[room.scene.instances[instance].entity];
            sum.add(Vec3d(radiance[instance][vertex]),
                    Vec3d(shader.radiance(instance, surface_point(entity, vertex)).total()));
        }
        return sum.rmse();
    }
};

Subject& subject() {
    static Subject made;
    return made;
}

ShippedKernel of_vertices(const char* name, void (TurnedVertices::*run)()) {
    return {name, [run] { (turned_vertices().*run)(); }, [] { return turned_vertices().count(); },
            [run] {
                (turned_vertices().*run)();
                return turned_vertices().error();
            },
            1e-3};
}

/// A kernel of the room: `run` on a subject, and `shade`, which computes radiance from the result.
ShippedKernel of_room(const char* name, void (Subject::*run)(), void (Subject::*shade)()) {
    return {name, [run] { (subject().*run)(); }, [] { return subject().vertices; },
            [run, shade] {
                (subject().*run)();
                subject().radiance.clear();
                (subject().*shade)();
                return subject().error();
            },
            0.03};
}

}  // namespace

Rgb integral_of(std::span<const WaveletBlock<3>> product) {
    Rgb sum(0.0f);
    for (const WaveletBlock<3>& block : product)
        if (block.level == 0)
            for (int c = 0; c < 3; ++c) sum[c] += block.amplitude[std::size_t(c)][0];
    return sum;
}

std::vector<ShippedKernel> shipped_kernels() {
    return {of_vertices("outgoing_radiance", &TurnedVertices::shade),
            of_vertices("radiance_integrand", &TurnedVertices::multiply),
            of_vertices("specular_integrand", &TurnedVertices::multiply_highlights),
            of_room("scene_radiance", &Subject::shade, &Subject::shade),
            of_room("light_vectors", &Subject::make_light, &Subject::shade_light),
            of_room("light_frame", &Subject::shade_light, &Subject::shade_light),
            of_room("view_vectors", &Subject::make_view, &Subject::shade_view),
            of_room("view_frame", &Subject::shade_view, &Subject::shade_view),
            of_room("motion_vectors", &Subject::make_motion, &Subject::shade_motion),
            of_room("motion_frame", &Subject::shade_motion, &Subject::shade_motion)};
}

}  // namespace haarfield::bench
