#include "bridge/povray_import/scene_survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>

#include "fields/mesh/mesh.h"
#include "fields/model/povray_light.h"

namespace haarfield {
namespace {

constexpr int columns = 32, rows = 24;
constexpr double level = 0.02;  // Sine of the largest roll of an upright camera.

/// Reads numbers that are separated by blanks. Returns false if one is missing.
template <std::size_t count>
bool read_numbers(std::string_view text, std::array<double, count>& numbers) {
    const char* at = text.data();
    const char* const end = at + text.size();
    for (double& number : numbers) {
        while (at < end && (*at == ' ' || *at == '+')) ++at;
        const auto [next, code] = std::from_chars(at, end, number);
        if (code != std::errc()) return false;
        at = next;
    }
    return true;
}

/// Solves m x = b for a symmetric matrix with an eigenvalue near zero: returns the eigenvector of the
/// smallest eigenvalue of an n x n matrix, by Jacobi's rotations.
template <std::size_t n>
std::array<double, n> smallest_eigenvector(std::array<std::array<double, n>, n> m) {
    std::array<std::array<double, n>, n> vectors{};
    for (std::size_t i = 0; i < n; ++i) vectors[i][i] = 1;
    for (int sweep = 0; sweep < 60; ++sweep)
        for (std::size_t p = 0; p < n; ++p)
            for (std::size_t q = p + 1; q < n; ++q) {
                if (std::abs(m[p][q]) < 1e-300) continue;
                const double angle = 0.5 * std::atan2(2 * m[p][q], m[q][q] - m[p][p]), c = std::cos(angle),
                             s = std::sin(angle);
                for (std::size_t k = 0; k < n; ++k) {
                    const double a = m[k][p], b = m[k][q];
                    m[k][p] = c * a - s * b;
                    m[k][q] = s * a + c * b;
                }
                for (std::size_t k = 0; k < n; ++k) {
                    const double a = m[p][k], b = m[q][k];
                    m[p][k] = c * a - s * b;
                    m[q][k] = s * a + c * b;
                    const double v = vectors[k][p], w = vectors[k][q];
                    vectors[k][p] = c * v - s * w;
                    vectors[k][q] = s * v + c * w;
                }
            }
    std::size_t smallest = 0;
    for (std::size_t i = 1; i < n; ++i)
        if (m[i][i] < m[smallest][smallest]) smallest = i;
    std::array<double, n> vector{};
    for (std::size_t i = 0; i < n; ++i) vector[i] = vectors[i][smallest];
    return vector;
}

/// Finds the camera from pictures of spheres around it, whose colours are positions.
class CameraFinder {
public:
    CameraFinder(const SceneQueries& queries, const Progress& progress)
        : queries_(queries), progress_(progress) {}

    /// candidates  likely positions.
    Result<std::optional<SurveyedCamera>> found(const std::vector<Vec3d>& candidates,
                                                const std::vector<SurveyedObject>& objects) {
        for (const Vec3d& candidate : candidates) {
            HF_TRY(const std::optional<SurveyedCamera> camera, camera_at(candidate));
            if (camera && camera->is_perspective) return camera;
            if (camera) other_ = camera;
        }
        HF_TRY(const std::vector<Vec3d> directions, positions(Vec3d(0, 0, 0), 0));
        if (std::ranges::none_of(directions, [](const Vec3d& d) { return d.length() > 0.5; }))
            return std::optional<SurveyedCamera>();
        HF_TRY(const std::optional<SurveyedCamera> distant, orthographic(candidates, directions, objects));
        if (distant) return distant;
        Vec3d place(0, 0, 0);
        for (const double radius : {1e6, 1e3, 1.0}) {
            HF_TRY(const std::vector<Vec3d> points, positions(place, radius));
            place = meeting_point(points, directions);
        }
        HF_TRY(std::optional<SurveyedCamera> camera, camera_at(place));
        if (camera || other_) return camera ? camera : other_;
        SurveyedCamera unknown;
        unknown.position = candidates.empty() ? place : candidates.front();
        unknown.is_perspective = false;
        return std::optional(unknown);
    }

private:
    /// Renders the positions that the pixels see on a sphere; of a radius of 0, the directions on the sky.
    Result<std::vector<Vec3d>> positions(const Vec3d& centre, double radius) {
        SceneQuery query;
        query.camera = true;
        query.settings = false;
        query.is_linear = true;
        query.width = columns;
        query.height = rows;
        const bool is_sky = radius == 0;
        const double reach = is_sky ? 1 : radius;
        std::string pigment = "pigment{average pigment_map{";
        for (const auto& [axis, colour] : {std::pair("x", "<3,0,0>"), {"y", "<0,3,0>"}, {"z", "<0,0,3>"}})
            pigment += fmt::format("[1 gradient {} color_map{{[0 rgb 0][1 rgb{}]}}]", axis, colour);
        const std::string place =
            is_sky ? "" : fmt::format("translate <{:.12g},{:.12g},{:.12g}>", centre.x, centre.y, centre.z);
        pigment += fmt::format("}} translate -0.5 scale {:.12g} {}}}", 2 * margin * reach, place);
        query.suffix = "\n#version 3.7;\nglobal_settings{assumed_gamma 1}\n";
        query.suffix += is_sky ? fmt::format("sky_sphere{{{}}}", pigment)
                               : fmt::format(
                                     "sphere{{<{:.12g},{:.12g},{:.12g}>,{:.12g} hollow {} "
                                     "finish{{ambient 0 diffuse 0 emission 1}}}}",
                                     centre.x, centre.y, centre.z, radius, pigment);
        HF_TRY(const SceneAnswer answer, queries_.answer(query, progress_));
        std::vector<Vec3d> points;
        for (const Rgb& pixel : answer.pixels)
            points.push_back(centre + (Vec3d(pixel) - Vec3d(0.5)) * (2 * margin * reach));
        return points;
    }

    /// Fits a perspective camera at a place. Returns nothing if the camera is elsewhere.
    Result<std::optional<SurveyedCamera>> camera_at(const Vec3d& place) {
        constexpr double radius = 1;
        HF_TRY(const std::vector<Vec3d> points, positions(place, radius));
        std::array<std::array<double, 9>, 9> matrix{};
        std::vector<Vec3d> directions;
        for (const Vec3d& point : points) {
            const Vec3d d = (point - place) / radius;
            if (std::abs(d.length() - 1) > 1e-3) return std::optional<SurveyedCamera>();
            directions.push_back(d.normalized());
        }
        // d x (direction + x right + y up) = 0, with nine unknowns.
        for (std::size_t i = 0; i < directions.size(); ++i) {
            const Vec3d& d = directions[i];
            const std::array<double, 3> weights = pixel_weights(i);
            const std::array<std::array<double, 3>, 3> cross{
                {{0, -d.z, d.y}, {d.z, 0, -d.x}, {-d.y, d.x, 0}}};
            for (const std::array<double, 3>& row : cross) {
                std::array<double, 9> equation{};
                for (std::size_t k = 0; k < 3; ++k)
                    for (std::size_t c = 0; c < 3; ++c) equation[3 * k + c] = weights[k] * row[c];
                for (std::size_t a = 0; a < 9; ++a)
                    for (std::size_t b = 0; b < 9; ++b) matrix[a][b] += equation[a] * equation[b];
            }
        }
        const std::array<double, 9> v = smallest_eigenvector(matrix);
        SurveyedCamera camera{place, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}};
        const auto ray = [&](std::size_t i) {
            const std::array<double, 3> weights = pixel_weights(i);
            return camera.direction * weights[0] + camera.right * weights[1] + camera.up * weights[2];
        };
        if (ray(directions.size() / 2 + columns / 2).dot(directions[directions.size() / 2 + columns / 2]) <
            0) {
            camera.direction = -camera.direction;
            camera.right = -camera.right;
            camera.up = -camera.up;
        }
        double worst = 0;
        for (std::size_t i = 0; i < directions.size(); ++i)
            worst = std::max(worst, (ray(i).normalized() - directions[i]).length());
        camera.is_perspective = worst < 1e-3;
        return std::optional(camera);
    }

    /// Returns a distant camera that stands for an orthographic one. Nothing if the rays are not parallel, or
    /// if the camera is in an object that leaves too little distance.
    ///
    /// candidates  likely positions of the start of the middle ray.
    Result<std::optional<SurveyedCamera>> orthographic(const std::vector<Vec3d>& candidates,
                                                       const std::vector<Vec3d>& directions,
                                                       const std::vector<SurveyedObject>& objects) {
        Vec3d along(0, 0, 0);
        for (const Vec3d& d : directions) along += d.normalized();
        along.normalize();
        for (const Vec3d& d : directions)
            if ((d.normalized() - along).length() > parallel) return std::optional<SurveyedCamera>();
        HF_TRY(const ParallelRays rays, parallel_rays(along));
        if (!(rays.width() > 0)) return std::optional<SurveyedCamera>();
        HF_TRY(const Vec3d start, start_of(rays, candidates));
        return distant(rays, start, objects);
    }

    /// The rays of an orthographic camera.
    struct ParallelRays {
        Vec3d along{0, 0, 0};               ///< A unit vector.
        Vec3d right{0, 0, 0}, up{0, 0, 0};  ///< The sides of the picture.
        Vec3d middle{0, 0, 0};              ///< Any place on the middle ray.

        double width() const { return std::max(right.length(), up.length()); }
    };

    /// Fits parallel rays. The picture has no size if rays miss even the largest sphere.
    Result<ParallelRays> parallel_rays(const Vec3d& along) {
        // Smaller spheres give more accurate rays, until some rays miss them.
        ParallelRays fit;
        for (double radius = 1e6; radius > 1e-3; radius /= 30) {
            const Vec3d centre = fit.middle;
            HF_TRY(const std::vector<Vec3d> points, positions(centre, radius));
            if (std::ranges::any_of(points, [&](const Vec3d& point) {
                    return std::abs((point - centre).length() / radius - 1) > parallel;
                }))
                break;
            // x and y of pixels are symmetric about 0, so that each of the three vectors is a mean.
            Vec3d middle(0, 0, 0), right(0, 0, 0), up(0, 0, 0);
            double squared_x = 0, squared_y = 0;
            for (std::size_t i = 0; i < points.size(); ++i) {
                const std::array<double, 3> weights = pixel_weights(i);
                const Vec3d across = points[i] - centre - along * (points[i] - centre).dot(along);
                middle += across / double(points.size());
                right += across * weights[1];
                up += across * weights[2];
                squared_x += weights[1] * weights[1];
                squared_y += weights[2] * weights[2];
            }
            fit = {along, right / squared_x, up / squared_y, centre + middle};
        }
        return fit;
    }

    /// Returns where the middle ray starts: a candidate, or a place that is off by a fifth of its distance.
    Result<Vec3d> start_of(const ParallelRays& rays, const std::vector<Vec3d>& candidates) {
        const auto to_ray = [&](const Vec3d& from) {
            const Vec3d way = rays.middle - from;
            return way - rays.along * way.dot(rays.along);
        };
        const auto nearest = std::ranges::min_element(
            candidates, {}, [&](const Vec3d& candidate) { return to_ray(candidate).length(); });
        if (nearest != candidates.end() && to_ray(*nearest).length() < 0.1 * rays.width())
            return *nearest + to_ray(*nearest);
        // The smallest sphere that contains the start. Rays from outside meet its nearer side.
        double outside = 0.6 * std::hypot(rays.right.length(), rays.up.length()), inside = 1e6;
        for (double radius = outside; inside > 1.2 * outside; radius = std::sqrt(inside * outside)) {
            HF_TRY(const std::vector<Vec3d> points, positions(rays.middle, radius));
            const bool is_inside = (points[points.size() / 2] - rays.middle).dot(rays.along) > 0;
            (is_inside ? inside : outside) = radius;
        }
        return rays.middle - rays.along * outside;
    }

    /// Returns the distant camera. The middle of the objects is seen as large as through parallel rays.
    /// Nothing if an object around the start leaves too little distance.
    static std::optional<SurveyedCamera> distant(const ParallelRays& rays, const Vec3d& start,
                                                 const std::vector<SurveyedObject>& objects) {
        constexpr double usual_distance = 1000, least_distance = 30;  // Widths of the picture.
        const Vec3d& along = rays.along;
        const double width = rays.width();
        Bounds box;
        double room = std::numeric_limits<double>::infinity();  // Behind the start.
        for (const SurveyedObject& object : objects) {
            if (object.is_infinite() || object.is_empty()) continue;
            box.add(Vec3f(object.lower));
            box.add(Vec3f(object.upper));
            double behind = room;
            bool is_inside = true;
            for (int c = 0; c < 3; ++c) {
                is_inside = is_inside && object.lower[c] < start[c] && start[c] < object.upper[c];
                const double wall = along[c] > 0 ? object.lower[c] : object.upper[c];
                if (along[c] != 0) behind = std::min(behind, (start[c] - wall) / along[c]);
            }
            if (is_inside) room = std::min(room, behind);
        }
        const double focus = box.lower.x <= box.upper.x
                                 ? std::max(0.0, (Vec3d(box.centre()) - start).dot(along))
                                 : width,
                     distance = std::min({usual_distance * width, focus + 0.9 * room, 5e5});
        if (distance < least_distance * width) return std::nullopt;
        return SurveyedCamera{
            start + along * (focus - distance), along * distance, rays.right, rays.up, true, start};
    }

    static std::array<double, 3> pixel_weights(std::size_t pixel) {
        const auto i = static_cast<double>(pixel % columns), j = static_cast<double>(pixel / columns);
        return {1, (i + 0.5) / columns - 0.5, 0.5 - (j + 0.5) / rows};
    }

    /// Returns the point nearest to all lines through points along directions.
    static Vec3d meeting_point(const std::vector<Vec3d>& points, const std::vector<Vec3d>& directions) {
        // Three equations: sum (I - d d^T) (p - x) = 0.
        std::array<std::array<double, 4>, 3> m{};
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3d d = directions[i].normalized();
            const double distance = points[i].dot(d);
            for (int r = 0; r < 3; ++r) {
                for (int c = 0; c < 3; ++c)
                    m[std::size_t(r)][std::size_t(c)] += (r == c ? 1.0 : 0.0) - d[r] * d[c];
                m[std::size_t(r)][3] += points[i][r] - d[r] * distance;
            }
        }
        for (std::size_t k = 0; k < 3; ++k) {
            if (std::abs(m[k][k]) < 1e-12) return {0, 0, 0};
            for (std::size_t r = 0; r < 3; ++r) {
                if (r == k) continue;
                const double factor = m[r][k] / m[k][k];
                for (std::size_t c = 0; c < 4; ++c) m[r][c] -= factor * m[k][c];
            }
        }
        return {m[0][3] / m[0][0], m[1][3] / m[1][1], m[2][3] / m[2][2]};
    }

    static constexpr double parallel = 1e-3;  // The largest relative deviation of parallel rays.
    static constexpr double margin = 1.05;    // Colours at the ends of their range would wrap around.
    const SceneQueries& queries_;
    const Progress& progress_;
    std::optional<SurveyedCamera> other_;
};

}  // namespace

SceneFrame scene_frame(const std::optional<SurveyedCamera>& camera, std::optional<bool> z_up) {
    bool left_handed = true, is_z_up = z_up.value_or(false);
    if (camera && camera->is_perspective) {
        left_handed = camera->is_left_handed();
        const Vec3d right = camera->right.normalized(), up = camera->up.normalized();
        const bool is_level_y = std::abs(right.y) < level, is_level_z = std::abs(right.z) < level;
        if (!z_up) is_z_up = is_level_z && (!is_level_y || up.y < 0.05);
    }
    return {is_z_up, left_handed};
}

Result<SceneSurvey> scene_survey(const SceneQueries& queries, const Progress& progress) {
    SceneQuery query;
    query.survey = true;
    query.lights = true;
    query.camera = true;
    query.put =
        "#local HF_L=min_extent(HF_A[HF_N]); #local HF_U=max_extent(HF_A[HF_N]); "
        "#write(HF_F,\"\\nobject \",str(HF_I,0,0),\" \",vstr(3,HF_L,\" \",0,12),\" \","
        "vstr(3,HF_U,\" \",0,12))";
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    HF_TRY_DONE(queries.answer(query, progress));
    SceneSurvey survey;
    survey.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    HF_TRY(const std::string text, queries.written("hf_survey.txt"));
    std::vector<Vec3d> places;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = std::string_view(text).substr(at, end - at);
        at = end + 1;
        if (line.starts_with("object ")) {
            std::array<double, 7> n{};
            if (!read_numbers(line.substr(7), n)) continue;
            const auto statement = static_cast<std::size_t>(std::max(0.0, n[0]));
            if (statement >= queries.scene().statements.size()) continue;
            survey.objects.push_back({statement, {n[1], n[2], n[3]}, {n[4], n[5], n[6]}});
        } else if (line.starts_with("place ")) {
            std::array<double, 3> n{};
            if (read_numbers(line.substr(6), n)) places.insert(places.begin(), Vec3d(n[0], n[1], n[2]));
        } else if (line.starts_with("light ")) {
            std::size_t statement = 0;
            std::from_chars(line.data() + 6, line.data() + line.size(), statement);
            const std::size_t brace = std::min(line.find('{'), line.size());
            if (std::optional<ModelLight> light = povray_light(PovrayText(line.substr(brace))))
                survey.lights.push_back(*std::move(light));
            else
                survey.unread_lights.push_back(statement);
        }
    }
    // Without a camera, POV-Ray has one at the origin.
    if (queries.scene().has_camera) {
        HF_TRY(survey.camera, CameraFinder(queries, progress).found(places, survey.objects));
    }
    return survey;
}

}  // namespace haarfield
