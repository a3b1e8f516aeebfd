#include "bridge/povray_import/object_surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>

#include "bridge/povray_import/object_frame.h"
#include "fields/base/parallel_loop.h"

namespace haarfield {
namespace {

/// POV-Ray's text that traces the lines of a grid. HF_G holds the parameters of the objects, HF_R their rows.
constexpr const char* trace_macros = R"(
#macro HF_Again(HF_X,HF_P,HF_M,HF_V,HF_D,HF_E)
  #declare HF_X=HF_Sides(HF_P.x,HF_P.y,HF_P.z,HF_M.x,HF_M.y,HF_M.z,(vdot(HF_M,HF_D)<0 ? -0.02 : 0.02));
  #if(mod(HF_X,3)=0)
    // Polynomials count as inside where they are less than 1e-3, which can be far from the surface.
    #local HF_M2=<0,0,0>;
    #local HF_Z=trace(HF_B,HF_P+HF_D*0.001,HF_D,HF_M2);
    #if(vlength(HF_M2)<0.5) #local HF_Z=HF_P+HF_D*(HF_E-vdot(HF_P,HF_D)); #end
    #local HF_C=0.5*(HF_Z+HF_V)*0.5+HF_P*0.5; #local HF_W=0.25*(HF_Z-HF_V);
    #declare HF_X=HF_Sides(HF_C.x,HF_C.y,HF_C.z,HF_W.x,HF_W.y,HF_W.z,1);
  #end
#end
#macro HF_Line(HF_O,HF_D,HF_E,HF_L)
  #local HF_V=HF_O; #local HF_T=HF_O; #local HF_S=0;
  #for(HF_C,1,100)
    #local HF_M=<0,0,0>;
    #local HF_P=trace(HF_B,HF_T,HF_D,HF_M);
    #local HF_K=vdot(HF_P,HF_D);
    #if(vlength(HF_M)<0.5|HF_K>HF_E) #break #end
    #local HF_X=HF_Sides(HF_P.x,HF_P.y,HF_P.z,HF_M.x,HF_M.y,HF_M.z,(vdot(HF_M,HF_D)<0 ? -0.002 : 0.002));
    #if(mod(HF_X,3)=0) HF_Again(HF_X,HF_P,HF_M,HF_V,HF_D,HF_E) #end
    #write(HF_H,HF_L," ",str(HF_K,0,6)," ",vstr(3,HF_M," ",0,5)," ",str(HF_X,0,0),"\n")
    #local HF_V=HF_P; #local HF_T=HF_P+HF_D*0.001; #local HF_S=HF_S+mod(HF_X,3);
  #end
  #if(HF_S=0)
    #if(HF_FN(HF_O.x,HF_O.y,HF_O.z).red>0.5) #write(HF_H,HF_L," in\n") #end
  #end
#end
#macro HF_Axis(HF_A1,HF_D,HF_U,HF_V,HF_NU,HF_NV,HF_NE)
  #local HF_X0=-0.5; #local HF_XE=HF_NE+0.5;
  #if(HF_Rate>0)
    #local HF_X0=vdot(HF_D,HF_Shift)+HF_Size*sinh(HF_Rate*(-0.5-HF_NE/2));
    #local HF_XE=vdot(HF_D,HF_Shift)+HF_Size*sinh(HF_Rate*(0.5+HF_NE/2));
  #end
  #for(HF_J1,0,HF_NU)
    #local HF_X1=HF_J1;
    #if(HF_Rate>0) #local HF_X1=vdot(HF_U,HF_Shift)+HF_Size*sinh(HF_Rate*(HF_J1-HF_NU/2)); #end
    #for(HF_J2,0,HF_NV)
      #local HF_X2=HF_J2;
      #if(HF_Rate>0) #local HF_X2=vdot(HF_V,HF_Shift)+HF_Size*sinh(HF_Rate*(HF_J2-HF_NV/2)); #end
      HF_Line(HF_X1*HF_U+HF_X2*HF_V+HF_X0*HF_D,HF_D,HF_XE,str(HF_A1+3*(HF_J1*(HF_NV+1)+HF_J2),0,0))
    #end
  #end
#end
#macro HF_Sample(HF_R)
  #debug concat("HF_OBJECT ",str(HF_R,0,0),"\n")
  #fopen HF_H concat("hf_lines_",str(HF_R,0,0),".txt") write
  #local HF_NX=HF_G[HF_R][1]; #local HF_NY=HF_G[HF_R][2]; #local HF_NZ=HF_G[HF_R][3];
  #declare HF_Size=HF_G[HF_R][13]; #declare HF_Rate=HF_G[HF_R][14];
  #declare HF_Shift=<HF_G[HF_R][10],HF_G[HF_R][11],HF_G[HF_R][12]>;
  #local HF_B=object{HF_A[HF_N]
    translate -<HF_G[HF_R][4],HF_G[HF_R][5],HF_G[HF_R][6]>
    scale <HF_G[HF_R][7],HF_G[HF_R][8],HF_G[HF_R][9]>
    translate <HF_G[HF_R][10],HF_G[HF_R][11],HF_G[HF_R][12]>}
  #local HF_FN=function{pigment{object{HF_B color rgb 0, color rgb 1}}}
  // 2 if a point is inside behind the place, plus 1 if one is inside in front of it.
  #local HF_Sides=function(x,y,z,HF_x,HF_y,HF_z,HF_d){
    2*(HF_FN(x-HF_d*HF_x,y-HF_d*HF_y,z-HF_d*HF_z).red>0.5)+
    (HF_FN(x+HF_d*HF_x,y+HF_d*HF_y,z+HF_d*HF_z).red>0.5)}
  HF_Axis(0,x,y,z,HF_NY,HF_NZ,HF_NX)
  HF_Axis(1,y,z,x,HF_NZ,HF_NX,HF_NY)
  HF_Axis(2,z,x,y,HF_NX,HF_NY,HF_NZ)
  #write(HF_H,"end\n")
  #fclose HF_H
#end
)";

/// Reads the crossings of one object. Returns false if the file is incomplete.
bool read_lines(std::string_view text, CrossedGrid& grid) {
    for (int axis = 0; axis < 3; ++axis) {
        grid.lines[std::size_t(axis)].resize(grid.line_count(axis));
        grid.inside_lines[std::size_t(axis)].assign(grid.line_count(axis), 0);
    }
    const char* at = text.data();
    const char* const end = at + text.size();
    const auto number = [&](auto& value) {
        while (at < end && *at == ' ') ++at;
        const auto [next, code] = std::from_chars(at, end, value);
        at = next;
        return code == std::errc();
    };
    while (at < end) {
        if (*at == 'e') return true;
        std::size_t key = 0;
        if (!number(key)) return false;
        const std::size_t axis = key % 3, line = key / 3;
        if (line >= grid.lines[axis].size() || at + 3 >= end) return false;
        if (at[1] == 'i') {
            grid.inside_lines[axis][line] = 1;
            at += 4;
            continue;
        }
        LineCrossing crossing;
        int state = 0;
        if (!number(crossing.place) || !number(crossing.normal.x) || !number(crossing.normal.y) ||
            !number(crossing.normal.z) || !number(state))
            return false;
        crossing.inside_before = (state & 2) != 0;
        crossing.inside_after = (state & 1) != 0;
        if (crossing.normal.length() > 0.5f) {
            crossing.normal.normalize();
            grid.lines[axis][line].push_back(crossing);
        }
        while (at < end && *at != '\n') ++at;
        if (at < end) ++at;
    }
    return false;
}

/// Moves crossings from local coordinates to the grid's.
void move_to_grid(const GridFrame& frame, CrossedGrid& grid) {
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3, last = (axis + 2) % 3;
        const auto columns = static_cast<std::size_t>(grid.cells[std::size_t(last)] + 1);
        for (std::size_t line = 0; line < grid.lines[std::size_t(axis)].size(); ++line)
            for (LineCrossing& crossing : grid.lines[std::size_t(axis)][line]) {
                crossing.place = frame.grid_coordinate(axis, crossing.place);
                Vec3d normal(crossing.normal);
                normal[axis] *= frame.local_per_grid(axis, crossing.place);
                normal[next] *= frame.local_per_grid(next, static_cast<double>(line / columns));
                normal[last] *= frame.local_per_grid(last, static_cast<double>(line % columns));
                crossing.normal = Vec3f(normal.normalized());
            }
    }
}

/// The number of grid edges whose ends contradict their crossings, relative to that of crossings, above which
/// a surface counts as open: `clipped_by` removes parts of surfaces without closing the holes.
constexpr double open_share = 0.1;

std::size_t crossing_count(const CrossedGrid& grid) {
    std::size_t count = 0;
    for (const auto& lines : grid.lines)
        for (const std::vector<LineCrossing>& line : lines) count += line.size();
    return count;
}

/// Returns the box of all crossings, in the scene's coordinates.
Bounds crossed_box(const GridFrame& frame, const CrossedGrid& grid) {
    Bounds box;
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3, last = (axis + 2) % 3;
        const auto columns = static_cast<std::size_t>(grid.cells[std::size_t(last)] + 1);
        for (std::size_t line = 0; line < grid.lines[std::size_t(axis)].size(); ++line)
            for (const LineCrossing& crossing : grid.lines[std::size_t(axis)][line]) {
                Vec3d point;
                point[axis] = crossing.place;
                point[next] = static_cast<double>(line / columns);
                point[last] = static_cast<double>(line % columns);
                box.add(Vec3f(frame.scene_point(point)));
            }
    }
    return box;
}

/// Returns a declaration of a two-dimensional array of rows.
std::string array_text(std::string_view name, const std::vector<std::vector<double>>& rows) {
    std::string text = fmt::format("#declare {}=array[{}][{}]{{\n", name, rows.size(), rows.front().size());
    for (const std::vector<double>& row : rows) text += fmt::format("{{{:.12g}}},\n", fmt::join(row, ","));
    return text + "}\n";
}

/// Returns the declaration of HF_R: the row of each object's parameters plus 1, or 0.
std::string row_text(std::span<const std::size_t> objects) {
    const std::size_t count = objects.empty() ? 1 : objects.back() + 1;
    std::vector<std::size_t> rows(count, 0);
    for (std::size_t i = 0; i < objects.size(); ++i) rows[objects[i]] = i + 1;
    return fmt::format("#declare HF_RN={};\n#declare HF_RA=array[{}]{{{}}}\n", count, count,
                       fmt::join(rows, ","));
}

}  // namespace

double GridFrame::local_coordinate(int axis, double grid) const {
    if (warp_rate == 0) return grid;
    return shift[axis] + warp_size * std::sinh(warp_rate * (grid - 0.5 * cells[std::size_t(axis)]));
}

double GridFrame::grid_coordinate(int axis, double local) const {
    if (warp_rate == 0) return local;
    return std::asinh((local - shift[axis]) / warp_size) / warp_rate + 0.5 * cells[std::size_t(axis)];
}

double GridFrame::local_per_grid(int axis, double grid) const {
    if (warp_rate == 0) return 1;
    return warp_size * warp_rate * std::cosh(warp_rate * (grid - 0.5 * cells[std::size_t(axis)]));
}

Vec3d GridFrame::scene_point(const Vec3d& grid) const {
    const Vec3d local(local_coordinate(0, grid.x), local_coordinate(1, grid.y), local_coordinate(2, grid.z));
    return (local - shift) / scale + centre;
}

Vec3d GridFrame::scene_normal(const Vec3d& grid, const Vec3d& normal) const {
    const Vec3d local(normal.x / local_per_grid(0, grid.x), normal.y / local_per_grid(1, grid.y),
                      normal.z / local_per_grid(2, grid.z));
    return (local * scale).normalized();
}

GridFrame grid_frame(const GridRequest& request) {
    constexpr double fewest = 8;  // Cells across a thin object.
    // Surfaces often lie at even fractions of a box.
    constexpr std::array offsets{0.0137, 0.0291, 0.0219};
    const double longest = std::max({request.size.x, request.size.y, request.size.z});
    GridFrame frame;
    frame.centre = request.centre;
    if (request.is_cut) {
        constexpr double half = 60;      // Of the box, in local units.
        constexpr double nearest = 360;  // Half of the box, in cells at the centre.
        frame.cells.fill(request.cells);
        frame.scale = Vec3d(2 * half / longest);
        for (int axis = 0; axis < 3; ++axis) frame.shift[axis] = 0.1 * offsets[std::size_t(axis)];
        double low = 1e-6, high = 10;
        for (int step = 0; step < 200; ++step) {
            const double middle = 0.5 * (low + high);
            (std::sinh(0.5 * middle * request.cells) / middle < nearest ? low : high) = middle;
        }
        frame.warp_rate = low;
        frame.warp_size = half / std::sinh(0.5 * low * request.cells);
        return frame;
    }
    for (int axis = 0; axis < 3; ++axis) {
        const double size = std::max(request.size[axis], 1e-4 * longest);
        const double across = std::max(fewest, request.cells * size / longest);
        const int cells = static_cast<int>(std::ceil(across)) + 2;
        frame.cells[std::size_t(axis)] = cells;
        frame.scale[axis] = across / size;
        frame.shift[axis] = 0.5 * cells + offsets[std::size_t(axis)];
    }
    return frame;
}

std::optional<GridRequest> own_grid(const GridRequest& request, const Bounds& crossings) {
    constexpr double margin = 2;  // Cells.
    if (!(crossings.lower.x <= crossings.upper.x)) return {};
    const GridFrame frame = grid_frame(request);
    Vec3d lower, upper;
    for (int axis = 0; axis < 3; ++axis) {
        const auto grid = [&](float place) {
            const double local = (double(place) - frame.centre[axis]) * frame.scale[axis] + frame.shift[axis];
            return frame.grid_coordinate(axis, local);
        };
        lower[axis] = grid(crossings.lower[axis]);
        upper[axis] = grid(crossings.upper[axis]);
        if (!(lower[axis] >= 1 && upper[axis] <= frame.cells[std::size_t(axis)] - 1)) return {};
    }
    const Vec3d from = frame.scene_point(lower - Vec3d(margin)),
                to = frame.scene_point(upper + Vec3d(margin));
    return GridRequest{request.object, (from + to) / 2, to - from, request.cells, false};
}

std::vector<double> surface_crossings(const ObjectSurface& surface, const Vec3d& from,
                                      const Vec3d& direction) {
    std::vector<double> places;
    for (const auto& [a, b, c] : surface.triangles) {
        const Vec3d p(surface.positions[a]), u = Vec3d(surface.positions[b]) - p,
                                             v = Vec3d(surface.positions[c]) - p, across = direction.cross(v),
                                             to = from - p;
        const double determinant = u.dot(across);
        if (determinant == 0) continue;
        const Vec3d along = to.cross(u);
        const double s = to.dot(across) / determinant, t = direction.dot(along) / determinant,
                     place = v.dot(along) / determinant;
        if (s >= 0 && t >= 0 && s + t < 1 && place > 0) places.push_back(place);
    }
    return places;
}

std::optional<CrossedGrid> crossed_grid(const GridFrame& frame, const std::string& lines) {
    CrossedGrid grid;
    grid.cells = frame.cells;
    if (!read_lines(lines, grid)) return std::nullopt;
    if (frame.warp_rate > 0) move_to_grid(frame, grid);
    return grid;
}

ObjectSurface contoured_surface(const GridFrame& frame, const CrossedGrid& grid, std::size_t object) {
    const ContouredMesh mesh = dual_contour(grid);
    ObjectSurface surface;
    surface.object = object;
    for (const Vec3f& position : mesh.positions)
        surface.positions.emplace_back(frame.scene_point(Vec3d(position)));
    for (std::size_t v = 0; v < mesh.normals.size(); ++v)
        surface.normals.emplace_back(frame.scene_normal(Vec3d(mesh.positions[v]), Vec3d(mesh.normals[v])));
    surface.triangles = mesh.triangles;
    surface.sheet_triangles = mesh.sheet_triangles;
    surface.double_edges = mesh.double_edges;
    surface.missed_edges = mesh.missed_edges;
    surface.lost_edges = mesh.lost_edges;
    return surface;
}

void take_for_sheets(CrossedGrid& grid) {
    for (auto& lines : grid.lines)
        for (std::vector<LineCrossing>& line : lines)
            for (LineCrossing& crossing : line) crossing.inside_before = crossing.inside_after = false;
    grid.inside_lines = {};
}

ObjectSurface closed_or_open_surface(const GridFrame& frame, CrossedGrid grid, std::size_t object) {
    ObjectSurface surface = contoured_surface(frame, grid, object);
    if (static_cast<double>(surface.missed_edges + surface.lost_edges) <=
        open_share * static_cast<double>(crossing_count(grid)))
        return surface;
    take_for_sheets(grid);
    return contoured_surface(frame, grid, object);
}

Result<TracedLines> traced_lines(const SceneQueries& queries, std::span<const GridRequest> requests,
                                 double object_seconds, const Progress& progress) {
    TracedLines result;
    result.lines.resize(requests.size());
    if (requests.empty()) return result;
    std::vector<std::vector<double>> rows{std::vector<double>(15, 0.0)};
    std::vector<std::size_t> objects;
    for (const GridRequest& request : requests) {
        const GridFrame frame = grid_frame(request);
        rows.push_back({0, double(frame.cells[0]), double(frame.cells[1]), double(frame.cells[2]),
                        frame.centre.x, frame.centre.y, frame.centre.z, frame.scale.x, frame.scale.y,
                        frame.scale.z, frame.shift.x, frame.shift.y, frame.shift.z, frame.warp_size,
                        frame.warp_rate});
        objects.push_back(request.object);
    }
    std::vector<bool> finished(requests.size(), false);
    std::size_t first = 0;  // Row from which POV-Ray continues.
    while (first < requests.size()) {
        SceneQuery query;
        query.object_seconds = object_seconds;
        query.prelude = array_text("HF_G", rows) + row_text(objects) + trace_macros;
        query.put =
            fmt::format("#if(HF_N<HF_RN) #if(HF_RA[HF_N]>{}) HF_Sample(HF_RA[HF_N]) #end #end", first);
        HF_TRY(const SceneAnswer answer, queries.answer(query, progress));
        const std::size_t last = answer.slow_object ? *answer.slow_object : requests.size() + 1;
        if (answer.slow_object && (last == 0 || last <= first || last > requests.size()))
            return Error{queries.file().string(), "POV-Ray reported an unknown object"};
        for (std::size_t row = first + 1; row < last; ++row) finished[row - 1] = true;
        if (answer.slow_object) result.slow.push_back(objects[last - 1]);
        first = answer.slow_object ? last : requests.size();
        if (progress.report) progress.report("surfaces", std::min(last, requests.size()), requests.size());
    }
    for (std::size_t i = 0; i < requests.size(); ++i) {
        if (!finished[i]) continue;
        // A scene may reach fewer objects than it did in the survey, if it uses the clock or the time.
        if (Result<std::string> text = queries.written(fmt::format("hf_lines_{}.txt", i + 1)))
            result.lines[i] = *std::move(text);
    }
    return result;
}

Result<ObjectSurfaces> object_surfaces(const SceneQueries& queries, std::span<const GridRequest> requests,
                                       double object_seconds, const Progress& progress) {
    ObjectSurfaces result;
    HF_TRY(TracedLines traced, traced_lines(queries, requests, object_seconds, progress));
    result.slow = std::move(traced.slow);
    std::vector<ObjectSurface> surfaces(requests.size());
    result.crossings.resize(requests.size());
    const auto contour = [&](std::size_t i) {
        const GridFrame frame = grid_frame(requests[i]);
        std::optional<CrossedGrid> grid = crossed_grid(frame, traced.lines[i]);
        if (!grid) return;
        traced.lines[i] = {};
        result.crossings[i] = crossed_box(frame, *grid);
        surfaces[i] = closed_or_open_surface(frame, *std::move(grid), requests[i].object);
    };
    const Result<Done> contoured =
        parallel_loop({requests.size()}, [&] { return LoopBody(contour); }, "contours", {{}, progress.stop});
    if (!contoured) return contoured.error();
    for (ObjectSurface& surface : surfaces)
        if (!surface.triangles.empty()) result.surfaces.push_back(std::move(surface));
    return result;
}

}  // namespace haarfield
