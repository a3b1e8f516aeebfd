#include "bridge/povray/povray_scene.h"

#include "fields/base/names.h"
#include "fields/base/range.h"
#include "fields/base/spiral.h"
#include "scenes/camera_frame.h"
#include "scenes/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace haarfield {
namespace {

constexpr double shortest_edge = 0.1;            // POV-Ray units; POV-Ray interpolates well above
constexpr double smallest_parallelogram = 1e-2;  // for |(b - a) x (c - a)| of a triangle
constexpr double sliver_parallelogram = 1e-4;    // colours are wrong below
// below POV-Ray's limit of 1e7, with a margin for the camera
constexpr double largest_scaled_coordinate = 5e5;

}  // namespace

std::string povray_identifier(std::string_view name) {
    std::string identifier;
    for (char c : name.substr(0, 64)) identifier += is_plain(c) && c != '-' && c != '.' ? c : '_';
    if (identifier.empty()) return "Unnamed";
    char& first = identifier.front();
    if (first >= 'a' && first <= 'z')
        first = static_cast<char>(first - 'a' + 'A');
    else if (!(first >= 'A' && first <= 'Z'))
        identifier = ("N" + identifier).substr(0, 64);
    return identifier;
}

bool is_scene_name(std::string_view name) {
    return !name.empty() && name.front() != '.' && std::ranges::all_of(name, is_plain);
}

std::string povray_vector(const Vec3f& v) {
    assert(is_finite(v));
    return fmt::format("<{}, {}, {}>", v.x, v.y, v.z);
}

std::string povray_rotation(const Rotation& rotation) {
    // The images of the axes, one after another.
    const auto& [x, y, z] = rotation.inverse().row;
    return fmt::format(
        "matrix <{:.17g},{:.17g},{:.17g}, {:.17g},{:.17g},{:.17g}, {:.17g},{:.17g},{:.17g}, 0,0,0>", x.x, x.y,
        x.z, y.x, y.y, y.z, z.x, z.y, z.z);
}

std::string povray_reflection(const Reflection& reflection, float share) {
    if (!reflection.is_there()) return "";
    return fmt::format(" reflection {{ rgb {}, rgb {}{} }}", povray_vector(reflection.at_normal * share),
                       povray_vector(reflection.at_grazing * share), reflection.ior > 0 ? " fresnel on" : "");
}

std::string povray_interior(std::span<const Surface> surfaces) {
    float ior = 0;
    for (const Surface& surface : surfaces) ior = std::max(ior, surface.reflection.ior);
    return ior > 0 ? fmt::format("interior {{ ior {} }}\n", ior) : "";
}

void append_povray_vectors(std::string& text, std::string_view keyword, std::span<const Vec3f> vectors,
                           float scale) {
    auto out = std::back_inserter(text);
    fmt::format_to(out, "{} {{ {}", keyword, vectors.size());
    for (const Vec3f& v : vectors)
        fmt::format_to(out, ",\n<{},{},{}>", v.x * scale, v.y * scale, v.z * scale);
    text += " }\n";
}

void append_povray_uvs(std::string& text, std::span<const Vec2f> uvs) {
    auto out = std::back_inserter(text);
    fmt::format_to(out, "uv_vectors {{ {}", uvs.size());
    for (const Vec2f& uv : uvs) fmt::format_to(out, ",\n<{},{}>", uv.x, uv.y);
    text += " }\n";
}

void append_povray_indices(std::string& text, std::string_view keyword,
                           std::span<const std::array<std::uint32_t, 3>> triangles) {
    auto out = std::back_inserter(text);
    fmt::format_to(out, "{} {{ {}", keyword, triangles.size());
    for (const auto& [a, b, c] : triangles) fmt::format_to(out, ",\n<{},{},{}>", a, b, c);
    text += " }\n";
}

std::vector<std::string> povray_object_names(std::string_view scene_name,
                                             std::span<const std::string> names) {
    std::set<std::string> taken;
    std::vector<std::string> objects;
    for (const std::string& name : names) {
        const std::string wanted = povray_identifier(scene_name) + "_" + povray_identifier(name);
        objects.push_back(unique_name(wanted, taken));
    }
    return objects;
}

Result<std::string> povray_camera(const Camera& camera, double scale) {
    assert(scale > 0 && std::isfinite(scale));
    const std::string where = "camera";
    if (!is_finite(camera.position) || !is_finite(camera.target))
        return Error{where, "position or target is not finite"};
    if (!(camera.vertical_fov > 0 && camera.vertical_fov < pi))
        return Error{where, fmt::format("field of view is {} rad; expected (0, pi)", camera.vertical_fov)};
    if (camera.width < 1 || camera.height < 1)
        return Error{where, fmt::format("resolution is {} x {}; expected at least 1 x 1", camera.width,
                                        camera.height)};
    const Vec3d to_target = Vec3d(camera.target) - Vec3d(camera.position);
    if (!(to_target.length() > 0)) return Error{where, "the target is at the position"};

    auto [forward, right, up] = camera_frame(camera);
    const Vec3d direction = forward * (0.5 / std::tan(0.5 * static_cast<double>(camera.vertical_fov)));
    right *= static_cast<double>(camera.width) / camera.height;
    const Vec3d location = Vec3d(camera.position) * scale;
    const auto vector = [](const Vec3d& v) {
        return fmt::format("<{:.12g}, {:.12g}, {:.12g}>", v.x, v.y, v.z);
    };
    return fmt::format(
        "camera {{\n"
        "  perspective\n"
        "  location {}\n"
        "  direction {}\n"
        "  right {}\n"
        "  up {}\n"
        "}}\n",
        vector(location), vector(direction), vector(right), vector(up));
}

std::string with_gamma(std::string text, double assumed_gamma) {
    if (assumed_gamma == 1) return text;
    constexpr std::string_view end = ".exr\"";
    const std::string gamma = fmt::format(" gamma {:.6g}", assumed_gamma);
    for (std::size_t at = text.find(end); at != std::string::npos; at = text.find(end, at))
        text.insert(at += end.size(), gamma);
    return text;
}

Result<std::string> write_background(const std::filesystem::path& folder, const std::string& stem,
                                     const BackgroundDescription& background) {
    const std::string guard = fmt::format("#ifndef ({})\n", without_background);
    if (!background.environment) return guard + "background { rgb 0 }\n#end\n";
    const LatLongImage& environment = *background.environment;
    const std::string name = stem + "_environment.exr";
    HF_TRY_DONE(write_environment_image(environment, folder / name));
    // The rows of the matrix are the world directions of the image's left edge at the horizon, of its top,
    // and of a quarter from the left edge; see lat_long_direction.
    std::string pigment = fmt::format(
        "  pigment {{\n"
        "    image_map {{ exr \"{}\" map_type 1 interpolate 2 once }}\n"
        "    matrix <0, 0, -1,  0, 1, 0,  1, 0, 0,  0, 0, 0>\n",
        name);
    pigment = with_gamma(std::move(pigment), background.assumed_gamma);
    std::string text = guard + "sky_sphere {\n" + pigment + "  }\n}\n";
    if (background.is_reflected)  // Visible only in mirrors.
        text += "#else\nsphere {\n  0, 1\n" + pigment +
                "  }\n  finish { ambient 0 diffuse 0 emission 1 }\n  hollow no_image no_shadow no_radiosity\n"
                "  scale 5e6\n}\n";
    return text + "#end\n";
}

double small_triangle_scale(const Mesh& mesh) {
    double shortest = INFINITY, smallest = INFINITY, largest = 0;
    for (const auto& triangle : mesh.triangles) {
        const Vec3d a(mesh.positions[triangle[0]]), b(mesh.positions[triangle[1]]),
            c(mesh.positions[triangle[2]]);
        for (const double edge : {(b - a).length(), (c - b).length(), (a - c).length()})
            if (edge > 0) shortest = std::min(shortest, edge);
        if (const double area = (b - a).cross(c - a).length(); area > 0) smallest = std::min(smallest, area);
        for (int axis = 0; axis < 3; ++axis)
            largest = std::max({largest, std::abs(a[axis]), std::abs(b[axis]), std::abs(c[axis])});
    }
    if (!std::isfinite(shortest)) return 1;
    double wanted = std::ceil(std::log2(shortest_edge / shortest));
    if (std::isfinite(smallest))
        wanted = std::max(wanted, std::ceil(std::log2(smallest_parallelogram / smallest) / 2));
    if (largest > 0) wanted = std::min(wanted, std::floor(std::log2(largest_scaled_coordinate / largest)));
    return std::exp2(std::clamp(wanted, -20.0, 40.0));
}

Rotation interpolation_rotation(const Mesh& mesh) {
    std::vector<Vec3d> normals;
    for (const auto& triangle : mesh.triangles) {
        const Vec3d a(mesh.positions[triangle[0]]), b(mesh.positions[triangle[1]]),
            c(mesh.positions[triangle[2]]);
        const Vec3d normal = (b - a).cross(c - a);
        if (const double length = normal.length(); length > 0) normals.push_back(normal / length);
    }
    // Triangles exactly parallel to z are harmless. Without other triangles near z the mesh stays unrotated.
    const auto harm = [](const Vec3d& normal) {
        return std::abs(normal.z) > 1e-9 && std::abs(normal.z) < 0.01;
    };
    if (std::none_of(normals.begin(), normals.end(), harm)) return {};
    // Candidates for the new z axis, evenly distributed over a hemisphere.
    constexpr std::size_t candidates = 97;
    Vec3d best(0, 0, 1);
    double best_least = -1;
    for (std::size_t k = 0; k < candidates; ++k) {
        const Vec3d axis = spiral_direction(k, (double(k) + 0.5) / candidates);
        double least = 1;
        for (const Vec3d& normal : normals) {
            least = std::min(least, std::abs(normal.dot(axis)));
            if (least <= best_least) break;
        }
        if (least > best_least) {
            best_least = least;
            best = axis;
        }
    }
    const Vec3d x = best.cross(std::abs(best.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).normalized();
    return {{x, best.cross(x), best}};
}

bool is_sliver(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle, double scale) {
    const Vec3d a(mesh.positions[triangle[0]]), b(mesh.positions[triangle[1]]),
        c(mesh.positions[triangle[2]]);
    return (b - a).cross(c - a).length() * scale * scale < sliver_parallelogram;
}

Result<Done> check_povray_mesh(const Mesh& mesh, const std::string& where) {
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        for (int axis = 0; axis < 3; ++axis)
            if (!coordinates.contains(double(mesh.positions[i][axis])))
                return Error{where, fmt::format("vertex {} has the coordinate {}; expected at most {} m", i,
                                                mesh.positions[i][axis], coordinates.highest)};
    if (mesh.triangles.empty()) return Error{where, "the mesh has no triangle"};
    for (const auto& triangle : mesh.triangles)
        for (std::uint32_t index : triangle)
            if (index >= mesh.positions.size())
                return Error{where, fmt::format("a triangle has the vertex index {}; expected less than {}",
                                                index, mesh.positions.size())};
    return Done{};
}

Result<Done> check_placement(const std::string& where, const Placement& placement) {
    const auto& [translate, scale, rotate] = placement;
    for (int axis = 0; axis < 3; ++axis)
        if (!coordinates.contains(double(translate[axis])))
            return Error{where, fmt::format("the translation is {}; expected at most {} m", translate[axis],
                                            coordinates.highest)};
    if (!(scale > 0 && scale <= 1e6f))
        return Error{where, fmt::format("scale is {}; expected (0, 1e6]", scale)};
    for (const Vec3d& row : rotate.row)
        if (!(row.length() <= 2)) return Error{where, "the rotation is not finite"};
    return Done{};
}

}  // namespace haarfield
