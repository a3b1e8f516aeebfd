#include "shading/bake/environment_sampler.h"

#include <algorithm>
#include <cmath>

#include "fields/base/embree_rays.h"
#include "shading/visibility/instanced_triangles.h"

namespace haarfield {
namespace {

/// Returns the index of the first running sum above `wanted`, and sets `wanted` to its fraction within that
/// element.
std::size_t chosen(std::span<const double> sums, double before, double& wanted) {
    const auto found = std::upper_bound(sums.begin(), sums.end() - 1, wanted);
    const auto index = std::size_t(found - sums.begin());
    const double low = index == 0 ? before : sums[index - 1], part = sums[index] - low;
    wanted = part > 0 ? std::clamp((wanted - low) / part, 0.0, 1 - 1e-12) : 0.5;
    return index;
}

Vec3f disc_direction(const SunDisc& disc, double u, double v) {
    const Vec3d middle = Vec3d(disc.direction).normalized();
    const auto [right, up] = axes_across(middle);
    const double half_sine = std::sin(double(disc.angular_radius) / 2) * std::sqrt(u);
    const double cosine = 1 - 2 * half_sine * half_sine,
                 sine = 2 * half_sine * std::sqrt(1 - half_sine * half_sine);
    return Vec3f(middle * cosine + (right * std::cos(2 * pi * v) + up * std::sin(2 * pi * v)) * sine);
}

}  // namespace

EnvironmentSampler::EnvironmentSampler(const Environment& environment, std::optional<ArrivingShares> shares)
    : environment_(&environment), shares_(std::move(shares)) {
    const LatLongImage& image = environment.image;
    for (int row = 0; row < image.height; ++row) {
        const double solid_angle = lat_long_pixel_solid_angle(row, image.width, image.height);
        double sum = 0;
        for (int column = 0; column < image.width; ++column) {
            const std::size_t pixel = std::size_t(row) * std::size_t(image.width) + std::size_t(column);
            columns_.push_back(sum +=
                               double(luminance(image.pixels[pixel])) * share_of(row, column) * solid_angle);
        }
        rows_.push_back(total_ += sum);
    }
    for (std::size_t i = 0; i < environment.suns.size(); ++i)
        discs_.push_back(total_ += double(luminance(environment.suns[i].irradiance)) * share_of_sun(i));
}

LightSample EnvironmentSampler::sample(const std::array<double, 2>& place) const {
    const LatLongImage& image = environment_->image;
    const double of_image = rows_.empty() ? 0 : rows_.back();
    double x = place[0], y = place[1] * total_;
    if (y >= of_image && !discs_.empty()) {
        const std::size_t sun = chosen(discs_, of_image, y);
        const SunDisc& disc = environment_->suns[sun];
        const double solid_angle = 2 * pi * (1 - std::cos(double(disc.angular_radius)));
        return {disc_direction(disc, x, y), disc.irradiance / float(solid_angle),
                double(luminance(disc.irradiance)) * share_of_sun(sun) / (total_ * solid_angle), far_away,
                true};
    }
    const std::size_t width = std::size_t(image.width), row = chosen(rows_, 0, y);
    const std::span<const double> columns = std::span(columns_).subspan(row * width, width);
    x *= columns.back();
    const std::size_t column = chosen(columns, 0, x);
    const double top = std::sin(pi * (0.5 - double(row) / image.height)),
                 bottom = std::sin(pi * (0.5 - double(row + 1) / image.height));
    const double latitude = std::asin(std::clamp(top + (bottom - top) * y, -1.0, 1.0));
    const Rgb& radiance = image.pixels[row * width + column];
    return {Vec3f(lat_long_direction((double(column) + x) / image.width, 0.5 - latitude / pi)), radiance,
            density_of(radiance, int(row), int(column)), far_away, false};
}

void EnvironmentSampler::look_up(const Vec3f& direction, Rgb& radiance, double& density) const {
    const LatLongImage& image = environment_->image;
    double x = 0, y = 0;
    lat_long_point(Vec3d(direction), x, y);
    const int column = std::min(int(x * image.width), image.width - 1),
              row = std::min(int(y * image.height), image.height - 1);
    radiance = image.pixels[std::size_t(row) * std::size_t(image.width) + std::size_t(column)];
    density = total_ > 0 ? density_of(radiance, row, column) : 0;
}

double EnvironmentSampler::density_of(const Rgb& radiance, int row, int column) const {
    return double(luminance(radiance)) * share_of(row, column) / total_;
}

double EnvironmentSampler::share_of(int row, int column) const {
    return shares_ ? double(shares_->of_pixel(row, column, environment_->image)) : 1;
}

EmitterSampler::EmitterSampler(std::vector<Emitter> emitters) : emitters_(std::move(emitters)) {
    double sum = 0;
    std::vector<Vec3f> positions;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (const auto& [corners, radiance] : emitters_) {
        const Vec3d a(corners[0]), across = (Vec3d(corners[1]) - a).cross(Vec3d(corners[2]) - a);
        chances_.push_back(sum += double(luminance(radiance)) * across.length() / 2);
        normals_.push_back(across.normalized());
        const auto first = std::uint32_t(positions.size());
        triangles.push_back({first, first + 1, first + 2});
        positions.insert(positions.end(), corners.begin(), corners.end());
    }
    if (emitters_.empty()) return;
    scene_ = std::shared_ptr<RTCSceneTy>(rtcNewScene(device_.get()), &rtcReleaseScene);
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    const std::shared_ptr<RTCGeometryTy> geometry = device_.triangles(positions, triangles);
    rtcSetGeometryMask(geometry.get(), ~0u);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene_.get(), geometry.get());
    device_.commit(scene_.get());
}

std::optional<LightSample> EmitterSampler::seen(std::size_t emitter, const Vec3f& from,
                                                const Vec3d& to) const {
    const Vec3d way = to - Vec3d(from);
    const double distance = way.length(), cosine = -normals_[emitter].dot(way) / distance;
    if (!(cosine > 0)) return std::nullopt;
    const Rgb& radiance = emitters_[emitter].radiance;
    const double density = double(luminance(radiance)) / chances_.back() * distance * distance / cosine;
    return LightSample{Vec3f(way / distance), radiance, density, float(distance), false};
}

std::optional<LightSample> EmitterSampler::sample(const Vec3f& from,
                                                  const std::array<double, 2>& place) const {
    double x = place[0] * chances_.back();
    const std::size_t emitter = chosen(chances_, 0, x);
    const double root = std::sqrt(x), u = 1 - root, v = root * place[1];
    const auto& corners = emitters_[emitter].corners;
    return seen(emitter, from,
                Vec3d(corners[0]) * (1 - u - v) + Vec3d(corners[1]) * u + Vec3d(corners[2]) * v);
}

std::optional<LightSample> EmitterSampler::look_up(const Vec3f& from, const Vec3f& direction) const {
    const std::optional<RTCRayHit> hit = nearest_hit(scene_.get(), embree_ray(from, direction, far_away));
    if (!hit || !(hit->ray.tfar > 0)) return std::nullopt;
    return seen(hit->hit.primID, from, Vec3d(from) + Vec3d(direction) * double(hit->ray.tfar));
}

}  // namespace haarfield
