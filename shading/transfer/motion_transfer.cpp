#include "shading/transfer/motion_transfer.h"

#include <tbb/parallel_for.h>

#include <memory>

#include "fields/base/parallel_loop.h"
#include "fields/field/field_precompute.h"
#include "shading/transfer/occlusion_vectors.h"
#include "shading/transfer/sparse_products.h"

namespace haarfield {
namespace {

/// Fractions of the pruning error for the occlusions and for the vectors.
constexpr double occlusion_share = 0.5, vector_share = 0.85;

constexpr int moving_depth = 4;  ///< Traversal depth of FrameQuality::moving.

struct MotionContext {
    const ShadedScene& scene;
    const ShadingGeometry& geometry;
    const RenderSettings& settings;
    const MotionTransfer& transfer;
    CoefficientSpectrum spectrum;
    double error;  ///< Relative.
};

class MotionBlockMaker {
public:
    explicit MotionBlockMaker(const MotionContext& context)
        : context_(context),
          vertex_(context.scene, context.geometry, context.settings, context.transfer.instance),
          rows_(context.settings.face_size, context.spectrum, context.error) {}

    void add_row(const InstanceVertex& vertex, Rgb& open) {
        if (vertex.instance == context_.transfer.instance || !vertex_.look_from(vertex))
            return rows_.append_empty();
        rows_.take(
            vertex_,
            [&](const DetailWeights* detail) { return vertex_.product(context_.transfer.light, detail); },
            [](const ProductPruning& product) {
                const Rgb whole = product.integral();
                return double(whole.dot(whole));
            });
        open = rows_.integral();
        rows_.append();
    }
    void add_buried() { rows_.append_empty(); }
    SparseVectors complete() { return rows_.complete(); }

private:
    const MotionContext& context_;
    VertexTransfer vertex_;
    PrunedRows rows_;
};

/// Computes the radiance of the moving instance's vertices that are not left out, by vertex.
Result<std::vector<Rgb>> own_radiance(const MotionTransfer& transfer, const ShadedScene& scene,
                                      const ShadingGeometry& geometry, const RenderSettings& settings,
                                      std::span<const std::uint8_t> left_out, const Progress& progress) {
    const std::size_t instance = transfer.instance;
    const std::vector<std::uint32_t>& order = geometry.entities[scene.instances[instance].entity].order;
    std::vector<Rgb> radiance(order.size(), Rgb(0.0f));
    HF_TRY_DONE(parallel_loop(
        {order.size(), 64},
        [&]() -> LoopBody {
            return [&, vertex = std::make_shared<VertexTransfer>(scene, geometry, settings)](std::size_t i) {
                const std::uint32_t v = order[i];
                if (left_out[v] || !vertex->look_from({instance, v})) return;
                radiance[v] = without_negative(vertex->radiance(transfer.light, settings.depth));
            };
        },
        "moving instance", {{}, progress.stop}));
    return radiance;
}

RenderSettings while_moving(RenderSettings settings) {
    settings.depth = moving_depth;
    settings.occlusion = Occlusion::fields;
    return settings;
}

/// Computes the radiance of all vertices of the moving instance.
Result<std::vector<Rgb>> whole_radiance(const MotionTransfer& transfer, const ShadedScene& scene,
                                        const ShadingGeometry& geometry, const RenderSettings& settings,
                                        const Progress& progress) {
    const std::size_t entity = scene.instances[transfer.instance].entity;
    Result<std::vector<Rgb>> radiance = own_radiance(
        transfer, scene, geometry, settings, scene.entities[entity].occlusion->samples().buried, progress);
    if (radiance) geometry.entities[entity].fill(*radiance);
    return radiance;
}

/// Computes the radiance of the moving instance during motion: the initial radiance plus the change,
/// interpolated between shaded vertices. Changes are smoother than radiance, because normals and
/// self-occlusion do not change.
Result<std::vector<Rgb>> changed_own_radiance(const MotionTransfer& transfer, const ShadedScene& scene,
                                              const ShadingGeometry& geometry, const RenderSettings& settings,
                                              const Progress& progress) {
    Result<std::vector<Rgb>> radiance =
        own_radiance(transfer, scene, geometry, while_moving(settings), transfer.left_out, progress);
    if (!radiance) return radiance;
    for (std::size_t v = 0; v < radiance->size(); ++v)
        if (!transfer.left_out[v]) (*radiance)[v] -= transfer.own[v];
    transfer.fill(*radiance);
    for (std::size_t v = 0; v < radiance->size(); ++v)
        (*radiance)[v] = without_negative(transfer.own[v] + (*radiance)[v]);
    return radiance;
}

/// Returns the occlusion of a row by the moving instance, with negative weights for subtraction. No samples
/// if it occludes nothing.
RowInterpolation shadow(const MotionTransfer& transfer, const ShadedScene& scene,
                        const ShadingGeometry& geometry, const MotionTransfer::Viewpoint& from) {
    RowInterpolation result{from.row, {}};
    const ShadingGeometry::Instance& moving = geometry.instances[transfer.instance];
    const float reach = geometry.reach * moving.radius;
    if (!((from.point.outside - moving.middle).length2() < reach * reach)) return result;
    if (is_below_horizon(scene, transfer.instance, from.point)) return result;
    const FieldLookup lookup = field_lookup(transfer.around, scene.instances[transfer.instance], from.point);
    result.at = lookup.samples;
    const auto first = lookup.planar ? 0u : transfer.around.planar.sample_count();
    for (std::size_t k = 0; k < std::size_t(result.at.count); ++k) {
        result.at.sample[k] += first;
        result.at.weight[k] = -result.at.weight[k];
    }
    return result;
}

/// The occlusion by the moving instance, as in MotionTransfer.
struct MovingOcclusion {
    VisibilityField around;
    SparseVectorBlocks occlusions;
};

/// Computes the occlusion by a field, and copies its samplers.
Result<MovingOcclusion> sampled_occlusion(const VisibilityField& field, const WideVisibility& visibility,
                                          double error, const Progress& progress) {
    HF_TRY(SparseVectorBlocks occlusions, occlusion_vectors(field, visibility, error, progress));
    VisibilityField around;
    around.bounds = field.bounds;
    around.planar = field.planar;
    around.spherical = field.spherical;
    return MovingOcclusion{std::move(around), std::move(occlusions)};
}

Result<MovingOcclusion> moving_occlusion(const ShadedScene& scene, const ShadingGeometry& geometry,
                                         std::size_t instance, double error, const Progress& progress) {
    const std::size_t entity = scene.instances[instance].entity;
    const Placement& placement = scene.instances[instance].placement;
    const VisibilityField& own = *scene.entities[entity].field;
    const bool has_samples = geometry.entities[entity].polygons.empty();
    if (has_samples && is_identity(placement.rotate))
        return sampled_occlusion(own, geometry.entities[entity].visibility, error, progress);
    FieldSettings wanted = own.settings;
    if (!has_samples) {
        wanted.planar_samples = FieldSettings().planar_samples;
        wanted.spherical_samples = FieldSettings().spherical_samples;
    }
    const InsideTest& is_inside = scene.entities[entity].occlusion->in_original();
    HF_TRY(
        const VisibilityField field,
        precompute_surroundings(
            own.entity, turned_occluder(scene.entities[entity].occlusion->coarse(), placement.rotate),
            [&](const Vec3f& point) { return is_inside(placement.rotate.back(point)); }, wanted, progress));
    HF_TRY(const WideVisibility visibility, WideVisibility::make(field, {}, progress.stop));
    return sampled_occlusion(field, visibility, error, progress);
}

}  // namespace

Result<MotionTransfer> motion_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                       const RenderSettings& settings, const TransferSettings& transfer,
                                       const RgbCubemapTree& light, std::vector<DirectionalLight> lights,
                                       std::size_t instance, const Progress& progress) {
    const std::size_t entity = scene.instances[instance].entity;
    HF_TRY(MovingOcclusion hidden,
           moving_occlusion(scene, geometry, instance, double(transfer.pruning_error) * occlusion_share,
                            progress));
    const VertexRows rows(scene, geometry);
    const Mesh& mesh = *scene.entities[entity].mesh;
    const std::vector<std::uint8_t> left_out =
        left_out_vertices(mesh, scene.entities[entity].occlusion->samples().buried);
    MotionTransfer result{instance,
                          std::move(hidden.around),
                          {rows.count(), settings.face_size, 3},
                          std::vector<Rgb>(rows.count(), Rgb(0.0f)),
                          {},
                          {},
                          std::move(hidden.occlusions),
                          {},
                          left_out,
                          BuriedFill(mesh, left_out),
                          LightPyramid(light, settings.face_size)};
    const MotionContext context{scene,
                                geometry,
                                settings,
                                result,
                                rms_spectrum(result.occlusions),
                                double(transfer.pruning_error) * vector_share};
    HF_TRY_DONE(make_rows(
        rows, SparseVectorBlocks::block_rows,
        [&]() -> BlockMaker {
            const auto maker = std::make_shared<MotionBlockMaker>(context);
            return {[&, maker](std::size_t row, const InstanceVertex& vertex) {
                        maker->add_row(vertex, result.open[row]);
                    },
                    [maker] { maker->add_buried(); },
                    [&, maker](std::size_t block) { result.vectors.blocks[block] = maker->complete(); }};
        },
        progress));
    HF_TRY(result.sources,
           static_sources(scene, geometry, instance, std::move(lights), result.open, progress));
    HF_TRY(result.own, whole_radiance(result, scene, geometry, while_moving(settings), progress));
    std::vector<std::uint32_t> shaded;
    for (std::uint32_t row = 0; row < rows.count(); ++row)
        if (!result.vectors.is_empty(row)) shaded.push_back(row);
    result.viewpoints.resize(shaded.size());
    tbb::parallel_for(std::size_t(0), shaded.size(), [&](std::size_t i) {
        const auto [at, vertex] = rows[shaded[i]];
        result.viewpoints[i] = {shaded[i], shading_point(scene, scene.instances[at], vertex)};
    });
    return result;
}

Result<Done> shade_frame(const MotionTransfer& transfer, const ShadedScene& scene,
                         const ShadingGeometry& geometry, const RenderSettings& settings,
                         FrameQuality quality, SceneColours& radiance, const Progress& progress) {
    const RowInterpolations shadows = found_interpolations(
        transfer.viewpoints.size(), progress.stop,
        [&](std::size_t i) { return shadow(transfer, scene, geometry, transfer.viewpoints[i]); });
    std::vector<Rgb> by_row = transfer.open;
    HF_TRY_DONE(
        add_interpolated_products(transfer.vectors, transfer.occlusions, shadows, by_row, progress.stop));
    HF_TRY(std::vector<Rgb> own, quality == FrameQuality::moving
                                     ? changed_own_radiance(transfer, scene, geometry, settings, progress)
                                     : whole_radiance(transfer, scene, geometry, settings, progress));
    HF_TRY_DONE(move_in_sources(transfer.sources, scene, geometry, by_row, progress));
    store_radiance(scene, geometry, by_row, radiance);
    // Rows of the moving instance contain only the light of the sources.
    std::vector<Rgb>& moving = radiance[transfer.instance];
    for (std::size_t v = 0; v < moving.size(); ++v) moving[v] += own[v];
    return Done{};
}

}  // namespace haarfield
