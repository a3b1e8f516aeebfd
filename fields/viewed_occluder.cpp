#include "fields/viewed_occluder.h"

#include <cstring>

#include "fields/view_frame.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/viewed_occluder.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A cap, so that vectors never exceed the padding; below it the length is the machine's.
using Floats = hn::CappedTag<float, 16>;
using VF = hn::Vec<Floats>;

/// Vertices from the view point, with their outcodes.
void relative_vertices(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon, float* out) {
    const Floats d;
    const hn::RebindToSigned<Floats> di;
    const std::size_t lanes = hn::Lanes(d), count = occluder.positions.size();
    const VF ox = hn::Set(d, view_point.x), oy = hn::Set(d, view_point.y), oz = hn::Set(d, view_point.z);
    const Vec3f normal = horizon ? *horizon : Vec3f(0.0f);
    const VF nx = hn::Set(d, normal.x), ny = hn::Set(d, normal.y), nz = hn::Set(d, normal.z);
    const VF low = hn::Set(d, horizon ? 1e-5f * occluder.bounds.radius() : -1.0f);
    const SoaPoints& points = occluder.soa_positions;
    // So that no vertex lies on a plane x = 0, y = 0 or z = 0, and each is on one side for all who ask.
    const VF almost_zero = hn::Set(d, -1e-30f), zero = hn::Zero(d);
    const auto from = [&](const std::vector<float>& coordinates, std::size_t v, VF origin) {
        const VF difference = hn::Sub(hn::LoadU(d, coordinates.data() + v), origin);
        return hn::IfThenElse(hn::Eq(difference, zero), almost_zero, difference);
    };
    const auto bit_if = [&](auto mask, int bit) {
        return hn::IfThenElseZero(hn::RebindMask(di, mask), hn::Set(di, bit));
    };
    const auto pair = [&](VF a, VF b, int shift) {
        const VF minus = hn::Neg(b);
        return hn::Or(hn::Or(bit_if(hn::Gt(a, b), 1 << shift), bit_if(hn::Lt(a, b), 2 << shift)),
                      hn::Or(bit_if(hn::Gt(a, minus), 4 << shift), bit_if(hn::Lt(a, minus), 8 << shift)));
    };
    for (std::size_t v = 0; v < count; v += lanes) {
        const VF x = from(points.x, v, ox), y = from(points.y, v, oy), z = from(points.z, v, oz);
        auto code = hn::Or(hn::Or(pair(x, y, 0), pair(x, z, 4)), pair(y, z, 8));
        const VF height = hn::Add(hn::Add(hn::Mul(nx, x), hn::Mul(ny, y)), hn::Mul(nz, z));
        code = hn::Or(code, bit_if(hn::Le(height, low), below_horizon));
        hn::StoreInterleaved4(x, y, z, hn::BitCast(d, code), d, out + 4 * v);
    }
}

// A triangle of altitude a, seen from the height h above its plane at the distance r, looks  a h / r^2  wide.
// The error of a side's image is a few times the rounding error of a float, divided by the sine of the angle
// between side and ray; by the same sine the triangle's other extent looks shorter, so that of two errors'
// product with it a comparison of a h with a multiple of r^2 is left.
void see_facing(const Occluder& occluder, const Vec3f& view_point, ViewedOccluder& viewed) {
    constexpr double thinnest = 5e-7;  // [rad]
    const Floats d;
    const std::size_t lanes = hn::Lanes(d);
    const Vec3d from_centre = Vec3d(view_point) - occluder.planes_centre;
    const Vec3f p(from_centre);
    const double farthest = from_centre.length() + occluder.bounds.radius();
    const VF px = hn::Set(d, p.x), py = hn::Set(d, p.y), pz = hn::Set(d, p.z);
    const VF limit = hn::Set(d, static_cast<float>(thinnest * farthest * farthest));
    const SoaPlanes& planes = occluder.planes;
    const auto word_part = [&](auto mask) {
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(d, mask, bytes);
        std::uint64_t part;
        std::memcpy(&part, bytes, sizeof part);
        return part;
    };
    for (std::size_t first = 0; first < occluder.triangles.size(); first += 64) {
        std::uint64_t front = 0, back = 0, thin = 0;
        for (std::size_t i = 0; i < 64; i += lanes) {
            const std::size_t t = first + i;
            const VF height = hn::Add(hn::Add(hn::Mul(hn::LoadU(d, planes.x.data() + t), px),
                                              hn::Mul(hn::LoadU(d, planes.y.data() + t), py)),
                                      hn::Mul(hn::LoadU(d, planes.z.data() + t), pz));
            const VF offset = hn::LoadU(d, planes.offset.data() + t);
            front |= word_part(hn::Gt(height, offset)) << i;
            back |= word_part(hn::Lt(height, offset)) << i;
            thin |= word_part(hn::Le(hn::Abs(hn::Sub(height, offset)), limit)) << i;
        }
        viewed.front.data()[first / 64] = front;
        viewed.back.data()[first / 64] = back;
        viewed.thin.data()[first / 64] = thin & (front | back);
    }
}

void look_at(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon,
             ViewedOccluder& viewed) {
    const std::size_t words = occluder.triangles.size() / 64 + 1;
    viewed.vertices.reserve(4 * (occluder.positions.size() + 16));
    for (AlignedBuffer<std::uint64_t>* bits : {&viewed.front, &viewed.back, &viewed.thin})
        bits->reserve(words);
    viewed.view_point = view_point;
    viewed.horizon = horizon != nullptr;
    relative_vertices(occluder, view_point, horizon, viewed.vertices.data());
    see_facing(occluder, view_point, viewed);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(look_at);

void look_at(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon,
             ViewedOccluder& viewed) {
    HWY_DYNAMIC_DISPATCH(look_at)(occluder, view_point, horizon, viewed);
}

}  // namespace haarfield
#endif
