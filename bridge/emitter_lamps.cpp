#include "bridge/emitter_lamps.h"

#include <cmath>
#include <queue>
#include <random>

namespace haarfield {
namespace {

/// A part of an emitter; those of the most power are cut next, equal ones in the order of their making.
struct Patch {
    Emitter emitter;
    double power;
    std::size_t number;

    bool operator<(const Patch& other) const {
        return power != other.power ? power < other.power : number > other.number;
    }
};

Vec3d area_vector(const Emitter& emitter) {
    const auto& [a, b, c] = emitter.corners;
    return (Vec3d(b) - Vec3d(a)).cross(Vec3d(c) - Vec3d(a)) * 0.5;
}

double power_of(const Emitter& emitter) {
    return area_vector(emitter).length() * double(luminance(emitter.radiance));
}

/// So many of the emitters, each with an equal share of the power of all; `start` in [0, 1).
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

}  // namespace

std::vector<Lamp> emitter_lamps(std::span<const Emitter> emitters, std::size_t count, PatchPlace place,
                                float lift) {
    std::priority_queue<Patch> patches;
    std::size_t made = 0;
    const auto add = [&](const Emitter& emitter) {
        const double power = power_of(emitter);
        if (power > 0) patches.push({emitter, power, made++});
    };
    if (emitters.size() > count)
        for (const Emitter& emitter : some_of(emitters, count, place == PatchPlace::middle ? 0.5 : 0.15))
            add(emitter);
    else
        for (const Emitter& emitter : emitters) add(emitter);
    while (!patches.empty() && patches.size() + 3 <= count) {
        const Emitter whole = patches.top().emitter;
        patches.pop();
        const auto& [a, b, c] = whole.corners;
        const Vec3f ab = (a + b) / 2.0f, bc = (b + c) / 2.0f, ca = (c + a) / 2.0f;
        for (const std::array<Vec3f, 3>& part :
             {std::array{a, ab, ca}, std::array{ab, b, bc}, std::array{ca, bc, c}, std::array{bc, ca, ab}})
            add({part, whole.radiance});
    }
    std::mt19937 random(4);
    const auto uniform = [&] { return double(random()) / 4294967296.0; };
    std::vector<Lamp> lamps;
    for (; !patches.empty(); patches.pop()) {
        const Emitter& patch = patches.top().emitter;
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
        // Much nearer than anything that is lit: 2 / (1 + (d / f)^2) is 2 f^2 / d^2 there.
        lamp.fade_distance = static_cast<float>(1e-3 * std::sqrt(area.length()));
        lamp.colour =
            patch.radiance * static_cast<float>(area.length() / (2 * pi * squared(lamp.fade_distance)));
        lamps.push_back(lamp);
    }
    return lamps;
}

}  // namespace haarfield
