#include "tests/baselines/scene_integrals.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/wavelets/haar_transform.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_shading.h"
#include "shading/scene/light_sources.h"
#include "shading/scene/lighting.h"
#include "shading/scene/lobes.h"
#include "shading/scene/sky.h"
#include "shading/scene/vertex_loop.h"
#include "tests/fixtures/relative_error.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield::baseline {
namespace {

struct VertexIndex {
    std::size_t instance;
    std::uint32_t vertex;
};

/// Computes the texels of one vertex at a time.
class VertexSampler {
public:
    VertexSampler(const ShadedScene& scene, int face_size)
        : scene_(scene), size_(face_size), directions_(texel_directions(face_size)), rasterizer_(face_size) {}

    /// Returns nothing if the vertex is buried or inside another object.
    std::vector<std::vector<float>> operator()(const VertexIndex& index, VertexTexels& vertex) {
        const ShadedInstance& instance = scene_.instances[index.instance];
        const EntityOcclusion& own = *scene_.entities[instance.entity].occlusion;
        const VertexBrdf view = shading_point(scene_, instance, index.vertex).brdf;
        const Vec3f local = own.samples().points[index.vertex];
        vertex = {index.instance, instance.placement.point_to_world(local), view.normal, view.mirror, {}};
        if (own.samples().buried[index.vertex]) return {};

        std::vector<std::vector<float>> factors{visibility(own.own(), local, &view.normal),
                                                brdf(view.mirror)};
        for (std::size_t i = 0; i < directions_.size(); ++i)
            factors[0][i] *= std::max(0.0f, directions_[i].dot(view.normal));
        std::vector<std::pair<double, std::vector<float>>> others;
        for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
            if (i == index.instance) continue;
            const ShadedInstance& other = scene_.instances[i];
            const EntityOcclusion& occlusion = *scene_.entities[other.entity].occlusion;
            const Vec3f point = other.placement.point_to_object(vertex.point);
            if (occlusion.in_coarse()(point)) return {};
            std::vector<float> texels = visibility(occlusion.coarse(), point, nullptr);
            const double open = std::accumulate(texels.begin(), texels.end(), 0.0);
            others.emplace_back(open, std::move(texels));
        }
        std::stable_sort(others.begin(), others.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        for (auto& [open, texels] : others) factors.push_back(std::move(texels));
        return factors;
    }

private:
    std::vector<float> visibility(const Occluder& occluder, const Vec3f& point, const Vec3f* horizon) {
        const auto open = rasterizer_.open_samples(occluder, point, horizon);
        std::vector<float> texels(open.size());
        std::transform(open.begin(), open.end(), texels.begin(),
                       [](std::uint8_t count) { return static_cast<float>(count) / samples_per_texel; });
        return texels;
    }

    std::vector<float> brdf(const Vec3f& mirror) const {
        const auto over_pi = static_cast<float>(1 / pi);
        std::vector<float> texels = lobe_texels(brdf_shininess, mirror, size_);
        for (float& texel : texels)
            texel = (brdf_diffuse + brdf_specular * (brdf_shininess + 2) / 2 * texel) * over_pi;
        return texels;
    }

    const ShadedScene& scene_;
    int size_;
    std::vector<Vec3f> directions_;
    VisibilityRasterizer rasterizer_;
};

/// Returns, per channel, the sum of light times the first `count` factors, as a mean over each face's texels.
Vec3d texel_sum(std::span<const Rgb> light, std::span<const std::vector<float>> factors) {
    Vec3d sum(0.0);
    for (std::size_t i = 0; i < light.size(); ++i) {
        double product = 1;
        for (const auto& factor : factors) product *= double(factor[i]);
        sum += Vec3d(light[i]) * product;
    }
    return sum / (double(light.size()) / cubemap_faces);
}

}  // namespace

const ShippedScene& shipped_scene() {
    static const ShippedScene& scene = *[] {
        auto* made = new ShippedScene;
        made->description = value_or_exit(read_scene(HAARFIELD_SOURCE_DIR "/scenes/table_and_chairs.toml"));
        SceneEntityOptions options;
        options.fields = FieldExtent::none;
        made->entities = value_or_exit(prepare_scene_entities(made->description, options));
        made->shaded = shaded_scene(made->description, made->entities,
                                    sky_image(*made->description.environment.sky, 1024));
        return made;
    }();
    return scene;
}

Scene with_vertices(Scene scene, std::size_t vertices) {
    std::size_t fine_vertices = 0;
    for (const Instance& instance : scene.instances)
        fine_vertices += scene.entities[instance.entity].fine_vertices;
    for (Entity& entity : scene.entities)
        entity.fine_vertices = static_cast<std::uint32_t>(entity.fine_vertices * vertices / fine_vertices);
    return scene;
}

TexelIntegrals texel_integrals(int face_size, std::size_t count, StudiedLight light) {
    const ShadedScene& scene = shipped_scene().shaded;
    std::vector<VertexIndex> all;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const std::size_t vertices = scene.entities[scene.instances[i].entity].mesh->positions.size();
        for (std::uint32_t v = 0; v < vertices; ++v) all.push_back({i, v});
    }
    TexelIntegrals integrals;
    integrals.face_size = face_size;
    integrals.light = lighting_texels(
        light == StudiedLight::whole
            ? scene.environment.image
            : split_light(sky_environment(*shipped_scene().description.environment.sky, 1024)).smooth,
        face_size);
    VertexSampler sampler(scene, face_size);
    for (std::size_t k = 0; integrals.vertices.size() < count && k < all.size(); ++k) {
        // The golden ratio distributes any number of vertices evenly.
        const double place = double(k) * 0.6180339887498949;
        const auto index = static_cast<std::size_t>((place - std::floor(place)) * double(all.size()));
        VertexTexels vertex;
        vertex.factors = sampler(all[index], vertex);
        if (vertex.factors.empty() || texel_sum(integrals.light, vertex.factors) == Vec3d(0.0)) continue;
        integrals.vertices.push_back(std::move(vertex));
    }
    return integrals;
}

TexelIntegrals coarser(const TexelIntegrals& integrals) {
    const auto half = [size = std::size_t(integrals.face_size)]<class T>(const std::vector<T>& texels) {
        std::vector<T> means;
        means.reserve(texels.size() / 4);
        // Faces are contiguous, so their rows are those of one tall picture.
        for (std::size_t row = 0; row < cubemap_faces * size; row += 2)
            for (std::size_t column = 0; column < size; column += 2) {
                const T* upper = &texels[row * size + column];
                means.push_back((upper[0] + upper[1] + upper[size] + upper[size + 1]) * 0.25f);
            }
        return means;
    };
    TexelIntegrals made{integrals.face_size / 2, half(integrals.light), integrals.vertices};
    for (VertexTexels& vertex : made.vertices)
        for (std::vector<float>& factor : vertex.factors) factor = half(factor);
    return made;
}

TreeIntegrals tree_integrals(const TexelIntegrals& integrals, int functions, const KeptWavelets& kept) {
    const auto factors = static_cast<std::size_t>(functions - 1);
    TreeIntegrals trees;
    trees.face_size = integrals.face_size;
    trees.light = haar_cubemap<Rgb>(integrals.light, integrals.face_size, {kept.light});
    trees.vertices.resize(integrals.vertices.size());
    tbb::parallel_for(std::size_t(0), trees.vertices.size(), [&](std::size_t v) {
        for (std::size_t i = 0; i < factors; ++i)
            trees.vertices[v].push_back(
                haar_cubemap<float>(integrals.vertices[v].factors[i], integrals.face_size, {kept.others}));
    });
    return trees;
}

std::vector<Vec3d> texel_sums(const TexelIntegrals& integrals, int functions) {
    std::vector<Vec3d> sums;
    for (const VertexTexels& vertex : integrals.vertices)
        sums.push_back(texel_sum(integrals.light,
                                 std::span(vertex.factors).first(static_cast<std::size_t>(functions - 1))));
    return sums;
}

std::vector<Vec3d> texel_sums(const TreeIntegrals& integrals, int depth) {
    std::array<std::array<reference::Texels, 3>, cubemap_faces> light;
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        for (std::size_t c = 0; c < 3; ++c)
            light[face][c] =
                reference::texels_of(integrals.light.faces[face], int(c), integrals.face_size, depth);
    std::vector<Vec3d> sums(integrals.vertices.size(), Vec3d(0.0));
    for (std::size_t v = 0; v < sums.size(); ++v)
        for (std::size_t face = 0; face < cubemap_faces; ++face) {
            std::vector<reference::Texels> factors;
            for (const CubemapTree& factor : integrals.vertices[v])
                factors.push_back(reference::texels_of(factor.faces[face], integrals.face_size, depth));
            const reference::Texels product = reference::product(factors);
            for (std::size_t c = 0; c < 3; ++c)
                sums[v][int(c)] += reference::mean(reference::product(std::vector{product, light[face][c]}));
        }
    return sums;
}

double relative_rmse(std::span<const Rgb> found, std::span<const Vec3d> wanted) {
    RelativeError sum;
    for (std::size_t i = 0; i < wanted.size(); ++i) sum.add(Vec3d(found[i]), wanted[i]);
    return sum.rmse();
}

}  // namespace haarfield::baseline
