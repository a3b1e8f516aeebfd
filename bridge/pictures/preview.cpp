#include "bridge/pictures/preview.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "fields/base/embree_device.h"
#include "fields/base/embree_rays.h"
#include "scenes/camera_frame.h"

namespace haarfield {
namespace {

using OwnedScene = std::unique_ptr<RTCSceneTy, decltype(&rtcReleaseScene)>;

constexpr unsigned packet = 16;  ///< Rays per packet.

/// Places of a pixel's further rays, in eighths of the pixel: the n-rooks pattern of eight.
constexpr std::array<std::array<float, 2>, 8> places{
    {{5, 0}, {0, 1}, {3, 2}, {6, 3}, {1, 4}, {4, 5}, {7, 6}, {2, 7}}};

/// Pixels differ if a channel differs by more than this, sRGB-encoded.
constexpr float contrast = 0.04f;

/// The result of a ray.
struct Sample {
    Rgb radiance{0, 0, 0};
    unsigned object = RTC_INVALID_GEOMETRY_ID;
};

/// Pixel coordinates, from the upper left corner of the picture.
struct PixelPlace {
    float x, y;
};

/// Lets rays pass through texels that are less than half opaque.
void pass_cut_outs(const RTCFilterFunctionNArguments* arguments) {
    const auto& instance = *static_cast<const BakedInstance*>(arguments->geometryUserPtr);
    for (unsigned i = 0; i < arguments->N; ++i) {
        if (arguments->valid[i] == 0) continue;
        const auto& triangle = instance.mesh->triangles[RTCHitN_primID(arguments->hit, arguments->N, i)];
        const Texture* texture = texture_of(instance, triangle);
        if (!texture || !texture->has_alpha) continue;
        const float u = RTCHitN_u(arguments->hit, arguments->N, i),
                    v = RTCHitN_v(arguments->hit, arguments->N, i);
        const std::vector<Vec2f>& uvs = instance.mesh->uvs;
        const Vec2f at = uvs[triangle[0]] * (1 - u - v) + uvs[triangle[1]] * u + uvs[triangle[2]] * v;
        if (texture->opacity_at(at) < 0.5f) arguments->valid[i] = 0;
    }
}

bool has_cut_outs(const BakedInstance& instance) {
    return std::ranges::any_of(instance.surfaces, [](const Surface& surface) {
        return surface.texture && surface.texture->has_alpha;
    });
}

bool differs(const Sample& a, const Sample& b) {
    if (a.object != b.object) return true;
    if (a.object == RTC_INVALID_GEOMETRY_ID) return false;  // the background is smooth enough
    for (int c = 0; c < 3; ++c) {
        // The slope of the encoding is at most 13, so that small linear differences need no encoding.
        const float difference = std::abs(a.radiance[c] - b.radiance[c]);
        if (difference > contrast / 13 &&
            std::abs(srgb_encoded(a.radiance[c]) - srgb_encoded(b.radiance[c])) > contrast)
            return true;
    }
    return false;
}

}  // namespace

struct Preview::Rays {
    EmbreeDevice device;
    std::map<const Mesh*, OwnedScene> meshes;
    /// The user data of pass_cut_outs: the mesh, and surfaces that live as long as the mesh.
    std::map<const Mesh*, BakedInstance> cut_outs;

    const OwnedScene& scene_of(const BakedInstance& instance);
    OwnedScene scene_of(std::span<const BakedInstance> instances);
};

const OwnedScene& Preview::Rays::scene_of(const BakedInstance& instance) {
    const Mesh& mesh = *instance.mesh;
    const auto known = meshes.find(&mesh);
    if (known != meshes.end()) return known->second;
    OwnedScene scene(rtcNewScene(device.get()), &rtcReleaseScene);
    const std::shared_ptr<RTCGeometryTy> geometry = device.triangles(mesh.positions, mesh.triangles);
    if (has_cut_outs(instance)) {
        BakedInstance& told = cut_outs.insert_or_assign(&mesh, instance).first->second;
        told.radiance = told.added = {};
        rtcSetGeometryUserData(geometry.get(), &told);
        rtcSetGeometryIntersectFilterFunction(geometry.get(), pass_cut_outs);
    }
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene.get(), geometry.get());
    device.commit(scene.get());
    return meshes.emplace(&mesh, std::move(scene)).first->second;
}

OwnedScene Preview::Rays::scene_of(std::span<const BakedInstance> instances) {
    OwnedScene scene(rtcNewScene(device.get()), &rtcReleaseScene);
    for (std::size_t i = 0; i < instances.size(); ++i) {
        const BakedInstance& instance = instances[i];
        const RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, scene_of(instance).get());
        const std::array<float, 12> columns = instance.placement.columns();
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene.get(), geometry, static_cast<unsigned>(i));
        rtcReleaseGeometry(geometry);
    }
    device.commit(scene.get());
    return scene;
}

namespace {

/// The state of one picture.
class Drawing {
public:
    Drawing(const Camera& camera, std::span<const BakedInstance> instances, const Background& background,
            RTCScene scene)
        : width_(camera.width),
          height_(camera.height),
          instances_(instances),
          background_(background),
          scene_(scene),
          origin_(camera.position) {
        const CameraFrame frame = camera_frame(camera);
        const double half_height = std::tan(0.5 * double(camera.vertical_fov)),
                     half_width = half_height * camera.width / camera.height;
        right_ = Vec3f(frame.right * (2 * half_width / camera.width));
        down_ = Vec3f(frame.up * (-2 * half_height / camera.height));
        corner_ = Vec3f(frame.forward - frame.right * half_width + frame.up * half_height);
    }

    Image image(const BeforeReading& before_reading) {
        const std::size_t pixels = std::size_t(width_) * std::size_t(height_);
        std::vector<std::optional<MeshPoint>> seen = points();
        if (before_reading && !before_reading(vertices_of(seen))) return {};
        samples_.resize(pixels);
        tbb::parallel_for(0, height_, [&](int row) {
            for (int column = 0; column < width_; ++column) {
                const std::size_t pixel = place_of(column, row);
                samples_[pixel] = sample_of(seen[pixel], direction(centre_of(column, row)));
            }
        });

        const std::vector<std::uint32_t> edges = edge_pixels();
        seen.resize(places.size() * edges.size());
        tbb::parallel_for(std::size_t(0), edges.size(), [&](std::size_t e) {
            const Hits hits = cast(further_places(edges[e]), places.size());
            std::copy_n(hits.points.begin(), places.size(),
                        seen.begin() + static_cast<std::ptrdiff_t>(places.size() * e));
        });
        if (before_reading && !before_reading(vertices_of(seen))) return {};
        Image image{width_, height_, {}, {}};
        image.pixels.resize(pixels);
        std::transform(samples_.begin(), samples_.end(), image.pixels.begin(),
                       [](const Sample& sample) { return sample.radiance; });
        tbb::parallel_for(std::size_t(0), edges.size(), [&](std::size_t e) {
            const auto at = further_places(edges[e]);
            Rgb sum(0.0f);
            for (std::size_t i = 0; i < places.size(); ++i)
                sum += sample_of(seen[places.size() * e + i], direction(at[i])).radiance;
            image.pixels[edges[e]] = sum / static_cast<float>(places.size());
        });
        return image;
    }

    std::vector<std::optional<MeshPoint>> points() const {
        std::vector<std::optional<MeshPoint>> result(std::size_t(width_) * std::size_t(height_));
        tbb::parallel_for(0, (height_ + 3) / 4, [&](int band) {
            for (int column = 0; column < width_; column += 4) {
                const Hits hits = cast(square_places(column, 4 * band));
                for_pixels_of_square(column, 4 * band, [&](std::size_t pixel, std::size_t i) {
                    result[pixel] = hits.points[i];
                });
            }
        });
        return result;
    }

private:
    /// The hits of a packet.
    struct Hits {
        std::array<std::optional<MeshPoint>, packet> points;
    };

    std::size_t place_of(int column, int row) const {
        return std::size_t(row) * std::size_t(width_) + std::size_t(column);
    }

    /// Returns the centres of 4 x 4 pixels.
    static std::array<PixelPlace, packet> square_places(int column, int row) {
        std::array<PixelPlace, packet> at;
        for (unsigned i = 0; i < packet; ++i)
            at[i] = {static_cast<float>(column) + static_cast<float>(i % 4) + 0.5f,
                     static_cast<float>(row) + static_cast<float>(i / 4) + 0.5f};
        return at;
    }

    /// Calls use(index in the picture, index in the square) for the pixels inside the picture.
    template <class Use>
    void for_pixels_of_square(int column, int row, const Use& use) const {
        for (int i = 0; i < int(packet); ++i)
            if (column + i % 4 < width_ && row + i / 4 < height_)
                use(place_of(column + i % 4, row + i / 4), std::size_t(i));
    }

    std::vector<std::uint32_t> edge_pixels() const {
        std::vector<std::uint8_t> marked(samples_.size());
        tbb::parallel_for(0, height_, [&](int row) {
            for (int column = 0; column < width_; ++column)
                marked[place_of(column, row)] = is_edge(column, row);
        });
        std::vector<std::uint32_t> pixels;
        for (std::size_t i = 0; i < marked.size(); ++i)
            if (marked[i]) pixels.push_back(static_cast<std::uint32_t>(i));
        return pixels;
    }

    bool is_edge(int column, int row) const {
        const Sample& here = samples_[place_of(column, row)];
        return (column > 0 && differs(here, samples_[place_of(column - 1, row)])) ||
               (column + 1 < width_ && differs(here, samples_[place_of(column + 1, row)])) ||
               (row > 0 && differs(here, samples_[place_of(column, row - 1)])) ||
               (row + 1 < height_ && differs(here, samples_[place_of(column, row + 1)]));
    }

    static PixelPlace centre_of(int column, int row) {
        return {static_cast<float>(column) + 0.5f, static_cast<float>(row) + 0.5f};
    }

    /// Returns the places of a pixel's eight further rays.
    std::array<PixelPlace, packet> further_places(std::uint32_t pixel) const {
        const auto column = static_cast<float>(pixel % static_cast<std::uint32_t>(width_)),
                   row = static_cast<float>(pixel / static_cast<std::uint32_t>(width_));
        std::array<PixelPlace, packet> at;
        for (std::size_t i = 0; i < packet; ++i)
            at[i] = {column + (places[i % 8][0] + 0.5f) / 8, row + (places[i % 8][1] + 0.5f) / 8};
        return at;
    }

    Vec3f direction(const PixelPlace& at) const { return corner_ + right_ * at.x + down_ * at.y; }

    Sample sample_of(const std::optional<MeshPoint>& seen, const Vec3f& along) const {
        if (!seen) return {background_(along), RTC_INVALID_GEOMETRY_ID};
        const BakedInstance& instance = instances_[seen->instance];
        const auto& triangle = instance.mesh->triangles[seen->triangle];
        const auto mean = [&](const auto& values) {
            return values[triangle[0]] * (1 - seen->u - seen->v) + values[triangle[1]] * seen->u +
                   values[triangle[2]] * seen->v;
        };
        Rgb radiance = mean(instance.radiance);
        const Texture* texture = texture_of(instance, triangle);
        if (texture) radiance *= texture->colour_at(mean(instance.mesh->uvs));
        if (texture && !instance.added.empty()) radiance += mean(instance.added);
        return {radiance, seen->instance};
    }

    VertexMask vertices_of(std::span<const std::optional<MeshPoint>> seen) const {
        VertexMask vertices;
        for (const BakedInstance& instance : instances_)
            vertices.emplace_back(instance.mesh->positions.size(), std::uint8_t(0));
        for (const std::optional<MeshPoint>& point : seen)
            if (point)
                for (const std::uint32_t v : instances_[point->instance].mesh->triangles[point->triangle])
                    vertices[point->instance][v] = 1;
        return vertices;
    }

    Hits cast(const std::array<PixelPlace, packet>& at, std::size_t count = packet) const {
        RTCRayHit16 rays;
        alignas(64) std::array<int, packet> valid;
        Hits result;
        for (std::size_t i = 0; i < packet; ++i) {
            valid[i] = i < count ? -1 : 0;
            set_ray(rays.ray, i, origin_, direction(at[i]), INFINITY);
        }
        find_hits(scene_, valid.data(), rays, Coherence::high);
        for (std::size_t i = 0; i < count; ++i)
            if (rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID)
                result.points[i] =
                    MeshPoint{rays.hit.instID[0][i], rays.hit.primID[i], rays.hit.u[i], rays.hit.v[i]};
        return result;
    }

    const int width_, height_;
    const std::span<const BakedInstance> instances_;
    const Background& background_;
    const RTCScene scene_;
    const Vec3f origin_;
    Vec3f corner_, right_, down_;  ///< Direction of the upper left corner, and the steps from pixel to pixel.
    std::vector<Sample> samples_;  ///< At the pixels' centres.
};

}  // namespace

Preview::Preview() : rays_(std::make_unique<Rays>()) {}
Preview::~Preview() = default;

Image Preview::draw(const Camera& camera, std::span<const BakedInstance> instances,
                    const Background& background, const BeforeReading& before_reading) {
    const OwnedScene scene = rays_->scene_of(instances);
    return Drawing(camera, instances, background, scene.get()).image(before_reading);
}

std::vector<std::optional<MeshPoint>> Preview::points(const Camera& camera,
                                                      std::span<const BakedInstance> instances) {
    const OwnedScene scene = rays_->scene_of(instances);
    return Drawing(camera, instances, {}, scene.get()).points();
}

std::vector<BakedInstance> preview_instances(const ShadedScene& scene, const SceneColours& radiance) {
    std::vector<BakedInstance> instances;
    for (const ShadedInstance& instance : scene.instances) {
        instances.push_back({"", scene.entities[instance.entity].mesh, instance.placement, {}});
        if (!radiance.empty()) instances.back().radiance = radiance[instances.size() - 1];
    }
    return instances;
}

std::vector<BakedInstance> preview_instances(const SceneEntities& entities, const ShadedScene& scene) {
    std::vector<BakedInstance> instances = preview_instances(scene);
    for (std::size_t i = 0; i < instances.size(); ++i)
        instances[i].surfaces = entities.entities[scene.instances[i].entity]->surfaces;
    return instances;
}

}  // namespace haarfield
