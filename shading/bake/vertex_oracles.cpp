#include "shading/bake/vertex_oracles.h"

#include <algorithm>
#include <bit>

#include "fields/rasterizer/visibility_transform.h"
#include "shading/bake/emitter_light.h"
#include "shading/bake/lamp_light.h"
#include "shading/scene/lighting.h"
#include "shading/visibility/vertex_visibility.h"

namespace haarfield {
namespace {

constexpr int finest_face_size = 256;

DenseLight truncated_light(const RgbCubemapTree& tree, DenseLight light) {
    light.light.clear();
    for (const RgbQuadtree& face : tree.faces) {
        const std::vector<Rgb> texels = quadtree_texels(face, light.face_size);
        light.light.insert(light.light.end(), texels.begin(), texels.end());
    }
    return light;
}

Rgb visible_radiance(std::span<const Vec3d> response, std::span<const float> visibility) {
    Vec3d sum(0.0);
    for (std::size_t i = 0; i < response.size(); ++i) sum += response[i] * double(visibility[i]);
    return Rgb(Vec3f(sum));
}

void multiply_by_tree(std::span<float> visibility, const WideCubemap<std::uint8_t>& tree, int face_size) {
    const std::size_t side = std::size_t(face_size);
    for (std::size_t i = 0; i < visibility.size(); ++i) {
        const WideFace<std::uint8_t>& face = tree[i / (side * side)];
        const unsigned row = unsigned(i / side % side), column = unsigned(i % side);
        // Faces of 2 x 4^l texels have only one quadtree level in the last nodes.
        int bit = 2 * wide_levels(face_size) - 2;
        const int lacking = 2 * wide_levels(face_size) - std::countr_zero(unsigned(face_size));
        float value = face.mean;
        for (const WideNode<std::uint8_t>* node = face.root; node; bit -= 2) {
            const auto quadrant = [&](int b) {
                return b < 0 ? 0u : (row >> b & 1u) << 1 | (column >> b & 1u);
            };
            const unsigned cell = quadrant(bit + 1 - lacking) << 2 | quadrant(bit - lacking);
            value = static_cast<float>(node->mean[cell]) / 255;
            node = node->varying >> cell & 1u ? child_of(node, cell) : nullptr;
        }
        visibility[i] *= value;
    }
}

/// Converts a cubemap's visibility to wide trees, as fields are.
class WideTree {
public:
    /// The result is valid until the next call.
    const WideCubemap<std::uint8_t>& operator()(const CubemapTree& tree) {
        nodes_.clear();
        std::array<std::size_t, cubemap_faces + 1> first{};
        for (std::size_t face = 0; face < cubemap_faces; ++face) {
            faces_[face].mean = converter_.append(tree.faces[face], nodes_);
            first[face + 1] = nodes_.size();
        }
        // The addresses of nodes are final only now.
        for (std::size_t face = 0; face < cubemap_faces; ++face)
            faces_[face].root = first[face + 1] > first[face] ? &nodes_[first[face]] : nullptr;
        return faces_;
    }

private:
    VisibilityConverter converter_;
    std::vector<WideNode<std::uint8_t>> nodes_;
    WideCubemap<std::uint8_t> faces_;
};

}  // namespace

OracleContext::OracleContext(const ShadedScene& of, std::span<const Mesh* const> meshes,
                             const RenderSettings& with, const ShadingGeometry& shared)
    : scene(of),
      settings(with),
      geometry(shared),
      light(scene.environment, settings.face_size, settings.sources),
      truncated(light),
      fine_light(scene.environment, std::min(4 * settings.face_size, finest_face_size), settings.sources),
      exact_pyramid(haar_cubemap<Rgb>(light.light, settings.face_size, {}), settings.face_size),
      baked_light(scene_light(scene, settings)) {
    for (const Mesh* mesh : meshes) originals.push_back(make_occluder(*mesh));
    truncated = truncated_light(
        haar_cubemap<Rgb>(light.light, settings.face_size, {settings.light_coefficients}), light);
}

class VertexOracles::Vertex {
public:
    explicit Vertex(const OracleContext& context)
        : context_(context),
          rasterizer_(context.light.face_size),
          fine_rasterizer_(context.fine_light.face_size),
          transform_(context.light.face_size),
          bake_visibility_(context.scene, context.geometry) {}

    OracleRadiances operator()(std::size_t instance, std::uint32_t vertex) {
        const ShadedScene& scene = context_.scene;
        entity_ = &scene.entities[scene.instances[instance].entity];
        point_ = surface_point(*entity_, vertex);
        const ShadedInstance& at = scene.instances[instance];
        at_ = shading_point(scene, at, point_);
        OracleRadiances result;
        result.baked = baked(instance, vertex);
        if (!list_occluders(instance)) return result;

        const std::vector<Vec3d> response = responses(context_.light);
        const std::vector<float> exact = seen([&](const SeenOccluder& s, std::span<float> v) { see(s, v); });
        result.oracle = visible_radiance(response, exact);
        result.lighting = visible_radiance(responses(context_.truncated), exact);
        result.original = visible_radiance(response, seen([&](const SeenOccluder& s, std::span<float> v) {
                                               see_original(s, v, rasterizer_);
                                           }));
        result.visibility = visible_radiance(
            response, seen([&](const SeenOccluder& s, std::span<float> v) { see_truncated(s, v); }));
        for (const bool planar : {true, false}) {
            bool found = false;
            (planar ? result.planar : result.spherical) =
                visible_radiance(response, seen([&](const SeenOccluder& s, std::span<float> v) {
                                     if (s.field && s.lookup.planar == planar) {
                                         see_interpolated(s, v);
                                         found = true;
                                     } else {
                                         see(s, v);
                                     }
                                 }));
            (planar ? result.has_planar : result.has_spherical) = found;
        }
        result.distant = visible_radiance(response, seen([&](const SeenOccluder& s, std::span<float> v) {
                                              result.has_distant |= s.impostor_of != nullptr;
                                              see_from_afar(s, v);
                                          }));
        result.lobes = walked(exact, full_depth);
        result.shallow = walked(exact, context_.settings.depth);

        const std::vector<Vec3d> fine_response = responses(context_.fine_light);
        result.finer =
            visible_radiance(fine_response, seen_finely([&](const SeenOccluder& s, std::span<float> v) {
                                 multiply_by_open(v, fine_rasterizer_.open_samples(s.coarse));
                             }));
        result.finest =
            visible_radiance(fine_response, seen_finely([&](const SeenOccluder& s, std::span<float> v) {
                                 see_original(s, v, fine_rasterizer_);
                             }));
        add_sources(result);
        return result;
    }

private:
    /// An occluder of the vertex.
    struct SeenOccluder {
        OccluderView coarse;
        OccluderView original;                   ///< The same view of the original mesh.
        const VisibilityField* field = nullptr;  ///< Null if it is not interpolated from a field.
        bool truncated = false;                  ///< True if the bake uses a truncated tree of it.
        Truncation truncation;
        FieldLookup lookup{};
        const ShadedInstance* impostor_of = nullptr;  ///< Null if it is not an impostor.
    };

    /// Returns false if the vertex is inside another instance.
    bool list_occluders(std::size_t instance) {
        const ShadedScene& scene = context_.scene;
        const auto truncation = [](const VisibilityField& field) {
            return Truncation{field.settings.coefficients, field.settings.relative_l2_error};
        };
        seen_.clear();
        const OccluderView own = own_view(scene, instance, point_.sample, at_);
        seen_.push_back({own,
                         with_original(own, instance),
                         nullptr,
                         !own.turn,
                         truncation(*entity_->field),
                         {},
                         nullptr});
        for (std::size_t i = 0; i < scene.instances.size(); ++i) {
            if (i == instance) continue;
            const ShadedInstance& other = scene.instances[i];
            const ShadedEntity& entity = scene.entities[other.entity];
            if (entity.occlusion->in_coarse()(other.placement.point_to_object(at_.outside))) return false;
            const OccluderView coarse = view_of(scene, i, at_);
            const std::span<const std::uint8_t> open = rasterizer_.open_samples(coarse);
            if (std::ranges::all_of(open, [](std::uint8_t n) { return n == samples_per_texel; })) continue;
            SeenOccluder seen{coarse, with_original(coarse, i), nullptr, false, truncation(*entity.field), {},
                              nullptr};
            const OcclusionKind visibility = occlusion_of(scene, context_.geometry, i, at_).visibility;
            if (visibility == OcclusionKind::distant && context_.geometry.impostors[other.entity])
                seen.impostor_of = &other;
            else if (visibility != OcclusionKind::exact) {
                seen.field = entity.field;
                seen.truncated = true;
                seen.lookup = field_lookup(*entity.field, other, at_);
            }
            seen_.push_back(seen);
        }
        return true;
    }

    OccluderView with_original(OccluderView view, std::size_t instance) const {
        view.occluder = &context_.originals[context_.scene.instances[instance].entity];
        return view;
    }

    std::vector<Vec3d> responses(const DenseLight& light) const {
        std::vector<Vec3d> result(light.directions.size());
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i] = light.radiance_from(i, entity_->materials[point_.material], at_).total();
        return result;
    }

    /// Returns the product of the visibilities around all occluders.
    template <class See>
    std::vector<float> seen(const See& see_past) const {
        std::vector<float> visibility(context_.light.directions.size(), 1.0f);
        for (const SeenOccluder& s : seen_) see_past(s, std::span(visibility));
        return visibility;
    }
    template <class See>
    std::vector<float> seen_finely(const See& see_past) const {
        std::vector<float> visibility(context_.fine_light.directions.size(), 1.0f);
        for (const SeenOccluder& s : seen_) see_past(s, std::span(visibility));
        return visibility;
    }

    void see(const SeenOccluder& seen, std::span<float> visibility) {
        multiply_by_open(visibility, rasterizer_.open_samples(seen.coarse));
    }
    void see_from_afar(const SeenOccluder& seen, std::span<float> visibility) {
        if (!seen.impostor_of) return see(seen, visibility);
        impostor_texels_.assign(visibility.size(), 255);
        context_.geometry.impostors[seen.impostor_of->entity]->hide(seen.impostor_of->placement, at_.outside,
                                                                    impostor_texels_);
        for (std::size_t i = 0; i < visibility.size(); ++i)
            visibility[i] *= static_cast<float>(impostor_texels_[i]) / 255;
    }
    static void see_original(const SeenOccluder& seen, std::span<float> visibility,
                             VisibilityRasterizer& rasterizer) {
        multiply_by_open(visibility, rasterizer.open_samples(seen.original));
    }
    void see_truncated(const SeenOccluder& seen, std::span<float> visibility) {
        if (!seen.truncated) return see(seen, visibility);
        transform_(rasterizer_.open_samples(seen.coarse), seen.coarse.horizon, seen.truncation, truncated_);
        multiply_by_tree(visibility, tree_(truncated_), context_.light.face_size);
    }
    void see_interpolated(const SeenOccluder& seen, std::span<float> visibility) {
        const Interpolation& samples = seen.lookup.samples;
        std::vector<float> sum(visibility.size(), samples.count == 0 ? 1.0f : samples.open);
        for (std::size_t k = 0; k < std::size_t(samples.count); ++k) {
            const Vec3f at = seen.lookup.planar ? seen.field->planar.sample_position(samples.sample[k]) +
                                                      planar_lift(*seen.field)
                                                : seen.field->spherical.sample_position(samples.sample[k]);
            const std::span<const std::uint8_t> open = rasterizer_.open_samples(*seen.coarse.occluder, at);
            for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += samples.weight[k] * open_fraction(open[i]);
        }
        for (std::size_t i = 0; i < sum.size(); ++i) visibility[i] *= sum[i];
    }

    /// Returns the radiance by the traversal of the bake, from exact visibility and lighting.
    Rgb walked(std::span<const float> visibility, int depth) {
        const WideCubemap<std::uint8_t>& tree =
            tree_(haar_cubemap<float>(visibility, context_.light.face_size));
        const WeightedTrees<std::uint8_t>::Part part{&tree, 1};
        const WeightedTrees<std::uint8_t> factor{0, {&part, 1}};
        return radiance(context_.exact_pyramid, {{&factor, 1}, {}}, depth).total();
    }

    /// Adds concentrated light and local light. Oracles use every part of the sources and fine patches of the
    /// emitters; `sources` and `baked` use those of the bake. The light of lamps is the same for all.
    void add_sources(OracleRadiances& result) const {
        const ShadowRays& rays = context_.geometry.rays;
        const Material& material = entity_->materials[point_.material];
        const auto sum = [&](std::span<const DirectionalLight> lights) {
            return Outgoing(radiance_from_parts(lights, rays, material, at_));
        };
        const SceneLight& light = context_.baked_light;
        Outgoing near(radiance_from_lamps(light.lamps, rays, material, at_));
        add_emitter_light(rays, light.emitters, {&at_, 1}, {&near, 1});
        const Outgoing finest(radiance_from_near(light.lamps, light.emitters, rays, material, at_));
        const Rgb all = (sum(context_.light.parts) + finest).total(),
                  few = (sum(light.lights) + near).total();
        result.sources = result.oracle + few;
        result.baked += few;
        for (Rgb OracleRadiances::*exact :
             {&OracleRadiances::oracle, &OracleRadiances::finer, &OracleRadiances::original,
              &OracleRadiances::finest, &OracleRadiances::lighting, &OracleRadiances::lobes,
              &OracleRadiances::visibility, &OracleRadiances::planar, &OracleRadiances::spherical,
              &OracleRadiances::distant, &OracleRadiances::shallow})
            result.*exact += all;
    }

    Rgb baked(std::size_t instance, std::uint32_t vertex) {
        if (!bake_visibility_.look(instance, vertex, at_)) return Rgb(0.0f);
        const RenderSettings& settings = context_.settings;
        return without_negative(
                   radiance(context_.baked_light.smooth, bake_visibility_.visibility(), settings.depth))
            .total();
    }

    Outgoing radiance(const LightPyramid& light, const VisibilityProduct& visibility, int depth) {
        return outgoing_radiance(light, {context_.geometry.directions, at_.brdf, visibility, depth}, memory_);
    }

    const OracleContext& context_;
    VisibilityRasterizer rasterizer_, fine_rasterizer_;
    VisibilityTransform transform_;
    CubemapTree truncated_;
    WideTree tree_;
    VertexVisibility bake_visibility_;
    WalkMemory<std::uint8_t> memory_;
    std::vector<std::uint8_t> impostor_texels_;
    const ShadedEntity* entity_ = nullptr;  ///< Entity of the current vertex.
    SurfacePoint point_;
    ShadingPoint at_;
    std::vector<SeenOccluder> seen_;  ///< Its own entity first.
};

VertexOracles::VertexOracles(const OracleContext& context) : vertex_(std::make_unique<Vertex>(context)) {}
VertexOracles::~VertexOracles() = default;

OracleRadiances VertexOracles::operator()(std::size_t instance, std::uint32_t vertex) {
    return (*vertex_)(instance, vertex);
}

}  // namespace haarfield
