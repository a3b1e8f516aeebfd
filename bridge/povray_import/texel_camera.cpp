#include "bridge/povray_import/texel_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace haarfield {
namespace {

constexpr std::array<float, 3> no_surface{0.8125f, 0.1875f, 0.4375f};

}  // namespace

std::string no_surface_colour() {
    return fmt::format("rgb<{},{},{}>", no_surface[0], no_surface[1], no_surface[2]);
}

std::vector<std::uint8_t> pixels_on_surfaces(const SceneGamma& gamma, std::span<const Rgb> pixels) {
    constexpr float visible = 1e-3f;
    Rgb nothing;
    for (int c = 0; c < 3; ++c)
        nothing[c] = static_cast<float>(gamma.light(double(no_surface[std::size_t(c)])));
    std::vector<std::uint8_t> result;
    for (const Rgb& pixel : pixels) {
        const Rgb away = pixel - nothing;
        result.push_back(std::max({std::abs(away.x), std::abs(away.y), std::abs(away.z)}) >= visible);
    }
    return result;
}

void TexelCamera::add_vertex(const Vec3d& position, double u, double v) {
    fmt::format_to(std::back_inserter(positions_), "<{:.9g},{:.9g},{:.9g}>\n", position.x, position.y,
                   position.z);
    // POV-Ray renders pixel (x, y) for the coordinates (x / width, 1 - y / height).
    fmt::format_to(std::back_inserter(uvs_), "<{:.9g},{:.9g}>\n", u - 0.5 / width_, v + 0.5 / height_);
    ++vertices_;
}

void TexelCamera::add_triangle(std::size_t a, std::size_t b, std::size_t c) {
    // Rays follow the normal that points to the side from which corners are in clockwise order.
    fmt::format_to(std::back_inserter(faces_), "<{},{},{}>\n", a, c, b);
    ++triangles_;
}

std::string TexelCamera::text(double start) const {
    return fmt::format(
        "#declare HF_Texels=mesh2{{vertex_vectors{{{0},{1}}}uv_vectors{{{0},{2}}}face_indices{{{3},{4}}}}}\n"
        "camera{{mesh_camera{{1 3 mesh{{HF_Texels}}}}location<0,0,{5}>direction<0,0,-1>}}\n"
        "background{{{6}*HF_E}}\n",
        vertices_, positions_, uvs_, triangles_, faces_, start, no_surface_colour());
}

}  // namespace haarfield
