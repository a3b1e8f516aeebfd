#include "bridge/povray/mapped_light.h"

#include "fields/file/write_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace haarfield {
namespace {

constexpr float largest_code = 65535;

/// Returns the image coordinates of a triangle's corners, shifted by whole tiles of the repeating image
/// towards 0.
std::array<Vec2f, 3> places_of(const Mesh& mesh, std::uint32_t triangle) {
    std::array<Vec2f, 3> places;
    for (std::size_t k = 0; k < 3; ++k) places[k] = mesh.uvs[mesh.triangles[triangle][k]];
    const Vec2f tile(std::floor(std::min({places[0].x, places[1].x, places[2].x})),
                     std::floor(std::min({places[0].y, places[1].y, places[2].y})));
    for (Vec2f& place : places) place -= tile;
    return places;
}

float brightest(std::span<const Colour> colours) {
    float most = 0;
    for (const Colour& colour : colours)
        for (const float channel : colour) most = std::max(most, channel);
    return most;
}

}  // namespace

MappedLight::MappedLight(const Mesh& mesh, std::span<const std::uint32_t> triangles,
                         std::span<const Colour> textured, std::span<const Colour> added,
                         const std::string& object, const std::string& stem)
    : atlas_(triangles.size()), object_(object), stem_(stem) {
    assert(mesh.uvs.size() == mesh.positions.size());
    const auto light = [&](std::span<const Colour> of) {
        return atlas_.image([&](std::size_t t) {
            const auto& [a, b, c] = mesh.triangles[triangles[t]];
            return std::array{rgb(of[a]), rgb(of[b]), rgb(of[c])};
        });
    };
    light_ = light(textured);
    most_ = brightest(textured);
    if (const float most_added = brightest(added); most_added > 0) {
        added_ = light(added);
        most_ += most_added;
    }
    most_ = most_ > 0 ? 1.001f * most_ : 1;  // half floats are rounded

    const std::vector<Vec2f> places =
        atlas_.texels([&](std::size_t t) { return places_of(mesh, triangles[t]); });
    Vec2f low(0.0f), high(0.0f);
    for (const Vec2f& place : places)
        for (int axis = 0; axis < 2; ++axis) {
            low[axis] = std::min(low[axis], place[axis]);
            high[axis] = std::max(high[axis], place[axis]);
        }
    Vec2f extent = high - low;
    for (int axis = 0; axis < 2; ++axis)
        if (!(extent[axis] > 0)) extent[axis] = 1;
    places_.reserve(places.size());
    for (const Vec2f& place : places) {
        std::array<std::uint16_t, 3> code{};
        for (int axis = 0; axis < 2; ++axis)
            code[std::size_t(axis)] = static_cast<std::uint16_t>(
                std::lround((place[axis] - low[axis]) / extent[axis] * largest_code));
        places_.push_back(code);
    }

    // A separate pigment, which all textures share.
    declarations_ = fmt::format("#declare {}_Mapped_Pigment = {}\n", object_,
                                atlas_.pigment(fmt::format("exr \"{}.exr\"", stem_)));
    const auto declare = [&](const char* name, const std::string& pigment) {
        declarations_ += fmt::format("#declare {}_Mapped_{} = function {{ {} }}\n", object_, name, pigment);
    };
    declare("Light", fmt::format("pigment {{ {}_Mapped_Pigment }}", object_));
    if (!added_.pixels.empty()) declare("Over", atlas_.pigment(fmt::format("exr \"{}.over.exr\"", stem_)));
    declare("Places", atlas_.pigment(fmt::format("png \"{}.places.png\" gamma 1.0", stem_)));
    for (const int axis : {0, 1})
        declarations_ += fmt::format(
            "#declare {0}_Mapped_{1} = function(x, y) {{ {0}_Mapped_Places(x, y, 0).{2} * {3:.9g} + {4:.9g} "
            "}}\n",
            object_, "UV"[axis], axis == 0 ? "red" : "green", extent[axis], low[axis]);
}

std::string MappedLight::texture(const TextureFile* image, const Reflection& reflection) const {
    const std::string finish =
        fmt::format("finish {{ {}_Finish{} }}", object_, povray_reflection(reflection));
    if (!image) return fmt::format("texture {{ pigment {{ {}_Mapped_Pigment }} {} }}", object_, finish);
    const std::string at_place =
        fmt::format("{0}_Function({1}_Mapped_U(x, y), {1}_Mapped_V(x, y), 0)", image->pigment, object_);
    std::string channels;
    for (std::size_t c = 0; c < 3; ++c) {
        const char* const name = std::array{"red", "green", "blue"}[c];
        std::string product =
            fmt::format("{}_Mapped_Light(x, y, 0).{} * {}.{}", object_, name, at_place, name);
        if (!added_.pixels.empty()) product += fmt::format(" + {}_Mapped_Over(x, y, 0).{}", object_, name);
        Rgb channel(0.0f);
        channel[int(c)] = 3 * most_;  // it is averaged with the two other channels
        // A POV-Ray pattern wraps around at 1.
        channels += fmt::format(
            "\n  [1 function {{ min(.9999999, max(0, ({}) / {:.9g})) }} color_map {{ [0 rgb 0] [1 rgb {}] "
            "}}]",
            product, most_, povray_vector(channel));
    }
    const std::string seen = fmt::format("pigment {{ average pigment_map {{{} }} }} {}", channels, finish);
    if (image->transmission.empty()) return fmt::format("texture {{ {} }}", seen);
    // Almost transparent texels skip the lookup of the surface.
    return fmt::format(
        "texture {{ function {{ min(.9999999, {}.transmit) }} texture_map {{ [0 {}] [.9999 pigment {{ rgbt 1 "
        "}} finish {{ {}_Finish emission 0 }}] }} }}",
        at_place, seen, object_);
}

Result<Done> MappedLight::write(const std::filesystem::path& folder) const {
    HF_TRY_DONE(write_image(light_, folder / (stem_ + ".exr")));
    if (!added_.pixels.empty()) HF_TRY_DONE(write_image(added_, folder / (stem_ + ".over.exr")));
    const Result<std::string> bytes = png_bytes(places_, atlas_.width(), atlas_.height());
    const std::filesystem::path places = folder / (stem_ + ".places.png");
    if (!bytes) return Error{places.string(), bytes.error().what};
    return write_file(places, *bytes);
}

}  // namespace haarfield
