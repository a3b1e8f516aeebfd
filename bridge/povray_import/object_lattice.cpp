#include "bridge/povray_import/object_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "bridge/povray_import/triangle_text.h"

namespace haarfield {
namespace {

constexpr int columns = 256;  // Of pictures with a pixel for each ray.

std::string vector(const Vec3d& v) {
    return fmt::format("<{:.12g},{:.12g},{:.12g}>", v.x, v.y, v.z);
}

std::string clip(const GridRequest& request) {
    const Vec3d half = request.size * 0.55;
    return fmt::format("clipped_by{{box{{{},{}}}}}", vector(request.centre - half),
                       vector(request.centre + half));
}

/// Adds the triangle whose ray starts at its centroid and follows its normal.
void add_triangle(const Vec3d& centre, const Vec3d& direction, TriangleText& triangles) {
    constexpr double size = 0.1;
    const Vec3d m = direction.normalized(), aside = std::abs(m.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0),
                e1 = m.cross(aside).normalized(), e2 = m.cross(e1);
    constexpr double half = 0.5, sine = 0.8660254037844386;
    triangles.add({centre + e1 * size, centre + (e2 * sine - e1 * half) * size,
                   centre - (e2 * sine + e1 * half) * size});
}

/// Returns the requests of surfaces.
std::vector<GridRequest> requests_of(std::span<const GridRequest> requests,
                                     std::span<const ObjectSurface> surfaces) {
    std::vector<GridRequest> result;
    for (const ObjectSurface& surface : surfaces)
        result.push_back(*std::ranges::lower_bound(requests, surface.object, {}, &GridRequest::object));
    return result;
}

}  // namespace

ObjectLattice::ObjectLattice(std::span<const GridRequest> requests, std::span<const ObjectSurface> surfaces,
                             bool is_original)
    : ObjectLattice(requests_of(requests, surfaces), is_original) {}

ObjectLattice::ObjectLattice(std::vector<GridRequest> requests, bool is_original)
    : requests_(std::move(requests)) {
    double spacing = 0;
    for (const GridRequest& request : requests_) {
        frames_.push_back(grid_frame(request));
        if (is_original && !request.is_cut) {
            frames_.back().scale = Vec3d(1, 1, 1);
            frames_.back().shift = Vec3d(0, 0, 0);
        }
        const Vec3d size = request.size * frames_.back().scale;
        spacing = std::max(spacing, 1.5 * std::max({size.x, size.y, size.z}) + 10);
    }
    const auto side = static_cast<std::size_t>(
        std::ceil(std::cbrt(static_cast<double>(std::max<std::size_t>(1, frames_.size())))));
    for (std::size_t i = 0; i < frames_.size(); ++i) {
        const Vec3d place(static_cast<double>(i % side), static_cast<double>(i / side % side),
                          static_cast<double>(i / side / side));
        places_.push_back((place - Vec3d(0.5 * static_cast<double>(side))) * spacing);
    }
}

SceneQuery ObjectLattice::query(int width, int height, const std::string& camera, bool ambient) const {
    SceneQuery query;
    std::vector<std::size_t> rows(frames_.empty() ? 1 : requests_.back().object + 1, 0);
    std::string text, choice;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
        rows[requests_[i].object] = i + 1;
        const GridFrame& frame = frames_[i];
        text += fmt::format("#macro HF_Place_{}() {} translate {} scale {} translate {} #end\n", i + 1,
                            requests_[i].is_cut ? clip(requests_[i]) : "", vector(-frame.centre),
                            vector(frame.scale), vector(placed(i, frame.shift)));
        choice += fmt::format("#case({0}) HF_Place_{0}() #break ", i + 1);
    }
    query.prelude = fmt::format(
        "#declare HF_RN={};\n#declare HF_RA=array[{}]{{{}}}\n{}"
        "#macro HF_Placed(HF_R) #switch(HF_R) {} #end #end\n",
        rows.size(), rows.size(), fmt::join(rows, ","), text, choice);
    query.put =
        "#if(HF_N<HF_RN) #if(HF_RA[HF_N]>0) object{HF_A[HF_N] HF_Placed(HF_RA[HF_N]) no_shadow} "
        "#end #end";
    query.in_numbers = true;
    query.width = width;
    query.height = height;
    query.suffix = fmt::format("\n#version 3.7;\nglobal_settings{{adc_bailout 0 max_trace_level 6 {}}}\n{}",
                               ambient ? "" : "ambient_light 0", camera);
    return query;
}

SceneQuery ObjectLattice::query(std::span<const ProbeRay> rays, bool ambient) const {
    TriangleText triangles;
    for (const ProbeRay& ray : rays) add_triangle(placed(ray.surface, ray.start), ray.direction, triangles);
    // Rows of the picture must be full.
    for (std::size_t i = rays.size(); i % columns != 0; ++i)
        add_triangle(placed(rays.back().surface, rays.back().start), rays.back().direction, triangles);
    return query(columns, static_cast<int>((rays.size() + columns - 1) / columns) + 1,
                 "#declare HF_Rays=" + triangles.mesh2() +
                     "}\ncamera{mesh_camera{1 0 mesh{HF_Rays}} location<0,0,0> direction<0,0,-1>}\n",
                 ambient);
}

Result<std::vector<TracedPoint>> ObjectLattice::traced(const SceneQueries& queries,
                                                       std::span<const ProbeRay> rays, double seconds,
                                                       const Progress& progress) const {
    std::vector<TracedPoint> points(rays.size());
    if (rays.empty()) return points;
    std::vector<std::vector<std::size_t>> rays_of(frames_.size());
    for (std::size_t i = 0; i < rays.size(); ++i) rays_of[rays[i].surface].push_back(i);
    std::vector<std::size_t> rows(requests_.back().object + 1, 0);
    std::string text, choice;
    for (std::size_t s = 0; s < frames_.size(); ++s) {
        if (rays_of[s].empty()) continue;
        rows[requests_[s].object] = s + 1;
        const GridFrame& frame = frames_[s];
        text += fmt::format(
            "#macro HF_Trace_{}() #local HF_B=object{{HF_A[HF_N] translate {} scale {} translate {}}}\n",
            s + 1, vector(-frame.centre), vector(frame.scale), vector(frame.shift));
        for (const std::size_t i : rays_of[s])
            text += fmt::format("HF_Ray({},{},{})\n", i, vector(rays[i].start), vector(rays[i].direction));
        text += "#end\n";
        choice += fmt::format("#case({0}) HF_Trace_{0}() #break ", s + 1);
    }
    SceneQuery query;
    query.prelude = fmt::format(
        "#fopen HF_H \"hf_points.txt\" write\n"
        "#macro HF_Ray(HF_K,HF_O,HF_D) #local HF_M=<0,0,0>; #local HF_P=trace(HF_B,HF_O,HF_D,HF_M); "
        "#write(HF_H,str(HF_K,0,0),\" \",vstr(3,HF_P,\" \",0,9),\" \",vstr(3,HF_M,\" \",0,9),\"\\n\") #end\n"
        "#declare HF_RN={};\n#declare HF_RA=array[{}]{{{}}}\n{}#macro HF_Traced(HF_R) #switch(HF_R) {} #end "
        "#end\n",
        rows.size(), rows.size(), fmt::join(rows, ","), text, choice);
    query.put = "#if(HF_N<HF_RN) #if(HF_RA[HF_N]>0) HF_Traced(HF_RA[HF_N]) #end #end";
    query.suffix = "\n#fclose HF_H\n";
    query.seconds = seconds;
    HF_TRY_DONE(queries.answer(query, progress));
    HF_TRY(const std::string lines, queries.written("hf_points.txt"));
    const char* at = lines.data();
    const char* const end = at + lines.size();
    const auto number = [&](auto& value) {
        while (at < end && (*at == ' ' || *at == '\n')) ++at;
        const auto [next, code] = std::from_chars(at, end, value);
        at = next;
        return code == std::errc();
    };
    std::size_t ray = 0;
    while (number(ray)) {
        TracedPoint traced;
        for (Vec3d* read : {&traced.point, &traced.normal})
            for (int axis = 0; axis < 3; ++axis)
                if (!number((*read)[axis])) return points;
        if (ray < points.size()) points[ray] = traced;
    }
    return points;
}

std::vector<Rgb> ObjectLattice::colours(const SceneAnswer& answer, std::size_t count) {
    return {answer.pixels.begin() + columns,
            answer.pixels.begin() + columns + static_cast<std::ptrdiff_t>(count)};
}

}  // namespace haarfield
