#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <set>

#include "bridge/povray_import/object_frame.h"

namespace haarfield {
namespace {

/// A ray in the local coordinates of an object.
struct ProbeRay {
    std::size_t surface = 0;  ///< Index of its surface.
    Vec3d start{0, 0, 0}, direction{0, 0, 1};
};

/// Objects side by side, each scaled to its grid, so that a ray meets only its own object.
class ObjectLattice {
public:
    ObjectLattice(std::span<const GridRequest> requests, std::span<const ObjectSurface> surfaces) {
        double spacing = 0;
        for (const ObjectSurface& surface : surfaces) {
            const auto request = std::ranges::lower_bound(requests, surface.object, {}, &GridRequest::object);
            requests_.push_back(*request);
            frames_.push_back(grid_frame(*request));
            const Vec3d size = request->size * frames_.back().scale;
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

    const GridFrame& frame(std::size_t surface) const { return frames_[surface]; }

    /// Returns a query that renders a colour for each ray.
    SceneQuery query(std::span<const ProbeRay> rays) const {
        SceneQuery query;
        std::vector<std::size_t> rows(frames_.empty() ? 1 : requests_.back().object + 1, 0);
        std::string text;
        for (std::size_t i = 0; i < frames_.size(); ++i) {
            rows[requests_[i].object] = i + 1;
            const GridFrame& frame = frames_[i];
            const Vec3d shift = frame.shift + places_[i];
            text += fmt::format("#macro HF_Place_{}() {} translate {} scale {} translate {} #end\n", i + 1,
                                requests_[i].is_cut ? clip(requests_[i]) : "", vector(-frame.centre),
                                vector(frame.scale), vector(shift));
        }
        query.prelude = fmt::format("#declare HF_RN={};\n#declare HF_RA=array[{}]{{{}}}\n{}", rows.size(),
                                    rows.size(), fmt::join(rows, ","), text);
        std::string choice;
        for (std::size_t i = 0; i < frames_.size(); ++i)
            choice += fmt::format("#case({0}) HF_Place_{0}() #break ", i + 1);
        query.prelude += fmt::format("#macro HF_Placed(HF_R) #switch(HF_R) {} #end #end\n", choice);
        query.put =
            "#if(HF_N<HF_RN) #if(HF_RA[HF_N]>0) object{HF_A[HF_N] HF_Placed(HF_RA[HF_N]) no_shadow} "
            "#end #end";
        query.width = columns;
        query.height = static_cast<int>((rays.size() + columns - 1) / columns) + 1;
        query.suffix =
            "\n#version 3.7;\nglobal_settings{adc_bailout 0 max_trace_level 6 ambient_light 0}\n"
            "camera{mesh_camera{1 0 mesh{\n";
        for (const ProbeRay& ray : rays) add_triangle(ray, query.suffix);
        // Rows of the picture must be full.
        for (std::size_t i = rays.size(); i % columns != 0; ++i) add_triangle(rays.back(), query.suffix);
        query.suffix += "}} location<0,0,0> direction<0,0,-1>}\n";
        return query;
    }

    /// Returns the colours of the rays. POV-Ray's first row repeats the second.
    static std::vector<Rgb> colours(const SceneAnswer& answer, std::size_t count) {
        return {answer.pixels.begin() + columns,
                answer.pixels.begin() + columns + static_cast<std::ptrdiff_t>(count)};
    }

private:
    static constexpr int columns = 256;

    static std::string vector(const Vec3d& v) {
        return fmt::format("<{:.12g},{:.12g},{:.12g}>", v.x, v.y, v.z);
    }

    static std::string clip(const GridRequest& request) {
        const Vec3d half = request.size * 0.55;
        return fmt::format("clipped_by{{box{{{},{}}}}}", vector(request.centre - half),
                           vector(request.centre + half));
    }

    /// Adds the triangle whose ray starts at its centroid and follows its normal.
    void add_triangle(const ProbeRay& ray, std::string& text) const {
        constexpr double size = 0.1;
        const Vec3d m = ray.direction.normalized(),
                    aside = std::abs(m.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0),
                    e1 = m.cross(aside).normalized(), e2 = m.cross(e1),
                    centre = ray.start + places_[ray.surface];
        constexpr double half = 0.5, sine = 0.8660254037844386;
        const auto corner = [&](const Vec3d& offset) {
            const Vec3d p = centre + offset * size;
            return fmt::format("<{:.8g},{:.8g},{:.8g}>", p.x, p.y, p.z);
        };
        text += fmt::format("triangle{{{},{},{}}}\n", corner(e1), corner(e2 * sine - e1 * half),
                            corner(-e2 * sine - e1 * half));
    }

    std::vector<GridRequest> requests_;
    std::vector<GridFrame> frames_;
    std::vector<Vec3d> places_;
};

constexpr double start_distance = 0.1;  // Of rays from the surface. [cells]

/// Returns points near the vertices, in local coordinates. Vertices on sharp edges are moved into their face,
/// where a ray cannot miss the surface.
std::vector<Vec3d> points_in_faces(const GridFrame& frame, const ObjectSurface& surface) {
    constexpr double inwards = 0.15;  // Of the way to the middle of the triangles around.
    std::vector<Vec3d> points, sums(surface.positions.size(), Vec3d(0, 0, 0));
    std::vector<double> counts(surface.positions.size(), 0);
    for (const Vec3f& position : surface.positions) points.push_back(frame.local_point(Vec3d(position)));
    for (const auto& triangle : surface.triangles) {
        const Vec3d middle = (points[triangle[0]] + points[triangle[1]] + points[triangle[2]]) / 3;
        for (const std::uint32_t corner : triangle) {
            sums[corner] += middle;
            counts[corner] += 1;
        }
    }
    for (std::size_t v = 0; v < points.size(); ++v)
        if (counts[v] > 0) points[v] += (sums[v] / counts[v] - points[v]) * inwards;
    return points;
}

ProbeRay inward_ray(const ObjectLattice& lattice, const ObjectSurface& surface, std::size_t index,
                    std::size_t vertex, const Vec3d& point) {
    const Vec3d normal = lattice.frame(index).local_normal(Vec3d(surface.normals[vertex]));
    return {index, point + normal * start_distance, -normal};
}

/// Returns up to `most` vertices, evenly spaced.
std::vector<std::size_t> some_vertices(const ObjectSurface& surface, std::size_t most) {
    const std::size_t count = surface.positions.size(), step = std::max<std::size_t>(1, count / most);
    std::vector<std::size_t> vertices;
    for (std::size_t v = step / 2; v < count && vertices.size() < most; v += step) vertices.push_back(v);
    return vertices;
}

double mean_of(const Rgb& colour) {
    return double(colour.x + colour.y + colour.z) / 3;
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// One measurement of a finish.
struct Sighting {
    std::size_t surface;
    int light;        ///< 0 or 1.
    double cosine;    ///< Between normal and light.
    double mirror;    ///< Cosine between the view and the mirrored light.
    double half;      ///< Cosine between the normal and the half vector.
    bool is_diffuse;  ///< Far from the mirror direction.
};

/// A straight line through the logarithms: value = weight * cosine^exponent.
struct PowerFit {
    double weight = 0, exponent = 0, residual = INFINITY;
};

PowerFit power_fit(const std::vector<std::array<double, 2>>& cosine_and_value) {
    double largest = 0;
    for (const auto& [cosine, value] : cosine_and_value) largest = std::max(largest, value);
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
    for (const auto& [cosine, value] : cosine_and_value) {
        if (!(value > 0.03 * largest) || !(cosine > 0)) continue;
        const double x = std::log(cosine), y = std::log(value), w = value / largest;
        n += w, sx += w * x, sy += w * y, sxx += w * x * x, sxy += w * x * y, syy += w * y * y;
    }
    PowerFit fit;
    const double spread = n * sxx - sx * sx;
    if (n < 1 || spread <= 1e-14) return fit;
    fit.exponent = (n * sxy - sx * sy) / spread;
    const double level = (sy - fit.exponent * sx) / n;
    fit.weight = std::exp(level);
    fit.residual = syy + n * level * level + fit.exponent * fit.exponent * sxx - 2 * level * sy -
                   2 * fit.exponent * sxy + 2 * level * fit.exponent * sx;
    return fit;
}

/// Measures the pigments of the vertices from an index by surface.
Result<Done> measure_pigments(const SceneQueries& queries, const ObjectLattice& lattice,
                              std::vector<ObjectSurface>& surfaces, const std::vector<std::size_t>& first,
                              const Progress& progress) {
    constexpr std::size_t most_rays = 400000;
    std::vector<ProbeRay> rays;
    std::vector<Rgb*> targets;
    const auto measure = [&]() -> Result<Done> {
        if (rays.empty()) return Done{};
        SceneQuery query = lattice.query(rays);
        query.pigments = true;
        HF_TRY(const SceneAnswer answer, queries.answer(query, progress));
        const std::vector<Rgb> colours = ObjectLattice::colours(answer, rays.size());
        for (std::size_t i = 0; i < rays.size(); ++i) *targets[i] = colours[i];
        rays.clear();
        targets.clear();
        return Done{};
    };
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        if (first[s] == surfaces[s].positions.size()) continue;
        surfaces[s].colours.resize(surfaces[s].positions.size(), Rgb(0.5f));
        const std::vector<Vec3d> points = points_in_faces(lattice.frame(s), surfaces[s]);
        for (std::size_t v = first[s]; v < surfaces[s].positions.size(); ++v) {
            rays.push_back(inward_ray(lattice, surfaces[s], s, v, points[v]));
            targets.push_back(&surfaces[s].colours[v]);
            if (rays.size() == most_rays) HF_TRY_DONE(measure());
        }
    }
    return measure();
}

/// Tests whether a point is in the picture or near its border.
bool is_in_picture(const SurveyedCamera& camera, const Vec3d& point) {
    constexpr double half = 0.65;
    const Vec3d v = point - camera.position;
    const double depth = v.dot(camera.direction) / camera.direction.length2(),
                 x = v.dot(camera.right) / camera.right.length2(), y = v.dot(camera.up) / camera.up.length2();
    return depth > 0 && std::abs(x) < half * depth && std::abs(y) < half * depth;
}

/// Divides the triangles of a surface at the middles of edges whose ends differ.
void divide_edges(ObjectSurface& surface, const std::optional<SurveyedCamera>& camera, double smallest) {
    constexpr float least_difference = 0.08f;
    // On surfaces with several colours, long edges may hide others between their ends.
    constexpr double longest = 8;
    Rgb least(1e9f), most(-1e9f);
    for (const Rgb& colour : surface.colours)
        for (int c = 0; c < 3; ++c) {
            least[c] = std::min(least[c], colour[c]);
            most[c] = std::max(most[c], colour[c]);
        }
    const auto differ = [](const Rgb& one, const Rgb& other) {
        return std::max({std::abs(one.x - other.x), std::abs(one.y - other.y), std::abs(one.z - other.z)}) >=
               least_difference;
    };
    const bool is_coloured = differ(least, most);
    if (!is_coloured) return;
    const auto is_divided = [&](std::uint32_t a, std::uint32_t b) {
        if (!camera) return differ(surface.colours[a], surface.colours[b]);
        const Vec3f p = surface.positions[a], q = surface.positions[b];
        const Vec3d centre((p + q) * 0.5f);
        if (!is_in_picture(*camera, centre)) return false;
        const double apparent = double((p - q).length()) / (centre - camera->position).length();
        return apparent > (differ(surface.colours[a], surface.colours[b]) ? 1 : longest) * smallest;
    };
    // Both sides of a sharp edge are divided, or none. Otherwise the mesh would be open there.
    std::map<std::array<float, 3>, std::uint32_t> places;
    std::vector<std::uint32_t> place_of;
    for (const Vec3f& p : surface.positions)
        place_of.push_back(
            places.emplace(std::array{p.x, p.y, p.z}, static_cast<std::uint32_t>(places.size()))
                .first->second);
    const auto between = [&](std::uint32_t a, std::uint32_t b) {
        return std::minmax({place_of[a], place_of[b]});
    };
    std::set<std::pair<std::uint32_t, std::uint32_t>> wanted;
    for (const auto& triangle : surface.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            if (is_divided(triangle[k], triangle[(k + 1) % 3]))
                wanted.insert(between(triangle[k], triangle[(k + 1) % 3]));
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) -> std::optional<std::uint32_t> {
        const std::pair key(std::min(a, b), std::max(a, b));
        if (const auto found = middles.find(key); found != middles.end()) return found->second;
        if (!wanted.contains(between(a, b))) return std::nullopt;
        const Vec3f normal = surface.normals[a] + surface.normals[b];
        const auto vertex = static_cast<std::uint32_t>(surface.positions.size());
        surface.positions.push_back((surface.positions[a] + surface.positions[b]) * 0.5f);
        surface.normals.push_back(normal.length() > 0.01f ? normal.normalized() : surface.normals[a]);
        middles.emplace(key, vertex);
        return vertex;
    };
    std::vector<std::array<std::uint32_t, 3>> divided;
    for (const auto& triangle : surface.triangles) {
        std::array<std::optional<std::uint32_t>, 3> cut;
        for (std::size_t k = 0; k < 3; ++k) cut[k] = middle(triangle[k], triangle[(k + 1) % 3]);
        const auto count = std::ranges::count_if(cut, [](const auto& each) { return each.has_value(); });
        if (count == 0) {
            divided.push_back(triangle);
            continue;
        }
        // Rotated so that edge 0 is cut, and edge 2 is not, unless all are.
        std::size_t k = 0;
        while (!(cut[k] && (count == 3 || !cut[(k + 2) % 3]))) ++k;
        const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3], c = triangle[(k + 2) % 3],
                            ab = *cut[k];
        if (count == 1) {
            divided.insert(divided.end(), {{a, ab, c}, {ab, b, c}});
        } else {
            const std::uint32_t bc = *cut[(k + 1) % 3];
            if (count == 2) {
                divided.insert(divided.end(), {{ab, b, bc}, {a, ab, bc}, {a, bc, c}});
            } else {
                const std::uint32_t ca = *cut[(k + 2) % 3];
                divided.insert(divided.end(), {{a, ab, ca}, {ab, b, bc}, {bc, c, ca}, {ab, bc, ca}});
            }
        }
    }
    surface.triangles = std::move(divided);
}

const std::array<Vec3d, 2>& light_directions() {
    static const std::array<Vec3d, 2> directions{Vec3d(0.5, 0.62, -0.605).normalized(),
                                                 -Vec3d(0.5, 0.62, -0.605).normalized()};
    return directions;
}

}  // namespace

Result<Done> add_pigments(const SceneQueries& queries, std::span<const GridRequest> requests,
                          std::vector<ObjectSurface>& surfaces, const Progress& progress) {
    if (surfaces.empty()) return Done{};
    const ObjectLattice lattice(requests, surfaces);
    HF_TRY_DONE(
        measure_pigments(queries, lattice, surfaces, std::vector<std::size_t>(surfaces.size(), 0), progress));
    std::vector<ProbeRay> rays;

    // Again before a white background, which is visible through transparent surfaces.
    std::vector<std::pair<std::size_t, std::size_t>> chosen;
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        const std::vector<Vec3d> points = points_in_faces(lattice.frame(s), surfaces[s]);
        for (const std::size_t v : some_vertices(surfaces[s], 24)) {
            chosen.emplace_back(s, v);
            rays.push_back(inward_ray(lattice, surfaces[s], s, v, points[v]));
        }
    }
    SceneQuery query = lattice.query(rays);
    query.pigments = true;
    query.suffix += "background{rgb 1}\n";
    HF_TRY(const SceneAnswer answer, queries.answer(query, progress));
    const std::vector<Rgb> bright = ObjectLattice::colours(answer, rays.size());
    std::vector<double> sums(surfaces.size(), 0), counts(surfaces.size(), 0);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const auto& [s, v] = chosen[i];
        sums[s] += std::max(0.0, mean_of(bright[i] - surfaces[s].colours[v]));
        counts[s] += 1;
    }
    for (std::size_t s = 0; s < surfaces.size(); ++s)
        surfaces[s].transmittance = static_cast<float>(sums[s] / std::max(1.0, counts[s]));
    return Done{};
}

Result<Done> refine_pigments(const SceneQueries& queries, std::span<const GridRequest> requests,
                             std::vector<ObjectSurface>& surfaces,
                             const std::optional<SurveyedCamera>& camera, double smallest, int levels,
                             const Progress& progress) {
    constexpr std::size_t most_vertices = 150000;
    const ObjectLattice lattice(requests, surfaces);
    for (int level = 0; level < levels; ++level) {
        std::vector<std::size_t> first;
        std::size_t before = 0, after = 0;
        for (const ObjectSurface& surface : surfaces) {
            first.push_back(surface.positions.size());
            before += surface.positions.size();
        }
        if (before >= most_vertices) break;
        for (ObjectSurface& surface : surfaces) {
            divide_edges(surface, camera, smallest);
            after += surface.positions.size();
        }
        if (after == before) break;
        HF_TRY_DONE(measure_pigments(queries, lattice, surfaces, first, progress));
    }
    return Done{};
}

Result<std::vector<MeasuredFinish>> measured_finishes(const SceneQueries& queries,
                                                      std::span<const GridRequest> requests,
                                                      std::span<const ObjectSurface> surfaces,
                                                      const Progress& progress) {
    std::vector<MeasuredFinish> finishes(surfaces.size());
    if (surfaces.empty()) return finishes;
    constexpr float brightness = 0.4f;  // Of the lights; sums above 1 would be cut off.
    const ObjectLattice lattice(requests, surfaces);
    std::vector<ProbeRay> rays;
    std::vector<Sighting> sightings;
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        std::array<int, 2> chosen{0, 0};
        const std::vector<Vec3d> points = points_in_faces(lattice.frame(s), surfaces[s]);
        for (const std::size_t v : some_vertices(surfaces[s], 400)) {
            const GridFrame& frame = lattice.frame(s);
            const Vec3d normal = frame.local_normal(Vec3d(surfaces[s].normals[v])), place = points[v];
            for (int light = 0; light < 2; ++light) {
                const Vec3d& towards = light_directions()[std::size_t(light)];
                const double cosine = normal.dot(towards);
                if (cosine < 0.35 || cosine > 0.97 || chosen[std::size_t(light)] >= 8) continue;
                ++chosen[std::size_t(light)];
                const Vec3d mirror = normal * (2 * cosine) - towards;
                const Vec3d aside = (normal - mirror * normal.dot(mirror)).normalized();
                for (const double degrees : {0.0, 1.5, 3.0, 5.0, 8.0, 12.0, 18.0, 26.0, 75.0}) {
                    const double angle = degrees * pi / 180;
                    const Vec3d view = mirror * std::cos(angle) + aside * std::sin(angle);
                    rays.push_back(
                        {s, place + view * (start_distance / std::max(0.2, view.dot(normal))), -view});
                    const Vec3d half = (view + towards).normalized();
                    sightings.push_back({s, light, cosine, std::cos(angle), normal.dot(half), degrees > 60});
                }
            }
        }
    }
    if (rays.empty()) return finishes;
    // The pigments that these rays see: fine patterns differ between neighbouring points.
    SceneQuery unlit = lattice.query(rays);
    unlit.pigments = true;
    HF_TRY(const SceneAnswer unlit_answer, queries.answer(unlit, progress));
    const std::vector<Rgb> pigments = ObjectLattice::colours(unlit_answer, rays.size());
    // Two permutations of the colours of both lights and the sky, so that saturated pigments reflect one.
    constexpr std::array<std::array<int, 3>, 2> permutations{{{0, 1, 2}, {2, 0, 1}}};
    std::array<std::vector<Rgb>, 2> colours;
    for (std::size_t k = 0; k < 2; ++k) {
        SceneQuery query = lattice.query(rays);
        const auto colour = [&](int channel, float value) {
            Rgb rgb(0.0f);
            rgb[channel] = value;
            return fmt::format("rgb<{},{},{}>", rgb.x, rgb.y, rgb.z);
        };
        query.suffix += fmt::format("background{{{}}}\n", colour(permutations[k][2], 1));
        for (std::size_t light = 0; light < 2; ++light) {
            const Vec3d place = light_directions()[light] * 1e5;
            query.suffix += fmt::format("light_source{{<{},{},{}> {} parallel point_at 0}}\n", place.x,
                                        place.y, place.z, colour(permutations[k][light], brightness));
        }
        HF_TRY(const SceneAnswer answer, queries.answer(query, progress));
        colours[k] = ObjectLattice::colours(answer, rays.size());
    }
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        std::vector<double> diffuse, emission, reflection;
        std::vector<std::array<double, 2>> phong, specular;
        double base = 0;
        for (std::size_t i = sightings.size(); i-- > 0;) {
            const Sighting& sighting = sightings[i];
            if (sighting.surface != s) continue;
            const Rgb& pigment = pigments[i];
            // The permutation in which the pigment is brighter in the light's channel.
            const auto light = std::size_t(sighting.light);
            const std::size_t k = pigment[permutations[0][light]] >= pigment[permutations[1][light]] ? 0 : 1;
            const int channel = permutations[k][light], other = permutations[k][1 - light];
            const double value = double(colours[k][i][channel]) / double(brightness);
            if (sighting.is_diffuse) {
                base = value;
                if (pigment[channel] > 0.02f)
                    diffuse.push_back(value / (double(pigment[channel]) * sighting.cosine));
                if (pigment[other] > 0.02f) emission.push_back(double(colours[k][i][other] / pigment[other]));
                reflection.push_back(double(colours[k][i][permutations[k][2]]));
            } else {
                phong.push_back({sighting.mirror, value - base});
                specular.push_back({sighting.half, value - base});
            }
        }
        MeasuredFinish& finish = finishes[s];
        finish.emission = static_cast<float>(median(emission));
        if (finish.emission < 0.004f) finish.emission = 0;
        finish.diffuse = static_cast<float>(
            std::clamp(median(diffuse) - double(finish.emission) / double(brightness), 0.0, 1.0));
        finish.reflection = static_cast<float>(std::max(0.0, median(reflection)));
        std::vector<double> peaks;
        for (const auto& [cosine, value] : phong)
            if (cosine > 0.99999) peaks.push_back(value);
        if (median(peaks) < 0.005) continue;
        const PowerFit about_mirror = power_fit(phong), about_half = power_fit(specular);
        if (about_mirror.residual <= about_half.residual) {
            finish.phong = static_cast<float>(std::clamp(about_mirror.weight, 0.0, 100.0));
            finish.phong_size = static_cast<float>(std::clamp(about_mirror.exponent, 1.0, 1000.0));
        } else {
            finish.specular = static_cast<float>(std::clamp(about_half.weight, 0.0, 100.0));
            finish.roughness =
                static_cast<float>(std::clamp(1 / std::max(about_half.exponent, 1e-3), 0.0005, 1.0));
        }
    }
    return finishes;
}

}  // namespace haarfield
