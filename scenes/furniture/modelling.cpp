#include "scenes/furniture/modelling.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <map>

namespace haarfield {

namespace {

using Vec2d = Imath::V2d;
constexpr double crease_cosine = 0.7;  // 45 degrees

struct ProfileVertex {
    Vec2d place, normal;
};

/// Returns the points of a profile with normals; points at sharp edges occur twice. `flat_ends`: a flat face
/// adjoins each end and keeps its normal.
std::vector<ProfileVertex> profile_vertices(const Profile& profile, bool flat_ends) {
    const std::size_t count = profile.points.size();
    std::vector<Vec2d> place, direction;  // direction[i]: to place i, with its length as weight.
    for (const Profile::Point& p : profile.points) place.emplace_back(p.radius, p.height);
    direction.emplace_back(flat_ends ? 1e3 : 0.0, 0.0);
    for (std::size_t i = 1; i < count; ++i) direction.push_back(place[i] - place[i - 1]);
    direction.emplace_back(flat_ends ? -1e3 : 0.0, 0.0);

    const auto normal = [](const Vec2d& along) { return Vec2d(along.y, -along.x).normalized(); };
    std::vector<ProfileVertex> vertices;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec2d &before = direction[i], &after = direction[i + 1];
        const bool at_end = before.length2() == 0 || after.length2() == 0;
        if (at_end || before.normalized().dot(after.normalized()) > crease_cosine) {
            vertices.push_back({place[i], normal(before + after)});
        } else {
            vertices.push_back({place[i], normal(before)});
            vertices.push_back({place[i], normal(after)});
        }
    }
    return vertices;
}

void add_quad(Shell& shell, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    const auto length2 = [&](std::uint32_t i, std::uint32_t j) {
        return (shell.positions[i] - shell.positions[j]).length2();
    };
    if (length2(a, c) <= length2(b, d) * (1 + 1e-9))
        shell.triangles.insert(shell.triangles.end(), {{a, b, c}, {a, c, d}});
    else
        shell.triangles.insert(shell.triangles.end(), {{a, b, d}, {b, c, d}});
}

std::uint32_t add_vertex(Shell& shell, const Vec3d& position, const Vec3d& normal) {
    shell.positions.push_back(position);
    shell.normals.push_back(normal);
    return static_cast<std::uint32_t>(shell.positions.size() - 1);
}

/// Connects two rings of vertices that start at `below` and `above`.
void add_band(Shell& shell, std::uint32_t below, std::uint32_t above, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t next = (i + 1) % count;
        add_quad(shell, below + i, below + next, above + next, above + i);
    }
}

}  // namespace

Profile& Profile::to(double radius, double height) {
    points.push_back({radius, height});
    return *this;
}

Profile& Profile::bead(double bulge, double height, int steps) {
    const Point start = points.back();
    for (int i = 1; i <= steps; ++i) {
        const double t = static_cast<double>(i) / steps;
        to(start.radius + bulge * (i == steps ? 0.0 : std::sin(pi * t)),
           start.height + (height - start.height) * 0.5 * (1 - std::cos(pi * t)));
    }
    return *this;
}

Profile& Profile::swelling(double radius, double height, double swell, int steps) {
    const Point start = points.back();
    for (int i = 1; i <= steps; ++i) {
        const double t = static_cast<double>(i) / steps;
        to(start.radius + (radius - start.radius) * t + (i == steps ? 0.0 : swell * std::sin(pi * t)),
           start.height + (height - start.height) * t);
    }
    return *this;
}

Profile& Profile::ease(double radius, double height, int steps) {
    const Point start = points.back();
    for (int i = 1; i <= steps; ++i) {
        const double t = static_cast<double>(i) / steps;
        to(start.radius + (radius - start.radius) * 0.5 * (1 - std::cos(pi * t)),
           start.height + (height - start.height) * t);
    }
    return *this;
}

Profile& Profile::round(double radius, double height, int steps, bool leaves_upright) {
    const Point start = points.back();
    for (int i = 1; i < steps; ++i) {
        const double a = 0.5 * pi * i / steps;
        const double slow = 1 - std::cos(a), fast = std::sin(a);
        to(start.radius + (radius - start.radius) * (leaves_upright ? slow : fast),
           start.height + (height - start.height) * (leaves_upright ? fast : slow));
    }
    return to(radius, height);
}

Shell lathe(const Profile& profile, int segments) {
    assert(profile.points.front().radius == 0 && profile.points.back().radius == 0);
    Shell shell;
    const auto count = static_cast<std::uint32_t>(segments);
    const std::vector<ProfileVertex> vertices = profile_vertices(profile, false);
    const std::uint32_t bottom = add_vertex(shell, {0, vertices.front().place.y, 0}, {0, -1, 0});
    const std::uint32_t top = add_vertex(shell, {0, vertices.back().place.y, 0}, {0, 1, 0});
    std::uint32_t below = 0;
    for (std::size_t k = 1; k + 1 < vertices.size(); ++k) {
        const auto& [place, normal] = vertices[k];
        const auto ring = static_cast<std::uint32_t>(shell.positions.size());
        for (std::uint32_t i = 0; i < count; ++i) {
            const double a = 2 * pi * i / count;
            const Vec3d out(std::cos(a), 0, -std::sin(a));
            add_vertex(shell, out * place.x + Vec3d(0, place.y, 0), out * normal.x + Vec3d(0, normal.y, 0));
        }
        if (k == 1)
            for (std::uint32_t i = 0; i < count; ++i)
                shell.triangles.push_back({bottom, ring + (i + 1) % count, ring + i});
        else if (vertices[k - 1].place != place)
            add_band(shell, below, ring, count);
        below = ring;
    }
    for (std::uint32_t i = 0; i < count; ++i)
        shell.triangles.push_back({top, below + i, below + (i + 1) % count});
    return shell;
}

Shell board(const Board& shape, const Profile& edge) {
    // The outline, from +x towards -z: counter-clockwise as viewed from above.
    struct OutlinePoint {
        Vec2d centre, out;  // x and z: of the corner's circle or of the side; direction away from it.
        int column, row;    // The adjacent point of the inner grid.
    };
    const double inner_x = shape.half_x - shape.corner, inner_z = shape.half_z - shape.corner;
    const auto grid_place = [&](int column, int row) {
        return Vec2d(inner_x * (2.0 * column / shape.steps_x - 1), inner_z * (2.0 * row / shape.steps_z - 1));
    };
    std::vector<OutlinePoint> outline;
    std::array<int, 2> at{shape.steps_x, 0};
    const std::array<std::array<int, 2>, 4> direction{{{-1, 0}, {0, 1}, {1, 0}, {0, -1}}};
    for (int corner = 0; corner < 4; ++corner) {
        for (int i = 0; i <= shape.steps_corner; ++i) {
            const double a = 0.5 * pi * (corner + static_cast<double>(i) / shape.steps_corner);
            outline.push_back({grid_place(at[0], at[1]), {std::cos(a), -std::sin(a)}, at[0], at[1]});
        }
        const int steps = corner % 2 ? shape.steps_z : shape.steps_x;
        for (int i = 1; i <= steps; ++i) {
            at = {at[0] + direction[corner][0], at[1] + direction[corner][1]};
            if (i < steps) outline.push_back({grid_place(at[0], at[1]), outline.back().out, at[0], at[1]});
        }
    }

    Shell shell;
    const auto count = static_cast<std::uint32_t>(outline.size());
    const std::vector<ProfileVertex> vertices = profile_vertices(edge, true);
    for (std::size_t k = 0; k < vertices.size(); ++k) {
        const auto& [place, normal] = vertices[k];
        const auto ring = static_cast<std::uint32_t>(shell.positions.size());
        for (const OutlinePoint& p : outline) {
            const Vec2d flat = p.centre + p.out * (shape.corner + place.x);
            add_vertex(shell, {flat.x, place.y, flat.y}, {p.out.x * normal.x, normal.y, p.out.y * normal.x});
        }
        if (k > 0 && vertices[k - 1].place != place) add_band(shell, ring - count, ring, count);
    }
    const auto add_cap = [&](std::uint32_t ring, double height, bool up) {
        const auto grid = static_cast<std::uint32_t>(shell.positions.size());
        for (int row = 0; row <= shape.steps_z; ++row)
            for (int column = 0; column <= shape.steps_x; ++column) {
                const Vec2d flat = grid_place(column, row);
                add_vertex(shell, {flat.x, height, flat.y}, {0, up ? 1.0 : -1.0, 0});
            }
        const auto index = [&](int column, int row) {
            return grid + static_cast<std::uint32_t>(row * (shape.steps_x + 1) + column);
        };
        const std::size_t first = shell.triangles.size();
        for (int row = 0; row < shape.steps_z; ++row)
            for (int column = 0; column < shape.steps_x; ++column)
                add_quad(shell, index(column, row), index(column, row + 1), index(column + 1, row + 1),
                         index(column + 1, row));
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t next = (i + 1) % count;
            const std::uint32_t a = index(outline[i].column, outline[i].row);
            const std::uint32_t b = index(outline[next].column, outline[next].row);
            if (a == b)
                shell.triangles.push_back({a, ring + i, ring + next});
            else
                add_quad(shell, a, ring + i, ring + next, b);
        }
        if (!up)
            for (std::size_t t = first; t < shell.triangles.size(); ++t)
                std::swap(shell.triangles[t][1], shell.triangles[t][2]);
    };
    const auto last_ring = static_cast<std::uint32_t>(shell.positions.size()) - count;
    add_cap(0, vertices.front().place.y, false);
    add_cap(last_ring, vertices.back().place.y, true);
    return shell;
}

Shell rounded_box(const RoundedBox& shape) {
    // Builds the grid of a cube, then moves its outermost `steps` lines onto the rounded edges.
    std::array<std::vector<double>, 3> lines;
    const Vec3d inner_lower = shape.lower + Vec3d(shape.radius),
                inner_upper = shape.upper - Vec3d(shape.radius);
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = shape.steps; i >= 0; --i)
            lines[axis].push_back(inner_lower[axis] - shape.radius * std::tan(0.25 * pi * i / shape.steps));
        for (double line : shape.lines[axis]) {
            assert(line > inner_lower[axis] && line < inner_upper[axis]);
            lines[axis].push_back(line);
        }
        for (int i = 0; i <= shape.steps; ++i)
            lines[axis].push_back(inner_upper[axis] + shape.radius * std::tan(0.25 * pi * i / shape.steps));
    }
    Shell shell;
    const auto add_side = [&](int axis, bool upper) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto first = static_cast<std::uint32_t>(shell.positions.size());
        for (double line_v : lines[v])
            for (double line_u : lines[u]) {
                Vec3d p, inner;
                p[axis] = upper ? shape.upper[axis] : shape.lower[axis];
                p[u] = line_u;
                p[v] = line_v;
                for (int k = 0; k < 3; ++k) inner[k] = std::clamp(p[k], inner_lower[k], inner_upper[k]);
                const Vec3d out = (p - inner).normalized();
                add_vertex(shell, inner + out * shape.radius, out);
            }
        const auto width = static_cast<std::uint32_t>(lines[u].size());
        for (std::uint32_t j = 0; j + 1 < lines[v].size(); ++j)
            for (std::uint32_t i = 0; i + 1 < width; ++i) {
                const std::uint32_t a = first + j * width + i, b = a + 1, c = b + width, d = a + width;
                if (upper)
                    add_quad(shell, a, b, c, d);
                else
                    add_quad(shell, a, d, c, b);
            }
    };
    for (int axis = 0; axis < 3; ++axis)
        for (bool upper : {false, true}) add_side(axis, upper);
    return shell;
}

Shell block_sides(const Blocks& blocks,
                  const std::function<bool(const Vec3d& middle, const Vec3d& normal)>& is_wanted) {
    const auto& lines = blocks.lines;
    using Cell = std::array<std::size_t, 3>;
    const auto middle_of = [&](const Cell& cell) {
        Vec3d middle;
        for (std::size_t k = 0; k < 3; ++k)
            middle[int(k)] = 0.5 * (lines[k][cell[k]] + lines[k][cell[k] + 1]);
        return middle;
    };
    Shell shell;
    std::map<std::pair<std::size_t, Cell>, std::uint32_t> known;  // By direction and position of the side.
    const auto add_side = [&](const Cell& cell, std::size_t axis, bool upper) {
        Vec3d side = middle_of(cell), normal(0.0);
        side[int(axis)] = lines[axis][cell[axis] + upper];
        normal[int(axis)] = upper ? 1 : -1;
        if (!is_wanted(side, normal)) return;
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        std::array<std::uint32_t, 4> corner{};
        for (std::size_t k = 0; k < 4; ++k) {
            Cell place = cell;
            place[axis] += upper;
            place[u] += k == 1 || k == 2;
            place[v] += k >= 2;
            const auto [found, is_new] = known.try_emplace({2 * axis + upper, place}, 0);
            if (is_new)
                found->second =
                    add_vertex(shell, {lines[0][place[0]], lines[1][place[1]], lines[2][place[2]]}, normal);
            corner[k] = found->second;
        }
        if (!upper) std::swap(corner[1], corner[3]);
        add_quad(shell, corner[0], corner[1], corner[2], corner[3]);
    };
    for (std::size_t x = 0; x + 1 < lines[0].size(); ++x)
        for (std::size_t y = 0; y + 1 < lines[1].size(); ++y)
            for (std::size_t z = 0; z + 1 < lines[2].size(); ++z) {
                const Cell cell{x, y, z};
                if (!blocks.is_solid(middle_of(cell))) continue;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    for (const bool upper : {false, true}) {
                        Cell beside = cell;
                        beside[axis] += upper ? 1 : std::size_t(-1);
                        const bool is_outermost =
                            upper ? beside[axis] + 1 == lines[axis].size() : cell[axis] == 0;
                        if (is_outermost || !blocks.is_solid(middle_of(beside))) add_side(cell, axis, upper);
                    }
            }
    return shell;
}

Shell bent(Shell shell, const std::function<Vec3d(const Vec3d&)>& map) {
    constexpr double step = 1e-5;
    for (std::size_t i = 0; i < shell.positions.size(); ++i) {
        const Vec3d p = shell.positions[i], n = shell.normals[i];
        std::array<Vec3d, 3> column;
        for (int axis = 0; axis < 3; ++axis) {
            Vec3d offset(0, 0, 0);
            offset[axis] = step;
            column[axis] = map(p + offset) - map(p - offset);
        }
        shell.positions[i] = map(p);
        shell.normals[i] = (column[1].cross(column[2]) * n.x + column[2].cross(column[0]) * n.y +
                            column[0].cross(column[1]) * n.z)
                               .normalized();
    }
    return shell;
}

Shell moved(Shell shell, const Vec3d& by) {
    for (Vec3d& p : shell.positions) p += by;
    return shell;
}

Shell aligned(Shell shell, const Vec3d& from, const Vec3d& to) {
    const Vec3d y = (to - from).normalized();
    const Vec3d x = y.cross(std::abs(y.y) < 0.9 ? Vec3d(0, 1, 0) : Vec3d(0, 0, 1)).normalized();
    const Vec3d z = x.cross(y);
    for (std::size_t i = 0; i < shell.positions.size(); ++i) {
        const Vec3d p = shell.positions[i], n = shell.normals[i];
        shell.positions[i] = from + x * p.x + y * p.y + z * p.z;
        shell.normals[i] = x * n.x + y * n.y + z * n.z;
    }
    return shell;
}

void append(Mesh& mesh, const Shell& shell, const std::string& material) {
    auto known = std::find(mesh.material_names.begin(), mesh.material_names.end(), material);
    if (known == mesh.material_names.end()) known = mesh.material_names.insert(known, material);
    const auto index = static_cast<std::uint16_t>(known - mesh.material_names.begin());
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (std::size_t i = 0; i < shell.positions.size(); ++i) {
        mesh.positions.emplace_back(shell.positions[i]);
        mesh.normals.emplace_back(shell.normals[i]);
        mesh.vertex_materials.push_back(index);
    }
    for (const auto& t : shell.triangles)
        mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

std::string obj_text(const Mesh& mesh) {
    const auto decimal = [](float value, double unit, int digits) {
        const double rounded = std::round(static_cast<double>(value) / unit) * unit;
        return fmt::format("{:.{}f}", rounded == 0 ? 0.0 : rounded, digits);  // Avoids -0.
    };
    std::map<std::string, std::size_t> places, normals;
    std::vector<std::string> corner(mesh.positions.size());
    std::string place_lines, normal_lines;
    const auto numbered = [](std::map<std::string, std::size_t>& known, std::string& lines, const char* key,
                             const std::string& text) {
        const auto [found, is_new] = known.try_emplace(text, known.size() + 1);
        if (is_new) lines += key + text + "\n";
        return found->second;
    };
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        std::string place, normal;
        for (int axis = 0; axis < 3; ++axis) {
            place += fmt::format(" {}", decimal(mesh.positions[i][axis], 1e-6, 6));
            normal += fmt::format(" {}", decimal(mesh.normals[i][axis], 1e-4, 4));
        }
        const std::size_t p = numbered(places, place_lines, "v", place);
        const std::size_t n = numbered(normals, normal_lines, "vn", normal);
        corner[i] = fmt::format("{}//{}", p, n);
    }
    std::string text = place_lines + normal_lines;
    std::string material;
    for (const auto& t : mesh.triangles) {
        const std::string& wanted = mesh.material_names[mesh.vertex_materials[t[0]]];
        if (wanted != material) text += "usemtl " + wanted + "\n";
        material = wanted;
        text += fmt::format("f {} {} {}\n", corner[t[0]], corner[t[1]], corner[t[2]]);
    }
    return text;
}

}  // namespace haarfield
