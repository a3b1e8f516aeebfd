#include "bridge/povray/emitter_lamps.h"

#include <cmath>
#include <queue>
#include <random>

namespace haarfield {
namespace {

/// A piece of an emitter. The piece of the highest rank is subdivided next; equal ranks in order of creation.
struct Patch {
    Emitter emitter;
    double rank;
    std::size_t number;

    bool operator<(const Patch& other) const {
        return rank != other.rank ? rank < other.rank : number > other.number;
    }
};

Vec3d area_vector(const Emitter& emitter) {
    const auto& [a, b, c] = emitter.corners;
    return (Vec3d(b) - Vec3d(a)).cross(Vec3d(c) - Vec3d(a)) * 0.5;
}

double power_of(const Emitter& emitter) {
    return area_vector(emitter).length() * double(luminance(emitter.radiance));
}

/// Returns `count` emitters that each have an equal fraction of the total power; `start` in [0, 1).
std::vector<Emitter> some_of(std::span<const Emitter> emitters, std::size_t count, double start) {
    double all = 0, passed = 0;
    for (const Emitter& emitter : emitters) all += power_of(emitter);
    const double share = all / double(count);
    std::vector<Emitter> some;
    for (Emitter emitter : emitters) {
        const double power = power_of(emitter);
        passed += power;
        const std::size_t wanted =
            static_cast<std::size_t>(std::max(0.0, std::floor(passed / share - start + 1)));
        emitter.radiance *= static_cast<float>(share / power);
        while (some.size() < wanted) some.push_back(emitter);
    }
    return some;
}

/// Returns the summed squared error of the points' diffuse radiance if a lamp in the middle represents the
/// patch.
double middle_error(const Emitter& patch, const LitPoints& lit) {
    const auto& [a, b, c] = patch.corners;
    const std::array<Vec3d, 3> corners{Vec3d(a), Vec3d(b), Vec3d(c)};
    const Vec3d middle = (corners[0] + corners[1] + corners[2]) / 3.0, area = area_vector(patch);
    const double brightness = double(luminance(patch.radiance));
    double sum = 0;
    for (const LitPoint& point : lit.points()) {
        const Vec3d position(point.position), normal(point.normal), to = middle - position;
        const double distance2 = to.length2(), from_patch = -area.dot(to);
        // At large distances the error falls with the square of size / distance.
        if (!(from_patch > 0) || area.length2() < 1e-4 * squared(distance2)) continue;
        const double found = std::max(0.0, to.dot(normal)) * from_patch / squared(distance2),
                     error = double(luminance(point.albedo)) * brightness *
                             (found - triangle_irradiance(corners, position, normal));
        if (error != 0 && lit.sees(point, Vec3f(middle))) sum += squared(error);
    }
    return sum;
}

/// Subdivides emitters into patches.
class PatchCutter {
public:
    explicit PatchCutter(std::span<const Emitter> emitters) {
        for (const Emitter& emitter : emitters) add(emitter, power_of(emitter));
    }

    /// Subdivides patches in the order of rank until there are `count`.
    ///
    /// rank_of  returns the rank of an emitter.
    template <class RankOf>
    void cut(std::size_t count, const RankOf& rank_of) {
        while (!patches_.empty() && patches_.size() + 3 <= count) {
            const Emitter whole = patches_.top().emitter;
            patches_.pop();
            const auto& [a, b, c] = whole.corners;
            const Vec3f ab = (a + b) / 2.0f, bc = (b + c) / 2.0f, ca = (c + a) / 2.0f;
            for (const std::array<Vec3f, 3>& part : {std::array{a, ab, ca}, std::array{ab, b, bc},
                                                     std::array{ca, bc, c}, std::array{bc, ca, ab}})
                add({part, whole.radiance}, rank_of(Emitter{part, whole.radiance}));
        }
    }

    void cut_by_power(std::size_t count) { cut(count, power_of); }

    void cut_by_error(std::size_t count, const LitPoints& lit) {
        std::priority_queue<Patch> by_power;
        std::swap(by_power, patches_);
        for (; !by_power.empty(); by_power.pop())
            add(by_power.top().emitter, middle_error(by_power.top().emitter, lit));
        cut(count, [&](const Emitter& patch) { return middle_error(patch, lit); });
    }

    std::vector<Emitter> patches() && {
        std::vector<Emitter> cut;
        for (; !patches_.empty(); patches_.pop()) cut.push_back(patches_.top().emitter);
        return cut;
    }

private:
    void add(const Emitter& emitter, double rank) {
        if (power_of(emitter) > 0) patches_.push({emitter, rank, made_++});
    }

    std::priority_queue<Patch> patches_;
    std::size_t made_ = 0;
};

std::vector<Emitter> patches_of(std::span<const Emitter> emitters, std::size_t count, PatchPlace place,
                                const LitPoints* lit) {
    std::vector<Emitter> some;
    if (emitters.size() > count) {
        some = some_of(emitters, count, place == PatchPlace::middle ? 0.5 : 0.15);
        emitters = some;
    }
    PatchCutter cutter(emitters);
    cutter.cut_by_power(lit ? count / 2 : count);
    if (lit) cutter.cut_by_error(count, *lit);
    return std::move(cutter).patches();
}

}  // namespace

std::vector<Lamp> emitter_lamps(std::span<const Emitter> emitters, std::size_t count, PatchPlace place,
                                float lift, const LitPoints* lit) {
    std::mt19937 random(4);
    const auto uniform = [&] { return double(random()) / 4294967296.0; };
    std::vector<Lamp> lamps;
    for (const Emitter& patch : patches_of(emitters, count, place, lit)) {
        const auto& [a, b, c] = patch.corners;
        double along = 1 / 3.0, across = 1 / 3.0;
        if (place == PatchPlace::random) {
            along = uniform();
            across = uniform();
            if (along + across > 1) {
                along = 1 - along;
                across = 1 - across;
            }
        }
        const Vec3d area = area_vector(patch), normal = area.normalized(),
                    at = Vec3d(a) * (1 - along - across) + Vec3d(b) * along + Vec3d(c) * across;
        Lamp lamp;
        lamp.kind = LampKind::spot;
        lamp.position = Vec3f(at + normal * double(lift));
        lamp.target = Vec3f(at + normal * (double(lift) + std::sqrt(area.length())));
        lamp.radius = lamp.falloff = static_cast<float>(pi / 2);
        lamp.tightness = 1;
        // Much smaller than the distance to any lit surface, where 2 / (1 + (d / f)^2) is then 2 f^2 / d^2.
        lamp.fade_distance = static_cast<float>(1e-3 * std::sqrt(area.length()));
        lamp.colour =
            patch.radiance * static_cast<float>(area.length() / (2 * pi * squared(lamp.fade_distance)));
        lamps.push_back(lamp);
    }
    return lamps;
}

}  // namespace haarfield
