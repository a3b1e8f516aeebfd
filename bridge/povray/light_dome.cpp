#include "bridge/povray/light_dome.h"

#include <algorithm>
#include <cassert>
#include <queue>

namespace haarfield {
namespace {

/// Summed-area table of importance: the importance of any rectangle of pixels in constant time.
class ImportanceSums {
public:
    ImportanceSums(const LatLongImage& image, double uniform_share) : width_(image.width) {
        double energy = 0;
        for (int row = 0; row < image.height; ++row)
            for (int column = 0; column < width_; ++column)
                energy += lat_long_pixel_solid_angle(row, width_, image.height) *
                          luminance(image.pixels[static_cast<std::size_t>(row) * width_ + column]);
        sums_.assign(static_cast<std::size_t>(width_ + 1) * (image.height + 1), 0.0);
        for (int row = 0; row < image.height; ++row) {
            const double solid_angle = lat_long_pixel_solid_angle(row, width_, image.height);
            double of_row = 0;
            for (int column = 0; column < width_; ++column) {
                const Rgb& radiance = image.pixels[static_cast<std::size_t>(row) * width_ + column];
                const double share = energy > 0 ? luminance(radiance) / energy : 0;
                of_row += solid_angle * ((1 - uniform_share) * share + uniform_share / (4 * pi));
                sums_[index(column + 1, row + 1)] = sums_[index(column + 1, row)] + of_row;
            }
        }
    }

    double operator()(int x0, int y0, int x1, int y1) const {
        return sums_[index(x1, y1)] - sums_[index(x0, y1)] - sums_[index(x1, y0)] + sums_[index(x0, y0)];
    }

private:
    std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * (width_ + 1) + x; }

    int width_;
    std::vector<double> sums_;
};

/// The pixels x0 <= column < x1, y0 <= row < y1.
struct Region {
    int x0, y0, x1, y1;
    double importance;
    int number;  ///< In order of creation. Equally important regions are cut in this order.

    bool operator<(const Region& other) const {  // the greatest is cut next
        if (importance != other.importance) return importance < other.importance;
        return number > other.number;
    }
};

/// Returns the cut between begin and end whose lower side is closest to `wanted`.
template <class LowerPart>
int nearest_cut(int begin, int end, double wanted, const LowerPart& lower_part) {
    int low = begin + 1, high = end - 1;
    while (low < high) {  // finds the first cut whose lower side reaches `wanted`
        const int middle = (low + high) / 2;
        if (lower_part(middle) < wanted)
            low = middle + 1;
        else
            high = middle;
    }
    if (low > begin + 1 && std::abs(lower_part(low - 1) - wanted) <= std::abs(lower_part(low) - wanted))
        --low;
    return low;
}

std::vector<DirectionalLight> image_lights(const LatLongImage& environment, const LightDomeOptions& options) {
    assert(options.uniform_share >= 0 && options.uniform_share <= 1);
    assert(options.cut_share >= 0.2 && options.cut_share <= 0.8);
    assert(environment.width >= 1 && environment.height >= 1);
    const int width = environment.width, height = environment.height;
    const ImportanceSums importance(environment, options.uniform_share);

    std::priority_queue<Region> to_cut;
    std::vector<Region> finished;
    int made = 0;
    to_cut.push({0, 0, width, height, importance(0, 0, width, height), made++});
    while (!to_cut.empty() && static_cast<int>(to_cut.size() + finished.size()) < options.lights) {
        const Region region = to_cut.top();
        to_cut.pop();
        const int columns = region.x1 - region.x0, rows = region.y1 - region.y0;
        if (columns == 1 && rows == 1) {
            finished.push_back(region);
            continue;
        }
        const double latitude = pi * (0.5 - 0.5 * (region.y0 + region.y1) / height);
        const double breadth = 2 * pi * columns / width * std::cos(latitude), length = pi * rows / height;
        const double wanted = options.cut_share * region.importance;
        Region first = region, second = region;
        if (rows == 1 || (columns > 1 && breadth >= length))
            first.x1 = second.x0 = nearest_cut(region.x0, region.x1, wanted, [&](int cut) {
                return importance(region.x0, region.y0, cut, region.y1);
            });
        else
            first.y1 = second.y0 = nearest_cut(region.y0, region.y1, wanted, [&](int cut) {
                return importance(region.x0, region.y0, region.x1, cut);
            });
        for (Region* part : {&first, &second}) {
            part->importance = importance(part->x0, part->y0, part->x1, part->y1);
            part->number = made++;
            to_cut.push(*part);
        }
    }
    for (; !to_cut.empty(); to_cut.pop()) finished.push_back(to_cut.top());
    std::sort(finished.begin(), finished.end(),
              [](const Region& a, const Region& b) { return a.number < b.number; });

    std::vector<DirectionalLight> lights;
    for (const Region& region : finished) {
        Vec3d energy(0, 0, 0), mean(0, 0, 0);
        for (int row = region.y0; row < region.y1; ++row) {
            const double solid_angle = lat_long_pixel_solid_angle(row, width, height);
            for (int column = region.x0; column < region.x1; ++column) {
                const Rgb& radiance = environment.pixels[static_cast<std::size_t>(row) * width + column];
                energy += Vec3d(radiance.x, radiance.y, radiance.z) * solid_angle;
                mean += lat_long_direction((column + 0.5) / width, (row + 0.5) / height) *
                        (solid_angle * luminance(radiance));
            }
        }
        if (!(energy.x + energy.y + energy.z > 0)) continue;
        if (mean.length() < 1e-12 * (energy.x + energy.y + energy.z))  // light from all sides
            mean = lat_long_direction(0.5 * (region.x0 + region.x1) / width,
                                      0.5 * (region.y0 + region.y1) / height);
        lights.push_back(
            {Vec3f(mean.normalized()),
             Rgb(static_cast<float>(energy.x), static_cast<float>(energy.y), static_cast<float>(energy.z))});
    }
    return lights;
}

}  // namespace

std::vector<DirectionalLight> light_dome(const Environment& environment, const LightDomeOptions& options) {
    assert(options.lights >= 8);
    const int of_a_disc = std::clamp(options.lights / 16, 4, 256),
              discs = static_cast<int>(environment.suns.size());
    LightDomeOptions of_image = options;
    of_image.lights = std::max(1, options.lights - discs * of_a_disc);
    std::vector<DirectionalLight> lights = image_lights(environment.image, of_image);
    for (SunDisc disc : environment.suns) {
        // Domes with different cuts also rotate the samples of their discs.
        const std::vector<Vec3f> directions = disc_directions(disc, of_a_disc, 2 * pi * options.cut_share);
        for (const Vec3f& direction : directions)
            lights.push_back({direction, disc.irradiance / static_cast<float>(of_a_disc)});
    }
    return lights;
}

}  // namespace haarfield
