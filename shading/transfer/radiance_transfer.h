#pragma once
/// Just-in-time radiance transfer: all factors of the product integral except one are combined into a sparse
/// vector per vertex. Each frame is then one inner product per vertex.
///
///     light_transfer.h    the light changes
///     view_transfer.h     the eye moves
///     motion_transfer.h   an instance moves
///
/// source  Sun and Mukherjee 2006, sections 5.2 and 6.3. Difference: a vector is pruned by its future factor,
///         to an error that the user chooses.
///
/// Rows    vertex_rows.h. Buried vertices have empty rows. In each frame they receive the mean of their
///         neighbours, as in scene_radiance.

#include <functional>

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/bake/renderer.h"
#include "shading/transfer/product_pruning.h"
#include "shading/transfer/sparse_vectors.h"
#include "shading/visibility/vertex_rows.h"
#include "shading/visibility/vertex_visibility.h"

namespace haarfield {

/// The accuracy of transfer vectors.
struct TransferSettings {
    /// Relative change of a vertex's radiance by pruning: root mean square over functions whose coefficients
    /// are independent and have the average magnitude of their level. 0: no pruning.
    float pruning_error = 0.008f;
};

/// The quality of frames.
enum class FrameQuality {
    moving,  ///< For interactive dragging. Shadow rays go to fewer lights. Vertices of a moving instance are
             ///< shaded to depth 4 with occlusion by fields, at one vertex or more of each triangle; their
             ///< radiance errs by 4 to 8 % (RMSE, of a chair). With variable light, all bounces except the
             ///< first use the light of the previous frame. If the light varies by less than 3 %, the first
             ///< bounce at every other vertex does, too.
    still,   ///< Full quality.
};

/// Computes products for transfer vectors, for one thread.
class VertexTransfer {
public:
    /// The referenced objects must outlive it.
    ///
    /// without  an instance to be ignored.
    VertexTransfer(const ShadedScene& scene, const ShadingGeometry& geometry, const RenderSettings& settings,
                   std::size_t without = VertexVisibility::no_instance)
        : scene_(scene),
          geometry_(geometry),
          settings_(settings),
          visibility_(scene, geometry, settings.occlusion != Occlusion::fields, without) {}

    /// Sets the current vertex. Returns false if it is inside another instance and therefore black.
    bool look_from(const InstanceVertex& vertex);

    /// BRDF of the current vertex; may be changed for subsequent products.
    VertexBrdf brdf;

    /// Returns the radiance_integrand (vertex_shading.h) of the current vertex; valid until the next call.
    std::span<const WaveletBlock<3>> product(const LightPyramid& light,
                                             const DetailWeights* detail = nullptr);

    /// Returns the specular_integrand (vertex_shading.h) of the current vertex, and its diffuse radiance;
    /// valid until the next call.
    std::span<const WaveletBlock<3>> highlights(const LightPyramid& light, Rgb& diffuse,
                                                const DetailWeights* detail = nullptr);

    /// Returns a bound on the energy omitted from the last product.
    double blurred_energy() const { return blurred_energy_; }

    /// Computes the transfer_terms (vertex_shading.h) of the current vertex.
    template <int count>
    void terms(const BlockNumbers& numbers, std::vector<WaveletBlock<count>>& product) {
        transfer_terms(numbers, shaded(settings_.depth), memory_, product);
    }
    Rgb radiance(const LightPyramid& light, int depth);  ///< Outgoing radiance of the vertex. [W/(m^2 sr)]

private:
    ShadedVertex shaded(int depth) const {
        return {geometry_.directions, brdf, visibility_.visibility(), depth};
    }

    const ShadedScene& scene_;
    const ShadingGeometry& geometry_;
    const RenderSettings& settings_;
    VertexVisibility visibility_;
    WalkMemory<std::uint8_t> memory_;
    std::vector<WaveletBlock<3>> product_;
    double blurred_energy_ = 0;
};

/// Makes blocks of pruned RGB vectors, for one thread.
///
/// Details that would be pruned are not computed: they receive a quarter of the allowed error, which is
/// estimated from the previous vertex. If the estimate was too large, the product is computed again.
class PrunedRows {
public:
    /// error  of pruning, relative to a vertex's energy.
    PrunedRows(int face_size, const CoefficientSpectrum& spectrum, double error)
        : spectrum_(spectrum), error_(error), pruning_(face_size, spectrum), rows_(face_size, 3) {}

    /// Sets the current product, of a vertex.
    ///
    /// product_of  takes the details that may be omitted, or null; returns the product of the vertex.
    /// energy_of   takes ProductPruning with the current product; returns the energy of the vertex.
    template <class ProductOf, class EnergyOf>
    void take(const VertexTransfer& vertex, const ProductOf& product_of, const EnergyOf& energy_of) {
        const DetailWeights detail = detail_weights(spectrum_, blurred_share * allowed_ / typical_cells);
        pruning_.take(product_of(allowed_ > 0 ? &detail : nullptr));
        allowed_ = error_ * error_ * energy_of(pruning_);
        if (vertex.blurred_energy() <= blurred_share * allowed_) return;
        pruning_.take(product_of(nullptr));
        allowed_ = error_ * error_ * energy_of(pruning_);
    }

    /// Returns the integral of the current product.
    Rgb integral() const { return pruning_.integral(); }
    /// Appends a row with the pruned current product.
    void append() { pruning_.append((1 - blurred_share) * allowed_, rows_); }
    void append_empty() { rows_.append_empty(); }  ///< Appends the zero function.
    /// Returns the rows so far. The next block starts without them and does not depend on their vertices.
    SparseVectors complete() {
        SparseVectors block(rows_);
        rows_.clear();
        allowed_ = 0;
        return block;
    }

private:
    static constexpr double blurred_share = 0.25;
    static constexpr double typical_cells = 128;  ///< Number of cells whose details are omitted.

    CoefficientSpectrum spectrum_;
    double error_;
    ProductPruning pruning_;
    double allowed_ = 0;  ///< Energy that may be dropped at the current vertex.
    SparseVectors rows_;
};

/// Makes transfer vectors for one thread, block by block.
struct BlockMaker {
    std::function<void(std::size_t row, const InstanceVertex& vertex)> add_row;
    std::function<void()> add_buried;                 ///< Adds a row without coefficients.
    std::function<void(std::size_t block)> complete;  ///< Completes a block of the rows since the last call.
};

/// Makes all rows of a scene, in parallel on oneTBB.
///
/// make_maker  makes a BlockMaker with buffers for one thread.
/// errors      interrupted.
Result<Done> make_rows(const VertexRows& rows, std::size_t block_rows,
                       const std::function<BlockMaker()>& make_maker, const Progress& progress);

}  // namespace haarfield
