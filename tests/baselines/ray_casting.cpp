#include "tests/baselines/ray_casting.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>

#include "fields/base/embree_rays.h"

namespace haarfield::baseline {
namespace {

/// Lets rays pass through the backs of triangles.
void pass_back_faces(const RTCFilterFunctionNArguments* arguments) {
    for (unsigned i = 0; i < arguments->N; ++i) {
        const unsigned n = arguments->N;
        const float facing = RTCRayN_dir_x(arguments->ray, n, i) * RTCHitN_Ng_x(arguments->hit, n, i) +
                             RTCRayN_dir_y(arguments->ray, n, i) * RTCHitN_Ng_y(arguments->hit, n, i) +
                             RTCRayN_dir_z(arguments->ray, n, i) * RTCHitN_Ng_z(arguments->hit, n, i);
        if (facing >= 0) arguments->valid[i] = 0;
    }
}

void attach_triangles(RTCDevice device, RTCScene scene, const Occluder& occluder,
                      const ShadedInstance& instance, std::size_t first, std::size_t last, bool one_sided) {
    if (first == last) return;
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<Vec3f*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), occluder.positions().size()));
    for (std::size_t i = 0; i < occluder.positions().size(); ++i)
        vertices[i] = instance.placement.point_to_world(occluder.positions()[i]);
    auto* triangles = static_cast<std::array<std::uint32_t, 3>*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), last - first));
    std::copy(occluder.triangles().begin() + std::ptrdiff_t(first),
              occluder.triangles().begin() + std::ptrdiff_t(last), triangles);
    if (one_sided) rtcSetGeometryOccludedFilterFunction(geometry, pass_back_faces);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
}

std::shared_ptr<void> embree_scene(const ShadedScene& shaded) {
    const RTCDevice device = rtcNewDevice(nullptr);
    const RTCScene scene = rtcNewScene(device);
    for (const ShadedInstance& instance : shaded.instances) {
        const Occluder& occluder = shaded.entities[instance.entity].occlusion->coarse();
        attach_triangles(device, scene, occluder, instance, 0, occluder.one_sided(), true);
        attach_triangles(device, scene, occluder, instance, occluder.one_sided(), occluder.triangles().size(),
                         false);
    }
    rtcCommitScene(scene);
    return std::shared_ptr<void>(scene, [device](void* owned) {
        rtcReleaseScene(static_cast<RTCScene>(owned));
        rtcReleaseDevice(device);
    });
}

/// Returns the digits of a number, mirrored at the radix point: van der Corput's sequence.
template <std::uint32_t base>
float radical_inverse(std::uint32_t number) {
    float value = 0, digit = 1.0f / base;
    for (; number > 0; number /= base, digit /= base) value += static_cast<float>(number % base) * digit;
    return value;
}

float wrapped(float value) {
    return value - std::floor(value);
}

/// A frame whose y axis is `axis`.
struct TangentFrame {
    Vec3f axis, x, z;

    explicit TangentFrame(const Vec3f& along)
        : axis(along),
          x((std::abs(along.x) < 0.5f ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0)).cross(along).normalized()),
          z(x.cross(along)) {}

    Vec3f direction(float cosine, float turn) const {
        const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
        const float angle = static_cast<float>(2 * pi) * turn;
        return axis * cosine + x * (sine * std::cos(angle)) + z * (sine * std::sin(angle));
    }
};

/// Random shifts of a set of stratified samples, in [0, 1).
struct Shift {
    std::minstd_rand random;

    explicit Shift(std::uint32_t seed) : random(seed + 1) { random.discard(3); }
    float operator()() { return static_cast<float>(random() >> 7) / 16777216.0f; }
};

constexpr std::uint32_t light_sets = 64;
constexpr float diffuse_share = brdf_diffuse / (brdf_diffuse + brdf_specular);

}  // namespace

RayCaster::RayCaster(const ShippedScene& scene, const TexelIntegrals& integrals)
    : size_(integrals.face_size), scene_(embree_scene(scene.shaded)) {
    double total = 0;
    for (std::size_t i = 0; i < integrals.light.size(); ++i) {
        const int texel = static_cast<int>(i) % (size_ * size_);
        const double solid_angle = texel_solid_angle(texel % size_, texel / size_, size_);
        radiance_.push_back(integrals.light[i] / static_cast<float>(solid_angle * size_ * size_));
        total += double(luminance(integrals.light[i]));
        cumulative_.push_back(total);
    }
    for (double& cumulative : cumulative_) cumulative /= total;
    for (const Rgb& light : integrals.light)
        probability_.push_back(luminance(light) / static_cast<float>(total));
}

RayCaster::Light RayCaster::light_from(const Vec3f& direction) const {
    const auto [face, u, v] = cubemap_point(Vec3d(direction));
    const auto texel = [this](double coordinate) {
        return std::min(static_cast<int>((coordinate + 1) / 2 * size_), size_ - 1);
    };
    const auto index = static_cast<std::size_t>((face * size_ + texel(v)) * size_ + texel(u));
    const auto squared = static_cast<float>(1 + u * u + v * v);
    const auto texels_per_area = static_cast<float>(size_ * size_) / 4;
    return {radiance_[index], probability_[index] * texels_per_area * squared * std::sqrt(squared)};
}

void RayCaster::add_sample(const VertexTexels& vertex, const Vec3f& direction, const Light& light) {
    const float cosine = direction.dot(vertex.normal);
    if (cosine <= 0) return;
    const auto over_pi = static_cast<float>(1 / pi);
    const float lobe = std::pow(std::max(0.0f, direction.dot(vertex.mirror)), brdf_shininess) * over_pi / 2;
    const float density =
        light.density + diffuse_share * cosine * over_pi + (1 - diffuse_share) * (brdf_shininess + 1) * lobe;
    const float brdf = brdf_diffuse * over_pi + brdf_specular * (brdf_shininess + 2) * lobe;
    samples_.push_back(
        {direction, light.radiance * (brdf * cosine * 2 / (density * static_cast<float>(rays_)))});
}

void RayCaster::use_rays(int rays) {
    assert(rays > 0 && rays % 2 == 0);
    rays_ = rays;
    light_samples_.clear();
    const int half = rays / 2;
    for (std::uint32_t set = 0; set < light_sets; ++set) {
        Shift shift(set);
        const float along = shift(), across_u = shift(), across_v = shift();
        for (int i = 0; i < half; ++i) {
            const auto number = static_cast<std::uint32_t>(i);
            const double place = (i + double(along)) / half;
            const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), place);
            const auto texel = static_cast<int>(
                std::min<std::ptrdiff_t>(found - cumulative_.begin(), std::ssize(cumulative_) - 1));
            const auto on_face = [this](int index, float within) {
                return 2 * (static_cast<float>(index) + within) / static_cast<float>(size_) - 1;
            };
            const Vec3f direction =
                cubemap_direction<Vec3f>(
                    texel / (size_ * size_),
                    on_face(texel % size_, wrapped(radical_inverse<2>(number) + across_u)),
                    on_face(texel / size_ % size_, wrapped(radical_inverse<3>(number) + across_v)))
                    .normalized();
            light_samples_.push_back({direction, light_from(direction)});
        }
    }
}

Rgb RayCaster::operator()(const VertexTexels& vertex, std::uint32_t seed) {
    samples_.clear();
    const auto half = static_cast<std::size_t>(rays_ / 2);
    for (const LightSample& sample : std::span(light_samples_).subspan(seed % light_sets * half, half))
        add_sample(vertex, sample.direction, sample.light);
    const TangentFrame about_normal(vertex.normal), about_mirror(vertex.mirror);
    Shift shift(seed);
    const float along = shift(), round = shift();
    for (std::size_t i = 0; i < half; ++i) {
        const float place = (static_cast<float>(i) + along) / static_cast<float>(half);
        const float turn = wrapped(radical_inverse<2>(static_cast<std::uint32_t>(i)) + round);
        const Vec3f direction =
            place < diffuse_share
                ? about_normal.direction(std::sqrt(1 - place / diffuse_share), turn)
                : about_mirror.direction(
                      std::pow((1 - place) / (1 - diffuse_share), 1 / (brdf_shininess + 1)), turn);
        if (direction.dot(vertex.normal) > 0) add_sample(vertex, direction, light_from(direction));
    }
    return sum_of_open(vertex.point);
}

Rgb RayCaster::sum_of_open(const Vec3f& origin) const {
    constexpr std::size_t packet = 16;
    alignas(64) std::int32_t valid[packet];
    alignas(64) RTCRay16 rays{};
    std::fill_n(rays.org_x, packet, origin.x);
    std::fill_n(rays.org_y, packet, origin.y);
    std::fill_n(rays.org_z, packet, origin.z);
    std::fill_n(rays.mask, packet, ~0u);
    Rgb sum(0.0f);
    for (std::size_t first = 0; first < samples_.size(); first += packet) {
        const std::size_t count = std::min(packet, samples_.size() - first);
        for (std::size_t k = 0; k < packet; ++k) {
            const Vec3f& direction = samples_[first + std::min(k, count - 1)].direction;
            valid[k] = k < count ? -1 : 0;
            rays.dir_x[k] = direction.x;
            rays.dir_y[k] = direction.y;
            rays.dir_z[k] = direction.z;
            rays.tfar[k] = INFINITY;
        }
        test_occlusion(static_cast<RTCScene>(scene_.get()), valid, rays, Coherence::high);
        for (std::size_t k = 0; k < count; ++k)
            if (rays.tfar[k] > 0) sum += samples_[first + k].value;
    }
    return sum;
}

}  // namespace haarfield::baseline
