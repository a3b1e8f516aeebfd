#include "bridge/povray/povray_frame.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

std::vector<Colour> clamped_colours(std::span<const Rgb> colours, std::uint64_t& count) {
    std::vector<Colour> result;
    result.reserve(colours.size());
    for (const Rgb& value : colours) {
        Colour colour;
        for (int c = 0; c < 3; ++c) colour[c] = std::clamp(value[c], 0.0f, largest_radiance) + 0.0f;
        if (rgb(colour) != value) ++count;
        result.push_back(colour);
    }
    return result;
}

PovrayFrame::PovrayFrame(const Mesh& mesh)
    : magnified(small_triangle_scale(mesh)), rotation(interpolation_rotation(mesh)) {}

void PovrayFrame::append_vertices(std::string& text, const Mesh& mesh) const {
    std::vector<Vec3f> positions;
    positions.reserve(mesh.positions.size());
    for (const Vec3f& p : mesh.positions) positions.emplace_back(rotation(Vec3d(p)) + Vec3d(0.0));
    append_povray_vectors(text, "vertex_vectors", positions, static_cast<float>(magnified));
}

void PovrayFrame::append_normals(std::string& text, const Mesh& mesh) const {
    std::vector<Vec3f> normals;
    normals.reserve(mesh.normals.size());
    for (const Vec3f& n : mesh.normals) normals.emplace_back(rotation(Vec3d(n)) + Vec3d(0.0));
    append_povray_vectors(text, "normal_vectors", normals);
}

void PovrayFrame::append_inverse(std::string& text) const {
    text += fmt::format("{}\nscale {:.17g}\n", povray_rotation(rotation.inverse()), 1 / magnified);
}

}  // namespace haarfield
