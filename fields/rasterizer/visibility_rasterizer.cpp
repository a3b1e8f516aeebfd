#include "fields/rasterizer/visibility_rasterizer.h"

#include <algorithm>
#include <cassert>

#include "fields/base/aligned_buffer.h"
#include "fields/rasterizer/contour_rasterizer.h"
#include "fields/rasterizer/span_rasterizer.h"

namespace haarfield {

struct VisibilityRasterizer::Buffers {
    explicit Buffers(int face_size) : blocked(face_size), contoured(face_size) {}

    BlockedSamples blocked, contoured;
    VisibleContour contour;
    ContourScratch lines;
    SpanScratch spans;
    std::vector<std::uint8_t> open;
};

VisibilityRasterizer::VisibilityRasterizer(int face_size) {
    assert(is_face_size(face_size));
    buffers_ = std::make_unique<Buffers>(face_size);
    buffers_->open.resize(std::size_t(cubemap_faces * face_size) * std::size_t(face_size) +
                          widest_vector<std::uint8_t>);
}

VisibilityRasterizer::~VisibilityRasterizer() = default;
VisibilityRasterizer::VisibilityRasterizer(VisibilityRasterizer&&) noexcept = default;
VisibilityRasterizer& VisibilityRasterizer::operator=(VisibilityRasterizer&&) noexcept = default;

std::span<const std::uint8_t> VisibilityRasterizer::open_samples(const Occluder& occluder,
                                                                 const Vec3f& view_point,
                                                                 const Vec3f* horizon) {
    return open_samples(OccluderView{&occluder, view_point, horizon});
}

std::span<const std::uint8_t> VisibilityRasterizer::open_samples(std::span<const OccluderView> views) {
    auto& [blocked, contoured, contour, lines, spans, open] = *buffers_;
    for (std::size_t i = 0; i < views.size(); ++i) {
        const Occluder& occluder = *views[i].occluder;
        const ViewedOccluder viewed = look_at(occluder, views[i].point, views[i].horizon, views[i].turn);
        find_contour(occluder, viewed, contour);
        if (!block_contour(occluder, viewed, contour, lines, i == 0 ? blocked : contoured))
            std::fill(contour.left.begin(), contour.left.end(), ~std::uint64_t(0));
        else if (i > 0)
            add_contours(contoured, blocked);
        block_spans(occluder, viewed, contour.left.data(), spans, blocked);
    }
    count_open_samples(blocked, open.data());
    constexpr std::size_t faces = cubemap_faces;
    return {open.data(), faces * std::size_t(blocked.face_size) * std::size_t(blocked.face_size)};
}

}  // namespace haarfield
