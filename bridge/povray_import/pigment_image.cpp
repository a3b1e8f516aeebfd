#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <span>

#include "bridge/povray_import/object_lattice.h"
#include "bridge/povray_import/surface_charts.h"
#include "bridge/povray_import/texel_camera.h"
#include "bridge/povray_import/triangle_text.h"

namespace haarfield {
namespace {

constexpr double most_texels = 3e6;
constexpr double texels_per_width = 900;   // Of the camera's picture, at the nearest point of a triangle.
constexpr double texels_per_object = 400;  // Along its longest side, without a camera.
constexpr double factor_outside = 16;      // Of texels' sizes outside the picture.
constexpr double least_cosine = 0.1;
constexpr double finest = 1e-6;  // Texels' least size relative to their object.
constexpr double screen_distance =
    0.3;  // Of rays' starts and screens from partly transparent surfaces. [cells]

/// Tests whether a point is in the picture or near its border.
bool is_in_picture(const SurveyedCamera& camera, const Vec3d& point) {
    constexpr double half = 0.65;
    const Vec3d v = point - camera.position;
    const double depth = v.dot(camera.direction) / camera.direction.length2(),
                 x = v.dot(camera.right) / camera.right.length2(), y = v.dot(camera.up) / camera.up.length2();
    return depth > 0 && std::abs(x) < half * depth && std::abs(y) < half * depth;
}

/// Returns the wanted sides of texels, by triangle.
std::vector<float> texel_sizes(const ObjectSurface& surface, const std::optional<SurveyedCamera>& camera) {
    Bounds box;
    for (const Vec3f& p : surface.positions) box.add(p);
    const Vec3f size = box.upper - box.lower;
    const auto longest = double(std::max({size.x, size.y, size.z}));
    if (!camera)
        return std::vector<float>(surface.triangles.size(), static_cast<float>(longest / texels_per_object));
    const double angle = camera->right.length() / camera->direction.length() / texels_per_width;
    std::vector<float> sizes;
    for (const auto& triangle : surface.triangles) {
        double distance = INFINITY, extent = 0, cosine = 1;
        bool is_inside = false;
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec3d p(surface.positions[triangle[c]]), next(surface.positions[triangle[(c + 1) % 3]]);
            distance = std::min(distance, (p - camera->position).length());
            extent = std::max(extent, (next - p).length());
            is_inside = is_inside || is_in_picture(*camera, p);
            const Vec3d away = (p - camera->position).normalized();
            cosine = std::min(cosine, std::abs(away.dot(Vec3d(surface.normals[triangle[c]]))));
        }
        // Surfaces appear shorter at grazing angles.
        const double slant = 1 / std::sqrt(std::max(cosine, least_cosine));
        // The picture may be inside the triangle.
        is_inside = is_inside || extent > 0.3 * distance;
        const double wanted =
            std::max(distance, 0.3 * extent) * angle * slant * (is_inside ? 1 : factor_outside);
        sizes.push_back(static_cast<float>(std::max(wanted, finest * longest)));
    }
    return sizes;
}

/// Replaces the vertices of a surface by those of its charts.
void chart(const ChartedSurface& charted, ObjectSurface& surface) {
    const ObjectSurface old = surface;
    surface.triangles = charted.triangles;
    surface.uvs = charted.uvs;
    surface.positions.clear();
    surface.normals.clear();
    surface.colours.clear();
    for (const std::uint32_t v : charted.originals) {
        surface.positions.push_back(old.positions[v]);
        surface.normals.push_back(old.normals[v]);
        surface.colours.push_back(old.colours[v]);
    }
}

/// Rows of an image.
struct RowRange {
    int first = 0, end = 0;
};

/// Returns POV-Ray's camera that renders each texel of some rows from above its surface.
///
/// chosen  indices of the charted surfaces.
/// start   distance of the rays' starts from the surface. [cells]
std::string texel_camera(const ObjectLattice& lattice, const std::vector<ObjectSurface>& surfaces,
                         const std::vector<std::size_t>& chosen, const SurfaceCharts& charts, double start,
                         const RowRange& rows) {
    TexelCamera camera(charts.width, charts.height);
    for (const std::size_t s : chosen) {
        const ObjectSurface& surface = surfaces[s];
        const auto row_of = [&](std::uint32_t v) { return (1 - double(surface.uvs[v].y)) * charts.height; };
        std::vector<std::optional<std::size_t>> added(surface.positions.size());
        const auto vertex = [&](std::uint32_t v) {
            if (!added[v]) {
                added[v] = camera.vertices();
                camera.add_vertex(
                    lattice.placed(s, lattice.frame(s).local_point(Vec3d(surface.positions[v]))),
                    double(surface.uvs[v].x), double(surface.uvs[v].y));
            }
            return *added[v];
        };
        for (const auto& [a, b, c] : surface.triangles) {
            const auto [top, bottom] = std::minmax({row_of(a), row_of(b), row_of(c)});
            if (bottom < rows.first - 1 || top > rows.end + 1) continue;
            const std::size_t first = vertex(a), second = vertex(b);
            camera.add_triangle(first, second, vertex(c));
        }
    }
    return camera.text(start);
}

/// Returns the ranges of rows that POV-Ray should render one after another: it searches a tenth of the
/// camera's triangles for each texel.
///
/// start  as in pigment_image.
std::vector<RowRange> strips(const SurfaceCharts& charts, std::size_t triangles, double start) {
    constexpr double search = 3e-10;  // For a texel and a triangle. [s]
    constexpr double least = 2;       // In which POV-Ray reads triangles and writes the whole image. [s]
    const double texels = double(charts.width) * charts.height;
    const int count =
        std::clamp(int(std::lround(std::sqrt(search / std::max(start, least) * texels * double(triangles)))),
                   1, std::min(32, charts.height));
    std::vector<RowRange> ranges;
    for (int k = 0; k < count; ++k)
        ranges.push_back({charts.height * k / count, charts.height * (k + 1) / count});
    return ranges;
}

/// Renders the texels of charted surfaces.
///
/// chosen   indices of the surfaces.
/// above    as `start` of texel_camera.
/// further  text behind the scene.
/// start    as in pigment_image.
Result<std::vector<Rgb>> texel_colours(const SceneQueries& queries, const ObjectLattice& lattice,
                                       const std::vector<ObjectSurface>& surfaces,
                                       const std::vector<std::size_t>& chosen, const SurfaceCharts& charts,
                                       double above, const std::string& further, double start,
                                       const Progress& progress) {
    std::size_t triangles = 0;
    for (const std::size_t s : chosen) triangles += surfaces[s].triangles.size();
    const std::vector<RowRange> ranges = strips(charts, triangles, start);
    constexpr std::size_t together = 4;
    std::vector<Rgb> pixels;
    for (std::size_t first = 0; first < ranges.size(); first += together) {
        if (progress.report)
            progress.report("pigments", std::size_t(ranges[first].first), std::size_t(charts.height));
        const std::span<const RowRange> some =
            std::span(ranges).subspan(first, std::min(together, ranges.size() - first));
        std::vector<SceneQuery> questions;
        for (const RowRange& rows : some) {
            SceneQuery& query = questions.emplace_back(
                lattice.query(charts.width, charts.height,
                              texel_camera(lattice, surfaces, chosen, charts, above, rows) + further));
            query.pigments = true;
            query.in_numbers = false;
            if (ranges.size() > 1)
                query.arguments = {fmt::format("+SR{}", rows.first + 1), fmt::format("+ER{}", rows.end)};
        }
        HF_TRY(const std::vector<SceneAnswer> answers, queries.answers(questions, progress));
        for (std::size_t k = 0; k < some.size(); ++k) {
            const auto begin = answers[k].pixels.begin();
            pixels.insert(pixels.end(), begin + std::ptrdiff_t(some[k].first) * charts.width,
                          begin + std::ptrdiff_t(some[k].end) * charts.width);
        }
    }
    return pixels;
}

/// Measures colours and coverage of texels. A screen behind the surfaces is white in one picture and black in
/// the other, so that light that passes does not meet another surface.
///
/// has_colour  becomes 0 where a texel is almost transparent.
Result<Done> measure_opacity(const SceneQueries& queries, const ObjectLattice& lattice,
                             const std::vector<ObjectSurface>& surfaces,
                             const std::vector<std::size_t>& chosen, const SurfaceCharts& charts,
                             Image& image, std::vector<std::uint8_t>& has_colour, double start,
                             const Progress& progress) {
    constexpr float least = 0.02f;  // Coverage of texels with a colour.
    TriangleText screen;
    for (const std::size_t s : chosen) {
        const GridFrame& frame = lattice.frame(s);
        std::vector<Vec3d> points;
        for (std::size_t v = 0; v < surfaces[s].positions.size(); ++v)
            points.push_back(
                lattice.placed(s, frame.local_point(Vec3d(surfaces[s].positions[v])) -
                                      frame.local_normal(Vec3d(surfaces[s].normals[v])) * screen_distance));
        for (const auto& [a, b, c] : surfaces[s].triangles) screen.add({points[a], points[b], points[c]});
    }
    const std::string mesh = screen.mesh2();
    std::array<std::vector<Rgb>, 2> pictures;
    for (const int white : {0, 1}) {
        HF_TRY(
            pictures[std::size_t(white)],
            texel_colours(
                queries, lattice, surfaces, chosen, charts, screen_distance,
                fmt::format("{}pigment{{rgb {}}} finish{{ambient 0 diffuse 0 emission HF_E}} no_shadow}}\n",
                            mesh, white),
                start, progress));
    }
    image.pixels = std::move(pictures[0]);
    image.coverage.assign(image.pixels.size(), 1.0f);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        if (!has_colour[i]) continue;
        const Rgb passed = pictures[1][i] - image.pixels[i];
        const float coverage = std::clamp(1 - (passed.x + passed.y + passed.z) / 3, 0.0f, 1.0f);
        image.coverage[i] = coverage;
        if (coverage < least) has_colour[i] = 0;
        for (int c = 0; c < 3; ++c)
            image.pixels[i][c] = std::max(0.0f, image.pixels[i][c] / std::max(coverage, least));
    }
    return Done{};
}

/// Fills the texels of a chart that have no colour with those of their neighbours.
///
/// covered  texels on surfaces, which keep their coverage.
void fill(const ChartRectangle& chart, const Rgb& otherwise, const std::vector<std::uint8_t>& covered,
          Image& image, std::vector<std::uint8_t>& has_colour) {
    std::vector<std::pair<int, int>> queue;
    const auto index = [&](int x, int y) {
        return std::size_t(y) * std::size_t(image.width) + std::size_t(x);
    };
    for (int y = chart.top; y < chart.top + chart.height; ++y)
        for (int x = chart.left; x < chart.left + chart.width; ++x)
            if (has_colour[index(x, y)]) queue.emplace_back(x, y);
    if (queue.empty()) {
        const int x = chart.left + chart.width / 2, y = chart.top + chart.height / 2;
        image.pixels[index(x, y)] = otherwise;
        has_colour[index(x, y)] = 1;
        queue.emplace_back(x, y);
    }
    constexpr std::array<std::pair<int, int>, 4> steps{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
    for (std::size_t next = 0; next < queue.size(); ++next)
        for (const auto& [dx, dy] : steps) {
            const auto [x, y] = queue[next];
            const int to_x = x + dx, to_y = y + dy;
            if (to_x < chart.left || to_x >= chart.left + chart.width || to_y < chart.top ||
                to_y >= chart.top + chart.height || has_colour[index(to_x, to_y)])
                continue;
            image.pixels[index(to_x, to_y)] = image.pixels[index(x, y)];
            if (!image.coverage.empty() && !covered[index(to_x, to_y)])
                image.coverage[index(to_x, to_y)] = image.coverage[index(x, y)];
            has_colour[index(to_x, to_y)] = 1;
            queue.emplace_back(to_x, to_y);
        }
}

}  // namespace

bool find_pattern(ObjectSurface& surface) {
    constexpr float visible = 0.01f;
    constexpr std::size_t per_stray = 500;  // Vertices for each one whose ray may have missed the surface.
    if (surface.colours.empty()) return false;
    Rgb usual;
    for (int c = 0; c < 3; ++c) {
        std::vector<float> values;
        for (const Rgb& colour : surface.colours) values.push_back(colour[c]);
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        usual[c] = *middle;
    }
    const auto differ = [](const Rgb& a, const Rgb& b) {
        return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)}) > visible;
    };
    struct Neighbours {
        int similar = 0, all = 0;
    };
    std::map<std::uint32_t, Neighbours> different;
    for (std::uint32_t v = 0; v < surface.colours.size(); ++v)
        if (differ(surface.colours[v], usual)) different.emplace(v, Neighbours());
    if (different.size() > surface.colours.size() / per_stray) return true;
    for (const auto& triangle : surface.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            if (const auto at = different.find(triangle[k]); at != different.end())
                for (const std::uint32_t other : {triangle[(k + 1) % 3], triangle[(k + 2) % 3]}) {
                    at->second.similar += !differ(surface.colours[other], surface.colours[triangle[k]]);
                    ++at->second.all;
                }
    std::erase_if(different, [&](const auto& vertex) {
        if (2 * vertex.second.similar > vertex.second.all) return false;
        surface.colours[vertex.first] = usual;
        return true;
    });
    return !different.empty();
}

Result<Image> pigment_image(const SceneQueries& queries, std::span<const GridRequest> requests,
                            std::vector<ObjectSurface>& surfaces, const std::vector<std::size_t>& chosen,
                            const std::optional<SurveyedCamera>& camera, bool opacity, double start,
                            const Progress& progress) {
    assert(!chosen.empty());
    std::vector<UnchartedSurface> uncharted;
    for (const std::size_t s : chosen)
        uncharted.push_back({surfaces[s].positions, surfaces[s].triangles, texel_sizes(surfaces[s], camera)});
    const SurfaceCharts charts = surface_charts(uncharted, most_texels);
    for (std::size_t k = 0; k < chosen.size(); ++k) chart(charts.surfaces[k], surfaces[chosen[k]]);
    const ObjectLattice lattice(requests, surfaces);
    Image image;
    image.width = charts.width;
    image.height = charts.height;
    std::vector<std::uint8_t> has_colour = charts.covered;
    const auto light_of = [&](Rgb numbers) {
        if (queries.gamma().exponent != 1)
            for (int c = 0; c < 3; ++c)
                numbers[c] = static_cast<float>(queries.gamma().light(double(numbers[c])));
        return numbers;
    };
    if (opacity) {
        HF_TRY_DONE(
            measure_opacity(queries, lattice, surfaces, chosen, charts, image, has_colour, start, progress));
        for (const ChartRectangle& rectangle : charts.rectangles) {
            const ObjectSurface& surface = surfaces[chosen[rectangle.surface]];
            fill(rectangle, light_of(surface.colours[surface.triangles[rectangle.triangle][0]]),
                 charts.covered, image, has_colour);
        }
        return image;
    }
    HF_TRY(image.pixels, texel_colours(queries, lattice, surfaces, chosen, charts,
                                       ObjectLattice::start_distance, "", start, progress));
    const std::vector<std::uint8_t> on_surfaces = pixels_on_surfaces(queries.gamma(), image.pixels);
    for (std::size_t i = 0; i < has_colour.size(); ++i) {
        has_colour[i] &= on_surfaces[i];
        for (int c = 0; c < 3; ++c) image.pixels[i][c] = std::max(0.0f, image.pixels[i][c]);
    }
    for (const ChartRectangle& rectangle : charts.rectangles) {
        const ObjectSurface& surface = surfaces[chosen[rectangle.surface]];
        fill(rectangle, light_of(surface.colours[surface.triangles[rectangle.triangle][0]]), charts.covered,
             image, has_colour);
    }
    return image;
}

}  // namespace haarfield
