#include "fields/visibility_rasterizer.h"

#include <cassert>

#include "fields/contour_rasterizer.h"
#include "fields/span_rasterizer.h"

namespace haarfield {

struct VisibilityRasterizer::Buffers {
    explicit Buffers(int face_size) : blocked(face_size) {}

    BlockedSamples blocked;
    ViewedOccluder viewed;
    SpanScratch spans;
    ContourScratch contours;
    std::vector<std::uint8_t> open;
};

VisibilityRasterizer::VisibilityRasterizer(int face_size) {
    assert(is_face_size(face_size));
    buffers_ = std::make_unique<Buffers>(face_size);
    buffers_->open.resize(std::size_t(cubemap_faces * face_size) * std::size_t(face_size));
}

VisibilityRasterizer::~VisibilityRasterizer() = default;
VisibilityRasterizer::VisibilityRasterizer(VisibilityRasterizer&&) noexcept = default;
VisibilityRasterizer& VisibilityRasterizer::operator=(VisibilityRasterizer&&) noexcept = default;

std::span<const std::uint8_t> VisibilityRasterizer::open_samples(const Occluder& occluder,
                                                                 const Vec3f& view_point,
                                                                 const Vec3f* horizon) {
    const auto count = static_cast<std::uint32_t>(occluder.triangles.size());
    auto& [blocked, viewed, spans, contours, open] = *buffers_;
    look_at(occluder, view_point, horizon, viewed);
    if (occluder.one_sided == count &&
        open_samples_by_contour(occluder, viewed, view_point, contours, blocked.face_size, open))
        return open;
    block_spans(occluder, 0, count, viewed, spans, blocked);
    count_open_samples(blocked, open.data());
    return open;
}

}  // namespace haarfield
