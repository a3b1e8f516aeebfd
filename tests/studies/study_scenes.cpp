#include "tests/studies/study_scenes.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <random>

#include "tests/baselines/scene_integrals.h"

namespace haarfield::baseline {
namespace {

/// Writes the surface of a cube of cells, moved by a function of the point on the cube.
///
/// cells    along an edge.
/// first    number of the first vertex, from 1.
/// returns  the number after that of the last vertex.
template <class Moved>
int write_cube(std::ostream& out, int cells, const Moved& moved, int first = 1) {
    const std::array<std::array<Vec3d, 3>, 6> sides{{{Vec3d(1, 0, 0), Vec3d(0, 0, -1), Vec3d(0, 1, 0)},
                                                     {Vec3d(-1, 0, 0), Vec3d(0, 0, 1), Vec3d(0, 1, 0)},
                                                     {Vec3d(0, 1, 0), Vec3d(1, 0, 0), Vec3d(0, 0, -1)},
                                                     {Vec3d(0, -1, 0), Vec3d(1, 0, 0), Vec3d(0, 0, 1)},
                                                     {Vec3d(0, 0, 1), Vec3d(1, 0, 0), Vec3d(0, 1, 0)},
                                                     {Vec3d(0, 0, -1), Vec3d(-1, 0, 0), Vec3d(0, 1, 0)}}};
    for (const auto& [middle, across, up] : sides) {
        for (int y = 0; y <= cells; ++y)
            for (int x = 0; x <= cells; ++x) {
                const Vec3d at = moved(middle + across * (2.0 * x / cells - 1) + up * (2.0 * y / cells - 1));
                out << fmt::format("v {:.7f} {:.7f} {:.7f}\n", at.x, at.y, at.z);
            }
        for (int y = 0; y < cells; ++y)
            for (int x = 0; x < cells; ++x) {
                const int a = first + y * (cells + 1) + x, c = a + cells + 1;
                out << fmt::format("f {} {} {}\nf {} {} {}\n", a, a + 1, c + 1, a, c + 1, c);
            }
        first += (cells + 1) * (cells + 1);
    }
    return first;
}

/// Opens a file, with its folder.
std::ofstream new_file(const std::filesystem::path& file) {
    std::filesystem::create_directories(file.parent_path());
    return std::ofstream(file);
}

/// Returns numbers from 0 to 1.
class RandomNumbers {
public:
    explicit RandomNumbers(std::uint32_t seed) : random_(seed) {}
    double operator()() { return double(random_()) * 0x1p-32; }

private:
    std::mt19937 random_;
};

/// Returns a point on a rounded box, from one on the cube.
///
/// power  2: an ellipsoid; the larger, the less round.
Vec3d on_rounded_box(const Vec3d& cube, const Vec3d& middle, const Vec3d& size, double power) {
    const double sum = std::pow(std::abs(cube.x), power) + std::pow(std::abs(cube.y), power) +
                       std::pow(std::abs(cube.z), power);
    return middle + cube * std::pow(sum, -1 / power) * size;
}

/// Returns the floor of the shipped scene.
Scene empty_floor(float width, std::uint32_t vertices) {
    constexpr float shipped_floor_width = 6;
    Scene scene = shipped_scene().description;
    std::erase_if(scene.instances, [](const Instance& instance) { return instance.name != "floor"; });
    Entity floor = scene.entities[scene.instances[0].entity];
    floor.fine_vertices = vertices;
    scene.entities = {floor};
    scene.instances[0].entity = 0;
    scene.instances[0].placement.scale = width / shipped_floor_width;
    return scene;
}

Entity entity_of(const std::string& name, const std::filesystem::path& mesh, const std::string& material,
                 std::uint32_t vertices) {
    Entity entity;
    entity.name = name;
    entity.mesh = mesh;
    entity.material = material;
    entity.fine_vertices = vertices;
    return entity;
}

}  // namespace

Scene crowd(const Scene& shipped, int rows, int columns, bool turned) {
    constexpr float floor_width = 40, shipped_floor_width = 6;
    RandomNumbers random(1);
    const auto number = [&] { return static_cast<float>(random() - 0.5); };
    Scene scene = shipped;
    std::erase_if(scene.instances, [](const Instance& instance) { return instance.name != "floor"; });
    scene.instances[0].placement.scale = floor_width / shipped_floor_width;
    const auto chair = std::ranges::find(scene.entities, "chair", &Entity::name) - scene.entities.begin();
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const float across = static_cast<float>(columns), along = static_cast<float>(rows),
                        x = (static_cast<float>(column) + 0.5f + 0.3f * number()) / across - 0.5f,
                        z = (static_cast<float>(row) + 0.5f + 0.3f * number()) / along - 0.5f;
            Placement placement{{x * floor_width, 0, z * floor_width}, 1};
            if (turned) {
                placement.scale = 1 + 0.6f * number();
                const float lean = (row + column) % 3 == 0 ? 0.2f * number() : 0;
                placement.rotate = rotation_xyz({lean, 6.28f * number(), 0});
            }
            scene.instances.push_back(
                {fmt::format("chair_{}", scene.instances.size()), std::size_t(chair), placement});
        }
    return scene;
}

Scene scanned_model(const std::filesystem::path& folder) {
    Scene scene = empty_floor(3, 20000);
    // A body with limbs and the small bumps of a scan.
    const auto moved = [](const Vec3d& cube) {
        const Vec3d d = cube.normalized();
        double radius = 0.3;
        for (const Vec3d& limb : {Vec3d(0.8, 0.5, 0.3), Vec3d(-0.7, 0.6, 0.2), Vec3d(0.2, 0.9, -0.4)})
            radius += 0.25 * std::exp(12 * (d.dot(limb.normalized()) - 1));
        radius += 0.02 * std::sin(9 * d.x + 3 * d.z) * std::sin(8 * d.y) * std::sin(7 * d.z + 4 * d.x);
        radius += 0.004 * std::sin(40 * d.x) * std::sin(37 * d.y) * std::sin(43 * d.z);
        return d * radius + Vec3d(0, 0.33, 0);
    };
    const std::filesystem::path file = folder / "scan.obj";
    std::ofstream out = new_file(file);
    write_cube(out, 108, moved);
    out.close();
    scene.entities.push_back(entity_of("scan", file, "linen", 35000));
    scene.instances.push_back({"scan", 1, {}});
    return scene;
}

Scene model_of_parts(const std::filesystem::path& folder) {
    constexpr int parts = 39, cells = 8;
    constexpr std::uint32_t part_vertices = 1000, planar_samples = 1052, spherical_samples = 526;
    Scene scene = empty_floor(6, 40000);
    RandomNumbers number(39);
    for (int part = 0; part < parts; ++part) {
        // Rounded boxes of several shapes, three to a storey, that nearly touch each other.
        const double height = 0.05 + 0.13 * (part / 3), angle = 2.1 * part, power = 2 + 6 * number();
        const Vec3d size(0.05 + 0.08 * number(), 0.055 + 0.01 * number(), 0.05 + 0.08 * number());
        const Vec3d middle(0.14 * std::cos(angle), height + 0.02, 0.14 * std::sin(angle));
        const std::string name = fmt::format("part_{}", part);
        const std::filesystem::path file = folder / (name + ".obj");
        std::ofstream out = new_file(file);
        write_cube(out, cells, [&](const Vec3d& cube) { return on_rounded_box(cube, middle, size, power); });
        out.close();
        scene.entities.push_back(entity_of(name, file, part % 2 == 0 ? "walnut" : "linen", part_vertices));
        scene.entities.back().planar_samples = planar_samples;  // as `import` chooses for so many parts
        scene.entities.back().spherical_samples = spherical_samples;
        scene.instances.push_back({name, scene.entities.size() - 1, {}});
    }
    return scene;
}

Scene model_of_pieces(const std::filesystem::path& folder) {
    constexpr int pieces = 231, cells = 6;
    Scene scene = empty_floor(6, 40000);
    RandomNumbers number(231);
    const std::filesystem::path file = folder / "pieces.obj";
    std::ofstream out = new_file(file);
    int vertex = 1;
    for (int piece = 0; piece < pieces; ++piece) {
        // Small pieces on the surface of a long body, which is the first of them.
        const double angle = 2.4 * piece, power = 2 + 6 * number();
        const double along = 1.3 * (number() - 0.5), radius = 0.2 * (1 - along * along);
        const bool is_body = piece == 0;
        const Vec3d size =
            is_body ? Vec3d(0.7, 0.2, 0.2)
                    : Vec3d(0.02 + 0.06 * number(), 0.01 + 0.03 * number(), 0.01 + 0.05 * number());
        const Vec3d middle = is_body ? Vec3d(0, 0.3, 0)
                                     : Vec3d(along, 0.3 + radius * std::cos(angle), radius * std::sin(angle));
        vertex = write_cube(
            out, is_body ? 2 * cells : cells,
            [&](const Vec3d& cube) { return on_rounded_box(cube, middle, size, power); }, vertex);
    }
    out.close();
    scene.entities.push_back(entity_of("pieces", file, "linen", 60000));
    scene.instances.push_back({"pieces", 1, {}});
    return scene;
}

Scene leaf_cards(const std::filesystem::path& folder) {
    constexpr int cards = 2000;
    Scene scene = empty_floor(4, 20000);
    RandomNumbers number(2000);
    const std::filesystem::path file = folder / "cards.obj";
    std::ofstream out = new_file(file);
    for (int card = 0; card < cards; ++card) {
        // Squares in all directions, in a cone like that of a small pine.
        const double height = 1 - std::sqrt(number()), angle = 2 * pi * number();
        const double radius = 0.35 * (1 - height) * std::sqrt(number());
        const Vec3d middle(radius * std::cos(angle), 0.15 + 0.9 * height, radius * std::sin(angle));
        const auto random_vector = [&] { return Vec3d(number() - 0.5, number() - 0.5, number() - 0.5); };
        const Vec3d across = 0.03 * random_vector().normalized(),
                    up = 0.03 * across.cross(random_vector()).normalized();
        for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
            const Vec3d corner = middle + double(x) * across + double(y) * up;
            out << fmt::format("v {:.7f} {:.7f} {:.7f}\n", corner.x, corner.y, corner.z);
        }
        const int first = 4 * card + 1;
        out << fmt::format("f {} {} {} {}\n", first, first + 1, first + 2, first + 3);
    }
    out.close();
    scene.entities.push_back(entity_of("cards", file, "linen", 20000));
    scene.instances.push_back({"cards", 1, {}});
    return scene;
}

}  // namespace haarfield::baseline
