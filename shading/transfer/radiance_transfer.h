#pragma once
/// Just-in-time radiance transfer: all factors of the product integral but one are folded into a sparse
/// vector per vertex, once; then a frame is one inner product per vertex.
///
///     light_transfer.h    the light changes
///     view_transfer.h     the eye moves
///     motion_transfer.h   an instance moves
///
/// source  Sun and Mukherjee 2006, sections 5.2 and 6.3. Ours: a vector is pruned by what it will be
///         multiplied with, to an error that the user chooses.
///
/// Rows    vertex_rows.h. Buried vertices have empty rows; in each frame they take the mean of their
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

/// How much is left of transfer vectors.
struct TransferSettings {
    /// By how much pruning may change a vertex's radiance: relative, root mean square over functions whose
    /// coefficients are independent and as large as the average of their level. 0: nothing is pruned.
    float pruning_error = 0.008f;
};

/// How exactly a frame shows what changes in leaps.
enum class FrameQuality {
    moving,  ///< For while something is dragged. Shadow rays go to fewer lights; and vertices of an instance
             ///< that moves are shaded four levels deep, past the others by their fields, at one vertex of
             ///< each triangle or more: they err by 4 to 8 % (RMSE, of a chair). Where the light varies, all
             ///< bounces but the first are of the light of the frame before; where it varies by less than
             ///< 3 %, so is the first one at every other vertex.
    still,   ///< All that there is.
};

/// One thread's way from a vertex to its transfer vector.
class VertexTransfer {
public:
    /// What the references are of must outlive it.
    ///
    /// without  an instance that is not there.
    VertexTransfer(const ShadedScene& scene, const ShadingGeometry& geometry, const RenderSettings& settings,
                   std::size_t without = VertexVisibility::no_instance)
        : scene_(scene),
          geometry_(geometry),
          settings_(settings),
          visibility_(scene, geometry, settings.occlusion != Occlusion::fields, without) {}

    /// Takes up a vertex; false if it sees nothing.
    bool look_from(const InstanceVertex& vertex);

    /// What the vertex does with light; to be changed for the products that follow.
    VertexBrdf brdf;

    /// radiance_integrand of vertex_shading.h; valid until the next call.
    std::span<const WaveletBlock<3>> product(const LightPyramid& light,
                                             const DetailWeights* detail = nullptr);

    /// highlight_integrand of vertex_shading.h, whose radiance of the rest is `diffuse`; valid until the next
    /// call.
    std::span<const WaveletBlock<3>> highlights(const LightPyramid& light, Rgb& diffuse,
                                                const DetailWeights* detail = nullptr);

    /// A bound on what the last product left out.
    double blurred_energy() const { return blurred_energy_; }

    /// transfer_terms of vertex_shading.h.
    template <int count>
    void terms(const BlockNumbers& numbers, std::vector<WaveletBlock<count>>& product) {
        transfer_terms(numbers, shaded(settings_.depth), memory_, product);
    }
    Rgb radiance(const LightPyramid& light, int depth);  ///< Outgoing radiance of the vertex. [W/(m^2 sr)]

private:
    ShadedVertex shaded(int depth) const { return {geometry_.directions, brdf, visibility_.sight(), depth}; }

    const ShadedScene& scene_;
    const ShadingGeometry& geometry_;
    const RenderSettings& settings_;
    VertexVisibility visibility_;
    WalkMemory<std::uint8_t> memory_;
    std::vector<WaveletBlock<3>> product_;
    double blurred_energy_ = 0;
};

/// One thread's way from vertices to blocks of pruned RGB vectors.
///
/// Details that are certain to be pruned are not even computed: a quarter of the error is theirs, and what it
/// is is known, nearly, from the vertex before. Where that was too much the product is made once more.
class PrunedRows {
public:
    /// error  of pruning, relative to a vertex's energy.
    PrunedRows(int face_size, const CoefficientSpectrum& spectrum, double error)
        : spectrum_(spectrum), error_(error), pruning_(face_size, spectrum), rows_(face_size, 3) {}

    /// Takes up a product of a vertex.
    ///
    /// product_of  from details that may be left out, or null, to a product of the vertex.
    /// energy_of   from ProductPruning, with the product at hand, to the vertex's energy.
    template <class ProductOf, class EnergyOf>
    void take(const VertexTransfer& vertex, const ProductOf& product_of, const EnergyOf& energy_of) {
        const DetailWeights detail = detail_weights(spectrum_, blurred_share * allowed_ / typical_cells);
        pruning_.take(product_of(allowed_ > 0 ? &detail : nullptr));
        allowed_ = error_ * error_ * energy_of(pruning_);
        if (vertex.blurred_energy() <= blurred_share * allowed_) return;
        pruning_.take(product_of(nullptr));
        allowed_ = error_ * error_ * energy_of(pruning_);
    }

    /// Of the product at hand.
    Rgb integral() const { return pruning_.integral(); }
    /// A row of what is left of it.
    void append() { pruning_.append((1 - blurred_share) * allowed_, rows_); }
    void append_empty() { rows_.append_empty(); }
    /// The rows so far. The next block begins without them, and depends on none of their vertices.
    SparseVectors complete() {
        SparseVectors block(rows_);
        rows_.clear();
        allowed_ = 0;
        return block;
    }

private:
    static constexpr double blurred_share = 0.25;
    static constexpr double typical_cells = 128;  ///< That are blurred.

    CoefficientSpectrum spectrum_;
    double error_;
    ProductPruning pruning_;
    double allowed_ = 0;  ///< Energy, of the vertex at hand.
    SparseVectors rows_;
};

/// One thread's way to the transfer vectors: makes one block of rows after another.
struct BlockMaker {
    std::function<void(std::size_t row, const InstanceVertex& vertex)> add_row;
    std::function<void()> add_buried;                 ///< A row without coefficients.
    std::function<void(std::size_t block)> complete;  ///< The rows since the last call are a block.
};

/// Makes all rows of a scene, by all of oneTBB's threads.
///
/// make_maker  makes a BlockMaker for one thread, with that thread's buffers.
/// errors      interrupted.
Result<Done> make_rows(const VertexRows& rows, std::size_t block_rows,
                       const std::function<BlockMaker()>& make_maker, const Progress& progress);

}  // namespace haarfield
