#include "scenes/furniture/furniture.h"

#include "scenes/furniture/modelling.h"

#include <random>

namespace haarfield {

namespace {

/// The bottom of everything that stands on the floor: flat, with a slightly rounded edge.
Profile foot(double radius) {
    Profile profile;
    profile.to(0, 0).to(radius - 0.003, 0).round(radius, 0.003, 1, false);
    return profile;
}

/// Returns evenly spaced lines strictly between two planes.
std::vector<double> lines_between(double lower, double upper, int parts) {
    std::vector<double> lines;
    for (int i = 1; i < parts; ++i) lines.push_back(lower + (upper - lower) * i / parts);
    return lines;
}

// ---- table

constexpr double table_underside = 0.722;
constexpr double table_leg_x = 0.700, table_leg_z = 0.350;
constexpr double block_half = 0.037, block_bottom = 0.600;

Shell table_top() {
    Profile edge;
    edge.to(-0.030, table_underside)
        .round(-0.004, 0.736, 2, false)
        .to(0, 0.739)
        .to(0, 0.743)
        .round(-0.007, 0.750, 3, true);
    return board({0.8, 0.45, 0.055, 8, 4, 4}, edge);
}

Shell table_leg() {
    Profile profile = foot(0.017);
    profile.swelling(0.018, 0.052, 0.009, 3)
        .to(0.024, 0.055)
        .to(0.0255, 0.060)
        .to(0.024, 0.065)
        .to(0.0195, 0.070)
        .swelling(0.031, 0.400, 0.003, 2)
        .ease(0.0205, 0.478, 3)
        .to(0.027, 0.481)
        .bead(0.006, 0.497, 3)
        .to(0.022, 0.500)
        .to(0.0235, 0.524)
        .to(0.030, 0.527)
        .bead(0.005, 0.547, 2)
        .to(0.0275, 0.550)
        .to(0.034, block_bottom)
        .to(0, block_bottom + 0.008);
    return lathe(profile, 12);
}

/// Makes the square end of a leg. Its rounded upper edge begins where it enters the top. A line of vertices
/// runs along the outer face of each apron.
Shell table_block(double side_x, double side_z) {
    constexpr double round = 0.004;
    RoundedBox shape{{-block_half, block_bottom, -block_half},
                     {block_half, table_underside + round, block_half},
                     round,
                     1};
    shape.lines[0] = {side_x * 0.0185};
    shape.lines[2] = {side_z * 0.0185};
    return rounded_box(shape);
}

/// Makes the apron between two blocks at distance `reach` from the middle, along x. Its rounded edges begin
/// where it enters the blocks.
Shell apron(double reach) {
    constexpr double round = 0.003;
    const double half = reach - block_half + round;
    RoundedBox shape{{-half, 0.640, -0.011}, {half, table_underside + round, 0.011}, round, 1};
    shape.lines[0] = lines_between(-half, half, 4);
    return rounded_box(shape);
}

Vec3d quarter_turn(const Vec3d& p) {
    return {p.z, p.y, -p.x};
}

// ---- chair, facing +z

constexpr double board_bottom = 0.405, board_top = 0.428;
constexpr double front_leg_x = 0.185, front_leg_z = 0.165;
constexpr double post_x = 0.178, post_z = -0.180;
constexpr double crest_lower = 0.830, crest_upper = 0.925, rail_lower = 0.545, rail_upper = 0.585;

/// Returns the z offset of the back post at a height: a sabre curve, upright at the seat.
double rake(double height) {
    const double above = std::max(0.0, height - board_top), below = std::max(0.0, board_top - height);
    return -0.42 * above * above - 0.20 * below * below;
}

/// Maps the flat plan of the back (x across, y up, z thickness) to its position between the posts.
Vec3d on_the_back(const Vec3d& p) {
    const double bow = 0.030 * (1 - p.x * p.x / (post_x * post_x));
    return {p.x, p.y, p.z + post_z + rake(p.y) - bow};
}

Shell front_leg() {
    Profile profile = foot(0.0115);
    profile.swelling(0.012, 0.040, 0.005, 3)
        .to(0.016, 0.042)
        .bead(0.002, 0.050, 2)
        .to(0.013, 0.053)
        .swelling(0.0195, 0.270, 0.001, 2)
        .ease(0.0135, 0.318, 3)
        .to(0.0185, 0.320)
        .bead(0.0035, 0.332, 2)
        .to(0.0155, 0.335)
        .ease(0.0215, 0.375, 2)
        .to(0.019, board_bottom)
        .to(0, board_bottom + 0.006);
    return lathe(profile, 12);
}

Shell back_post() {
    Profile profile = foot(0.0125);
    profile.swelling(0.0175, 0.330, 0.001, 3)
        .to(0.0205, 0.332)
        .bead(0.0025, 0.343, 2)
        .to(0.0175, 0.346)
        .swelling(0.0185, board_bottom, 0, 1)
        .to(0.0185, board_top)
        .to(0.0175, 0.500)
        .to(0.0205, 0.502)
        .bead(0.0025, 0.513, 2)
        .to(0.0175, 0.516)
        .swelling(0.0145, 0.895, 0.001, 5)
        .to(0.0115, 0.899)
        .swelling(0.0115, 0.910, -0.002, 2)
        .bead(0.0055, 0.940, 4)
        .round(0, 0.946, 2, true);
    return bent(lathe(profile, 12), [](const Vec3d& p) { return Vec3d(p.x, p.y, p.z + post_z + rake(p.y)); });
}

Shell stretcher(const Vec3d& from, const Vec3d& to, double leg_radius) {
    const double length = (to - from).length(), end = leg_radius - 0.001;
    Profile profile;
    profile.to(0, 0.004)
        .to(0.0075, 0.004)
        .to(0.0075, end)
        .swelling(0.0075, length - end, 0.0055, 6)
        .to(0.0075, length - 0.004)
        .to(0, length - 0.004);
    return aligned(lathe(profile, 8), from, to);
}

/// Makes a plate that is wider in front, with its height offset by `height_of`.
Shell seat_plate(const Board& shape, const Profile& edge,
                 const std::function<double(double x, double z)>& height_of) {
    return bent(board(shape, edge), [&](const Vec3d& p) {
        return Vec3d(p.x * (1 + 0.22 * p.z), p.y + height_of(p.x / shape.half_x, p.z / shape.half_z),
                     p.z - 0.003);
    });
}

Shell seat_board() {
    Profile edge;
    edge.to(-0.008, board_bottom)
        .round(0, board_bottom + 0.010, 2, false)
        .to(0, board_top - 0.006)
        .round(-0.006, board_top, 2, true);
    return seat_plate({0.212, 0.208, 0.036, 4, 4, 3}, edge, [](double, double) { return 0.0; });
}

Shell seat_pad() {
    Profile edge;
    edge.to(-0.012, board_top - 0.004)
        .to(-0.006, board_top)
        .round(0, board_top + 0.012, 2, false)
        .round(-0.026, board_top + 0.026, 3, true);
    return moved(seat_plate({0.192, 0.172, 0.050, 5, 5, 4}, edge,
                            [](double x, double z) {
                                const double a = std::max(0.0, 1 - x * x), b = std::max(0.0, 1 - z * z);
                                return 0.012 * a * b;
                            }),
                 {0, 0, 0.014});
}

/// Makes a rail across the back, from post to post.
Shell back_rail(double lower, double upper, double half_thickness, const std::vector<double>& heights) {
    RoundedBox shape{{-post_x, lower, -half_thickness}, {post_x, upper, half_thickness}, 0.005, 1};
    shape.lines[0] = lines_between(-post_x + 0.013, post_x - 0.013, 6);
    shape.lines[0].insert(shape.lines[0].begin(), -post_x + 0.013);
    shape.lines[0].push_back(post_x - 0.013);
    shape.lines[1] = heights;
    return rounded_box(shape);
}

Shell crest() {
    return bent(back_rail(crest_lower, crest_upper, 0.010, {0.877}), [](const Vec3d& p) {
        // higher in the middle
        const double rise =
            0.022 * (1 - p.x * p.x / (post_x * post_x)) * (p.y - crest_lower) / (crest_upper - crest_lower);
        return on_the_back({p.x, p.y + rise, p.z});
    });
}

Shell slat(double x) {
    constexpr double round = 0.003;  // begins where the slat enters the rails
    RoundedBox shape{{-0.014, rail_upper - round, -0.0045}, {0.014, crest_lower + round, 0.0045}, round, 1};
    shape.lines[1] = lines_between(rail_upper, crest_lower, 4);
    return bent(rounded_box(shape), [x](const Vec3d& p) {
        // slightly waisted
        const double t = (p.y - rail_upper) / (crest_lower - rail_upper);
        return on_the_back({x + p.x * (1 - 0.2 * std::sin(pi * std::clamp(t, 0.0, 1.0))), p.y, p.z});
    });
}

// ---- room

constexpr double half_length = 2.3, half_width = 1.9, room_height = 2.5, wall = 0.15;
constexpr double window_lower = 0.85, window_upper = 2.05, window_half = 0.7;
constexpr double frame_inside = half_length + 0.04, frame_outside = half_length + 0.10;

/// Makes two posts, with sill, head and mullion between them, each thinner than the one before. Their rounded
/// ends lie inside the wall or inside each other.
std::vector<Shell> window_frame() {
    constexpr double round = 0.005, into = 0.006, width = 0.05, slighter = 0.006, middle_half = 0.018;
    constexpr double open_half = window_half - width, open_lower = window_lower + width,
                     open_upper = window_upper - width;
    const auto bar = [](double inset, double lower_y, double upper_y, double lower_z, double upper_z) {
        return rounded_box(
            {{frame_inside + inset, lower_y, lower_z}, {frame_outside - inset, upper_y, upper_z}, round, 1});
    };
    const double lower = window_lower - into, upper = window_upper + into, half = window_half + into;
    return {bar(0, lower, upper, -half, -open_half), bar(0, lower, upper, open_half, half),
            bar(slighter, lower, open_lower, -open_half - into, open_half + into),
            bar(slighter, open_upper, upper, -open_half - into, open_half + into),
            bar(2 * slighter, open_lower - into, open_upper + into, -middle_half, middle_half)};
}

}  // namespace

Mesh table_mesh() {
    Mesh mesh;
    append(mesh, table_top(), "top");
    for (double side_x : {-1.0, 1.0})
        for (double side_z : {-1.0, 1.0}) {
            const Vec3d place(side_x * table_leg_x, 0, side_z * table_leg_z);
            append(mesh, moved(table_leg(), place), "wood");
            append(mesh, moved(table_block(side_x, side_z), place), "wood");
        }
    for (double side : {-1.0, 1.0}) {
        append(mesh, moved(apron(table_leg_x), {0, 0, side * (table_leg_z + 0.007)}), "wood");
        append(mesh, moved(bent(apron(table_leg_z), quarter_turn), {side * (table_leg_x + 0.007), 0, 0}),
               "wood");
    }
    return mesh;
}

Mesh chair_mesh() {
    Mesh mesh;
    append(mesh, seat_board(), "wood");
    const auto post_at = [](double side, double height) {
        return Vec3d(side * post_x, height, post_z + rake(height));
    };
    for (double side : {-1.0, 1.0}) {
        append(mesh, moved(front_leg(), {side * front_leg_x, 0, front_leg_z}), "wood");
        append(mesh, moved(back_post(), {side * post_x, 0, 0}), "wood");
        append(mesh, stretcher(post_at(side, 0.145), {side * front_leg_x, 0.145, front_leg_z}, 0.015),
               "wood");
    }
    append(mesh, stretcher({-front_leg_x, 0.215, front_leg_z}, {front_leg_x, 0.215, front_leg_z}, 0.018),
           "wood");
    append(mesh, stretcher(post_at(-1, 0.215), post_at(1, 0.215), 0.016), "wood");
    append(mesh, crest(), "wood");
    append(mesh, bent(back_rail(rail_lower, rail_upper, 0.009, {}), on_the_back), "wood");
    for (int i = -2; i <= 2; ++i) append(mesh, slat(0.058 * i), "wood");
    append(mesh, seat_pad(), "seat");
    const float middle = mesh_bounds(mesh).centre().z;
    for (Vec3f& p : mesh.positions) p.z -= middle;
    return mesh;
}

Mesh room_mesh() {
    // The grid has lines where the frame enters the wall.
    const Blocks walls{
        {{{-half_length - wall, -half_length, half_length, frame_inside, frame_outside, half_length + wall},
          {-wall, 0, window_lower, window_upper, room_height, room_height + wall},
          {-half_width - wall, -half_width, -window_half, window_half, half_width, half_width + wall}}},
        [](const Vec3d& p) {
            const bool in_room =
                std::abs(p.x) < half_length && std::abs(p.z) < half_width && p.y > 0 && p.y < room_height;
            const bool in_window =
                p.x > half_length && std::abs(p.z) < window_half && p.y > window_lower && p.y < window_upper;
            return !in_room && !in_window;
        }};
    const auto material_of = [](const Vec3d& p, const Vec3d& normal) -> std::string {
        if (std::abs(p.x) > half_length) return "wall";
        if (p.y == 0 && normal.y > 0) return "floor";
        if (p.y == room_height && normal.y < 0) return "ceiling";
        if (p.z == -half_width && normal.z > 0) return "left";
        if (p.z == half_width && normal.z < 0) return "right";
        return "wall";
    };
    Mesh mesh;
    for (const char* material : {"floor", "ceiling", "left", "right", "wall"})
        append(
            mesh,
            block_sides(walls, [&](const Vec3d& p, const Vec3d& n) { return material_of(p, n) == material; }),
            material);
    for (const Shell& bar : window_frame()) append(mesh, bar, "frame");
    return mesh;
}

Mesh floor_mesh() {
    Mesh mesh;
    mesh.positions = {{-3, 0, -3}, {-3, 0, 3}, {3, 0, 3}, {3, 0, -3}};
    mesh.normals.assign(4, Vec3f(0, 1, 0));
    mesh.vertex_materials.assign(4, 0);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.material_names = {"floor"};
    return mesh;
}

Mesh parquet_mesh() {
    constexpr int block = 5, half_lattice = 40;  // squares
    constexpr double half_diagonal = 0.11, half_floor = 4;
    Mesh mesh;
    mesh.material_names = {"light", "medium", "dark"};
    for (std::uint16_t material = 0; material < 3; ++material)
        for (int i = -half_lattice; i < half_lattice; ++i)
            for (int j = -half_lattice; j < half_lattice; ++j) {
                const auto place = [&](int u, int v) {
                    return Vec3d(half_diagonal * (u - v), 0, half_diagonal * (u + v));
                };
                const Vec3d middle = (place(i, j) + place(i + 1, j + 1)) * 0.5;
                if (std::abs(middle.x) > half_floor || std::abs(middle.z) > half_floor) continue;
                // Blocks along u begin where `along` is 0, those along v where it is the last.
                const int along = ((i - j) % (2 * block) + 2 * block) % (2 * block);
                const int first_i = along < block ? i - along : i,
                          first_j = along < block ? j : j - (2 * block - 1 - along);
                std::mt19937 random(static_cast<std::uint32_t>(1000 * (first_i + 500) + first_j + 500));
                if (random() % 3 != material) continue;
                const auto corner = static_cast<std::uint32_t>(mesh.positions.size());
                for (const Vec3d& p : {place(i, j), place(i, j + 1), place(i + 1, j + 1), place(i + 1, j)})
                    mesh.positions.emplace_back(p);
                mesh.triangles.push_back({corner, corner + 1, corner + 2});
                mesh.triangles.push_back({corner, corner + 2, corner + 3});
                mesh.vertex_materials.insert(mesh.vertex_materials.end(), 4, material);
            }
    mesh.normals.assign(mesh.positions.size(), Vec3f(0, 1, 0));
    return mesh;
}

}  // namespace haarfield
