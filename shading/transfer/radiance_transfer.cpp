#include "shading/transfer/radiance_transfer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "fields/base/parallel_loop.h"
#include "shading/scene/vertex_loop.h"

namespace haarfield {

bool VertexTransfer::look_from(const InstanceVertex& at) {
    const ShadedInstance& instance = scene_.instances[at.instance];
    const ShadingPoint point = shading_point(scene_, instance, at.vertex);
    brdf = point.brdf;
    return visibility_.look(at.instance, at.vertex, point);
}

std::span<const WaveletBlock<3>> VertexTransfer::product(const LightPyramid& light,
                                                         const DetailWeights* detail) {
    blurred_energy_ = radiance_integrand(light, shaded(settings_.depth), memory_, product_, detail);
    return product_;
}

std::span<const WaveletBlock<3>> VertexTransfer::highlights(const LightPyramid& light, Rgb& diffuse,
                                                            const DetailWeights* detail) {
    const SpecularIntegrand found =
        specular_integrand(light, shaded(settings_.depth), memory_, product_, detail);
    blurred_energy_ = found.blurred_energy;
    diffuse = found.diffuse;
    return product_;
}

Rgb VertexTransfer::radiance(const LightPyramid& light, int depth) {
    return outgoing_radiance(light, shaded(depth), memory_).total();
}

Result<Done> make_rows(const VertexRows& rows, std::size_t block_rows,
                       const std::function<BlockMaker()>& make_maker, const Progress& progress) {
    return parallel_loop(
        {rows.count(), block_rows},
        [&]() -> LoopBody {
            return [&, make = make_maker()](std::size_t row) {
                const InstanceVertex vertex = rows[row];
                if (rows.is_buried(vertex))
                    make.add_buried();
                else
                    make.add_row(row, vertex);
                if ((row + 1) % block_rows == 0 || row + 1 == rows.count()) make.complete(row / block_rows);
            };
        },
        "radiance transfer", progress);
}

}  // namespace haarfield
