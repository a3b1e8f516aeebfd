#include "bridge/povray_import/imported_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <numeric>
#include <tuple>

#include "bridge/povray_import/bend_refinement.h"
#include "bridge/povray_import/light_probe.h"
#include "bridge/povray_import/object_filters.h"
#include "bridge/povray_import/object_silhouettes.h"
#include "fields/base/names.h"
#include "fields/base/srgb.h"
#include "fields/file/write_file.h"
#include "scenes/image.h"
#include "scenes/scene_import.h"
#include "shading/scene/shaded_scene.h"

namespace haarfield {
namespace {

constexpr double far_factor = 10;  // Objects this much farther than all nearer ones are distant.
constexpr double cut_factor = 30;  // Where infinite objects are cut, relative to the farthest near object.
constexpr std::size_t most_objects = 3000;
constexpr std::size_t many = 8;                // Objects of one statement that become one entity.
constexpr float mostly_transparent = 0.5f;     // Of one surface, in one channel.
constexpr float slightly_transparent = 0.05f;  // Of an object.
constexpr int environment_width = 1024;
constexpr std::size_t most_wrong_pixels = 8;  // Of an object's silhouettes.
constexpr int finer_grids = 2;                // How often the grids of objects with narrow parts are doubled.

/// Writes a binary PLY with normals, and linear colours or image coordinates.
Result<Done> write_surface_ply(const std::filesystem::path& file, const ObjectSurface& surface) {
    const bool has_image = !surface.uvs.empty();
    std::string bytes = fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n{}element face {}\n"
        "property list uchar int vertex_indices\nend_header\n",
        surface.positions.size(),
        has_image ? "property float s\nproperty float t\n"
                  : "property float red\nproperty float green\nproperty float blue\n",
        surface.triangles.size());
    const auto add = [&](const auto& value) {
        char raw[sizeof value];
        std::memcpy(raw, &value, sizeof value);
        bytes.append(raw, sizeof value);
    };
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
        for (const Vec3f& vector : {surface.positions[v], surface.normals[v]})
            for (int c = 0; c < 3; ++c) add(vector[c]);
        if (has_image)
            for (int c = 0; c < 2; ++c) add(surface.uvs[v][c]);
        else
            for (int c = 0; c < 3; ++c) add(surface.colours[v][c]);
    }
    for (const auto& triangle : surface.triangles) {
        bytes += '\x03';
        for (const std::uint32_t corner : triangle) add(static_cast<std::int32_t>(corner));
    }
    return write_file(file, bytes);
}

/// Writes colours with coverage as straight alpha.
Result<Done> write_cut_outs(const Image& image, const std::filesystem::path& file) {
    std::vector<std::array<std::uint8_t, 4>> texels;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const Rgb& pixel = image.pixels[i];
        texels.push_back({unit_byte(srgb_encoded(pixel.x)), unit_byte(srgb_encoded(pixel.y)),
                          unit_byte(srgb_encoded(pixel.z)), unit_byte(image.coverage[i])});
    }
    HF_TRY(const std::string bytes, png_bytes(texels, image.width, image.height, /*with_alpha=*/true));
    return write_file(file, bytes);
}

/// Lets a query place some of the scene's objects as they are.
///
/// objects  sorted.
void place_objects(std::span<const std::size_t> objects, SceneQuery& query) {
    std::vector<int> rows(objects.empty() ? 1 : objects.back() + 1, 0);
    for (const std::size_t object : objects) rows[object] = 1;
    query.prelude = fmt::format("#declare HF_RN={};\n#declare HF_RA=array[{}]{{{}}}\n", rows.size(),
                                rows.size(), fmt::join(rows, ","));
    query.put = "#if(HF_N<HF_RN) #if(HF_RA[HF_N]>0) object{HF_A[HF_N]} #end #end";
}

/// Renders distant objects and the sky; see rendered_light.
Result<Image> surrounding_light(const SceneQueries& queries, const Vec3d& from, const AffineMap& frame,
                                const std::vector<std::size_t>& objects, bool is_legacy,
                                const Progress& progress) {
    SceneQuery query;
    query.lights = query.sky = true;
    place_objects(objects, query);
    return rendered_light(queries, query, from, frame, environment_width, is_legacy, progress);
}

/// Imports one scene.
class Importer {
public:
    Importer(const SceneQueries& queries, std::filesystem::path folder, std::string name,
             const PovrayImport& options, const Progress& progress)
        : queries_(queries),
          folder_(std::move(folder)),
          name_(std::move(name)),
          options_(options),
          progress_(progress),
          gamma_(queries.gamma()) {}

    Result<ImportedPovrayScene> imported() {
        HF_TRY(survey_, scene_survey(queries_, progress_));
        result_.objects = survey_.objects.size();
        result_.scene.assumed_gamma = static_cast<float>(gamma_.exponent);
        choose_objects();
        std::vector<ObjectSurface> surfaces;
        if (!requests_.empty()) {
            HF_TRY(ObjectSurfaces sampled,
                   object_surfaces(queries_, requests_, options_.object_seconds, progress_));
            HF_TRY_DONE(sample_bounded(sampled));
            surfaces = std::move(sampled.surfaces);
            HF_TRY_DONE(sample_again(surfaces));
            for (const std::size_t slow : sampled.slow)
                warn(survey_.objects[slow].statement,
                     fmt::format("took POV-Ray more than {} s of processor time; left out",
                                 options_.object_seconds));
        }
        if (surfaces.empty())
            return Error{queries_.file().string(),
                         "none of its objects has a surface near the camera; expected objects"};
        result_.failed = requests_.size() - surfaces.size();
        // Infinite objects without a surface nearby, such as skies.
        for (const GridRequest& request : requests_)
            if (request.is_cut &&
                std::ranges::find(surfaces, request.object, &ObjectSurface::object) == surfaces.end()) {
                --result_.failed;
                result_.distant_objects.push_back(request.object);
                ++result_.distant;
            }
        // Surfaces remain as they are if POV-Ray takes too long.
        (void)refine_bends(queries_, requests_, surfaces, options_.object_seconds, progress_);
        if (progress_.stop.stop_requested()) return interruption();
        HF_TRY_DONE(add_pigments(queries_, requests_, surfaces, progress_));
        HF_TRY(std::vector<MeasuredFinish> finishes,
               measured_finishes(queries_, requests_, surfaces, is_lit_by_lights(), progress_));
        HF_TRY_DONE(add_pigment_images(surfaces, finishes));
        set_frame(surfaces);
        HF_TRY_DONE(add_entities(surfaces, finishes));
        if (result_.scene.entities.empty())
            return Error{queries_.file().string(),
                         "all its objects are transparent; expected opaque objects"};
        HF_TRY_DONE(write_live());
        share_vertices();
        add_lights();
        set_camera();
        if (options_.with_environment) HF_TRY_DONE(add_environment());
        if (is_lit_by_lights()) result_.scene.bounces = 0;
        name_unused();
        return std::move(result_);
    }

private:
    static bool is_bright(const Rgb& colour) { return std::max({colour.x, colour.y, colour.z}) > 0; }

    /// True if only the file's lights illuminate surfaces, as in POV-Ray without radiosity. Otherwise the sky
    /// and other surfaces do, too.
    bool is_lit_by_lights() const {
        const bool has_radiosity =
            std::ranges::find(queries_.scene().unused, "radiosity", &UnusedStatement::keyword) !=
            queries_.scene().unused.end();
        return !has_radiosity && options_.with_environment && options_.queries.wrap.object.empty() &&
               std::ranges::any_of(survey_.lights, &is_bright, &ModelLight::colour);
    }

    const SceneStatement& statement(std::size_t index) const { return queries_.scene().statements[index]; }

    /// Samples objects again that POV-Ray takes for infinite although their surface is small, such as clipped
    /// quadrics: in grids of their own size.
    Result<Done> sample_bounded(ObjectSurfaces& sampled) {
        constexpr int rounds = 2;  // The margins of an object's first own grid are still two large cells.
        std::vector<GridRequest> own, missed;
        const auto add_own = [&](const GridRequest& request, const Bounds& crossings) {
            if (const auto grid = own_grid(request, crossings))
                own.push_back(planned(grid->object, grid->centre, grid->size, false));
        };
        for (std::size_t i = 0; i < requests_.size(); ++i) {
            if (!requests_[i].is_cut) continue;
            if (!(sampled.crossings[i].lower.x <= sampled.crossings[i].upper.x))
                missed.push_back(
                    {requests_[i].object, requests_[i].centre, Vec3d(2 * reach_), requests_[i].cells, false});
            else
                add_own(requests_[i], sampled.crossings[i]);
        }
        // The first grid's lines miss small objects, and skies that are farther away.
        HF_TRY(const ObjectSurfaces nearby,
               object_surfaces(queries_, missed, options_.object_seconds, progress_));
        for (std::size_t i = 0; i < missed.size(); ++i) add_own(missed[i], nearby.crossings[i]);
        std::ranges::sort(own, {}, &GridRequest::object);
        for (int round = 0; round < rounds && !own.empty(); ++round) {
            HF_TRY(ObjectSurfaces again, object_surfaces(queries_, own, options_.object_seconds, progress_));
            for (ObjectSurface& surface : again.surfaces) {
                const auto known =
                    std::ranges::find(sampled.surfaces, surface.object, &ObjectSurface::object);
                request_of(surface.object) = *std::ranges::find(own, surface.object, &GridRequest::object);
                std::erase(distant_, surface.object);
                if (known == sampled.surfaces.end())
                    sampled.surfaces.push_back(std::move(surface));
                else
                    *known = std::move(surface);
            }
            for (std::size_t i = 0; i < own.size(); ++i)
                if (const auto grid = own_grid(own[i], again.crossings[i]))
                    own[i] = planned(grid->object, grid->centre, grid->size, false);
        }
        std::ranges::sort(sampled.surfaces, {}, &ObjectSurface::object);
        return Done{};
    }

    /// Samples objects with parts or gaps narrower than a cell again, with finer grids.
    Result<Done> sample_again(std::vector<ObjectSurface>& surfaces) {
        std::vector<GridRequest> sampled_last;
        for (const ObjectSurface& surface : surfaces) sampled_last.push_back(request_of(surface.object));
        for (int round = 0; round <= finer_grids; ++round) {
            // Silhouettes are missing if they take too long.
            const Result<ObjectSilhouettes> silhouettes =
                ObjectSilhouettes::create(queries_, sampled_last, options_.object_seconds, progress_);
            if (progress_.stop.stop_requested()) return interruption();
            std::vector<GridRequest> finer;
            for (const ObjectSurface& surface : surfaces) {
                const std::size_t doubtful = surface.double_edges + surface.missed_edges;
                const bool is_coarse = silhouettes && silhouettes->wrong_pixels(surface) > most_wrong_pixels;
                if (doubtful <= surface.triangles.size() / 100 + 4 && !is_coarse) continue;
                GridRequest request = request_of(surface.object);
                if (is_finest(request)) continue;
                if (is_coarse && round == finer_grids)
                    warn(survey_.objects[surface.object].statement,
                         fmt::format(
                             "may lack parts or gaps that are narrower than {:.2g}",
                             std::max({request.size.x, request.size.y, request.size.z}) / request.cells));
                request.cells *= 2;
                finer.push_back(request);
            }
            if (round == finer_grids || finer.empty()) break;
            // Objects that take too long remain as they are.
            Result<ObjectSurfaces> sampled =
                object_surfaces(queries_, finer, options_.object_seconds, progress_);
            if (progress_.stop.stop_requested()) return interruption();
            if (!sampled) break;
            for (ObjectSurface& surface : sampled->surfaces) {
                const auto same = std::ranges::find(surfaces, surface.object, &ObjectSurface::object);
                request_of(surface.object) = *std::ranges::find(finer, surface.object, &GridRequest::object);
                *same = std::move(surface);
            }
            sampled_last = std::move(finer);
        }
        return Done{};
    }

    void warn(std::size_t index, std::string_view what) {
        const SceneStatement& at = statement(index);
        std::string text = fmt::format("{}:{}: {} {}", at.file, at.line, at.keyword, what);
        if (std::ranges::find(result_.warnings, text) == result_.warnings.end())
            result_.warnings.push_back(std::move(text));
    }

    /// Returns where the scene is viewed from.
    Vec3d eye() const {
        if (survey_.camera) return survey_.camera->start();
        Vec3d sum(0, 0, 0);
        double count = 0;
        for (const SurveyedObject& object : survey_.objects)
            if (!object.is_infinite() && !object.is_empty()) {
                sum += (object.lower + object.upper) / 2;
                count += 1;
            }
        return count > 0 ? sum / count : sum;
    }

    static double farthest(const SurveyedObject& object, const Vec3d& eye) {
        double distance = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3d point(corner & 1 ? object.upper.x : object.lower.x,
                              corner & 2 ? object.upper.y : object.lower.y,
                              corner & 4 ? object.upper.z : object.lower.z);
            distance = std::max(distance, (point - eye).length());
        }
        return distance;
    }

    static double nearest(const SurveyedObject& object, const Vec3d& eye) {
        Vec3d away(0, 0, 0);
        for (int axis = 0; axis < 3; ++axis)
            away[axis] = std::max({0.0, object.lower[axis] - eye[axis], eye[axis] - object.upper[axis]});
        return away.length();
    }

    /// Divides the objects into near and distant ones, and plans the grids of the near ones.
    void choose_objects() {
        const Vec3d from = eye();
        std::vector<std::pair<double, std::size_t>> finite;
        std::vector<std::size_t> infinite, far;
        for (std::size_t i = 0; i < survey_.objects.size(); ++i) {
            const SurveyedObject& object = survey_.objects[i];
            if (object.is_empty()) continue;
            const double distance = farthest(object, from);
            if (object.is_infinite() || !(distance < 1e6))
                infinite.push_back(i);
            else if (object.longest_side() > 0)
                finite.emplace_back(distance, i);
        }
        std::ranges::sort(finite);
        std::size_t near = 0;
        for (; near < finite.size(); ++near)
            if (near > 0 && finite[near].first > far_factor * std::max(finite[near - 1].first, 1e-9)) break;
        reach_ = near > 0 ? finite[near - 1].first : std::max(10.0, 3 * from.length());
        // Large objects that come near, such as a ground, are cut like infinite ones.
        for (std::size_t k = near; k < finite.size(); ++k) {
            const std::size_t object = finite[k].second;
            const bool is_near = nearest(survey_.objects[object], from) < far_factor * reach_;
            (is_near ? infinite : far).push_back(object);
        }
        std::ranges::sort(infinite);
        distant_ = far;
        for (std::size_t k = 0; k < near; ++k) {
            const SurveyedObject& object = survey_.objects[finite[k].second];
            requests_.push_back(planned(finite[k].second, (object.lower + object.upper) / 2,
                                        object.upper - object.lower, false));
        }
        for (const std::size_t i : infinite) {
            distant_.push_back(i);
            requests_.push_back(planned(i, from, Vec3d(2 * cut_factor * reach_), true));
        }
        result_.distant = far.size();
        result_.distant_objects = far;
        std::ranges::sort(distant_);
        if (requests_.size() > most_objects) {
            std::ranges::stable_sort(requests_, std::ranges::greater(), &GridRequest::cells);
            result_.warnings.push_back(fmt::format("{} objects are too many; the {} smallest are left out",
                                                   requests_.size(), requests_.size() - most_objects));
            requests_.resize(most_objects);
        }
        std::ranges::sort(requests_, {}, &GridRequest::object);
    }

    /// Returns the grid of an object. Its cells are as fine as its size in the picture asks.
    GridRequest planned(std::size_t object, const Vec3d& centre, const Vec3d& size, bool is_cut) const {
        // Some 60,000 vertices for all objects.
        const double share = 10000.0 / static_cast<double>(survey_.objects.size());
        const int fewest = std::clamp(static_cast<int>(std::sqrt(share)), 12, 32);
        const double longest = std::max({size.x, size.y, size.z});
        const double apparent = is_cut ? 1 : std::min(1.5 * apparent_size(centre, longest), 1.0);
        const int wanted = static_cast<int>(std::lround(options_.detail * (is_cut ? 1.5 : apparent)));
        return {object, centre, size, std::max(std::min(fewest, options_.detail), wanted), is_cut};
    }

    /// Returns the size of an object in the picture, relative to the picture's width. 1 without a camera.
    double apparent_size(const Vec3d& centre, double longest) const {
        if (!survey_.camera) return 1;
        const SurveyedCamera& camera = *survey_.camera;
        const double distance = std::max((centre - camera.position).length(), longest / 2),
                     width = camera.right.length() / camera.direction.length();
        return longest / (distance * std::max(width, 1e-3));
    }

    /// Tests whether cells half as large as a request's would be smaller than a pixel.
    bool is_finest(const GridRequest& request) const {
        constexpr double picture_width = 640;  // As imported_camera sets it.
        if (request.is_cut) return false;
        const double longest = std::max({request.size.x, request.size.y, request.size.z});
        return 2 * request.cells > picture_width * apparent_size(request.centre, longest);
    }

    /// Sets the map from the file's coordinates to the scene's.
    void set_frame(const std::vector<ObjectSurface>& surfaces) {
        world_ = scene_frame(survey_.camera, options_.z_up).map();
        scale_ = options_.unit;
        if (options_.size) {
            Bounds box;
            for (const ObjectSurface& surface : surfaces)
                if (!is_cut(surface.object))
                    for (const Vec3f& position : surface.positions) box.add(position);
            const Vec3f side = box.upper - box.lower;
            const double longest = double(std::max({side.x, side.y, side.z}));
            if (longest > 0) scale_ = *options_.size / longest;
        }
        for (Vec3d& axis : world_.axes) axis *= scale_;
    }

    GridRequest& request_of(std::size_t object) {
        return *std::ranges::lower_bound(requests_, object, {}, &GridRequest::object);
    }
    bool is_cut(std::size_t object) const {
        return std::ranges::lower_bound(requests_, object, {}, &GridRequest::object)->is_cut;
    }

    /// Measures the pigments of patterned surfaces in an image, and those of partly transparent ones in
    /// another image with alpha. The surfaces of one statement become one entity, and have the same image.
    Result<Done> add_pigment_images(std::vector<ObjectSurface>& surfaces,
                                    const std::vector<MeasuredFinish>& finishes) {
        std::set<std::size_t> patterned, translucent;
        const auto statement_of = [&](const ObjectSurface& surface) {
            return survey_.objects[surface.object].statement;
        };
        for (ObjectSurface& surface : surfaces) {
            if (find_pattern(surface)) patterned.insert(statement_of(surface));
            if (surface.transmittance > slightly_transparent) translucent.insert(statement_of(surface));
        }
        std::vector<std::size_t> opaque, cut_out;
        for (std::size_t s = 0; s < surfaces.size(); ++s) {
            if (translucent.contains(statement_of(surfaces[s]))) {
                if (!is_transparent(surfaces[s])) cut_out.push_back(s);
            } else if (patterned.contains(statement_of(surfaces[s])))
                opaque.push_back(s);
        }
        std::optional<SurveyedCamera> camera = survey_.camera;
        if (camera && !camera->is_perspective) camera.reset();
        if (!opaque.empty()) {
            HF_TRY(Image image, pigment_image(queries_, requests_, surfaces, opaque, camera,
                                              /*opacity=*/false, survey_.seconds, progress_));
            const std::filesystem::path file = folder_ / (name_ + "_pigments.png");
            const float scale = dim_image(image, opaque, surfaces, finishes);
            HF_TRY_DONE(write_image(image, file));
            for (const std::size_t s : opaque) image_of_[surfaces[s].object] = {file, scale};
        }
        if (!cut_out.empty()) {
            HF_TRY(Image image, pigment_image(queries_, requests_, surfaces, cut_out, camera,
                                              /*opacity=*/true, survey_.seconds, progress_));
            const std::filesystem::path file = folder_ / (name_ + "_cutouts.png");
            const float scale = dim_image(image, cut_out, surfaces, finishes);
            HF_TRY_DONE(write_cut_outs(image, file));
            for (const std::size_t s : cut_out) image_of_[surfaces[s].object] = {file, scale};
        }
        return Done{};
    }

    /// The brightest pigment whose diffuse reflection does not exceed the light.
    static float brightest_pigment(const MeasuredFinish& finish) {
        return 1 / std::max(finish.diffuse, 0.25f);
    }

    /// Divides colours that exceed 1 by the brightest, and clips those above the limit. Returns the divisor.
    float dimmed(std::vector<Rgb>& colours, float limit, std::size_t statement) {
        float brightest = 1;
        for (const Rgb& colour : colours) brightest = std::max({brightest, colour.x, colour.y, colour.z});
        constexpr float rounding = 1.001f, visible = 1.01f;
        if (brightest < rounding) brightest = 1;
        if (brightest > visible * limit)
            warn(statement,
                 fmt::format("has pigments up to {:.3g}; with its finish, those above {:.3g} would "
                             "reflect more light than arrives, and are darker",
                             brightest, limit));
        const float scale = std::min(brightest, limit);
        for (Rgb& colour : colours)
            for (int c = 0; c < 3; ++c) colour[c] = std::clamp(colour[c] / scale, 0.0f, 1.0f);
        return scale;
    }

    /// Dims the image of the pigments of some surfaces, as dimmed. Returns the pigment that multiplies it.
    float dim_image(Image& image, const std::vector<std::size_t>& chosen,
                    const std::vector<ObjectSurface>& surfaces, const std::vector<MeasuredFinish>& finishes) {
        float limit = INFINITY;
        for (const std::size_t s : chosen) limit = std::min(limit, brightest_pigment(finishes[s]));
        const auto light = static_cast<float>(gamma_.light(double(limit)));
        const std::size_t at = survey_.objects[surfaces[chosen.front()].object].statement;
        return static_cast<float>(gamma_.number(double(dimmed(image.pixels, light, at))));
    }

    static bool is_transparent(const ObjectSurface& surface) {
        return std::max({surface.filter.x, surface.filter.y, surface.filter.z}) > mostly_transparent;
    }

    /// Returns the name of the entity of a statement.
    std::string entity_name(std::size_t index) {
        const SceneStatement& at = statement(index);
        std::string name = plain_name(at.name.empty() ? at.keyword : at.name);
        std::replace(name.begin(), name.end(), '.', '_');
        name.erase(0, name.find_first_not_of("_-"));
        return unique_name(name.empty() ? "object" : name.substr(0, 60), names_);
    }

    static void append(const ObjectSurface& part, ObjectSurface& whole) {
        const auto first = static_cast<std::uint32_t>(whole.positions.size());
        whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
        whole.normals.insert(whole.normals.end(), part.normals.begin(), part.normals.end());
        whole.colours.insert(whole.colours.end(), part.colours.begin(), part.colours.end());
        whole.uvs.insert(whole.uvs.end(), part.uvs.begin(), part.uvs.end());
        for (const auto& [a, b, c] : part.triangles)
            whole.triangles.push_back({a + first, b + first, c + first});
    }

    Result<Done> add_entities(const std::vector<ObjectSurface>& surfaces,
                              const std::vector<MeasuredFinish>& finishes) {
        std::map<std::size_t, std::vector<std::size_t>> by_statement;
        std::vector<std::size_t> transparent;
        for (const ObjectSurface& surface : surfaces)
            for (const Vec3f& position : surface.positions)
                (is_cut(surface.object) ? cut_bounds_ : bounds_).add(Vec3f(world_.point(Vec3d(position))));
        for (std::size_t s = 0; s < surfaces.size(); ++s) {
            const std::size_t at = survey_.objects[surfaces[s].object].statement;
            if (is_transparent(surfaces[s])) {
                transparent.push_back(s);
                continue;
            }
            if (surfaces[s].missed_edges > surfaces[s].triangles.size() / 200 + 4)
                warn(at, fmt::format("may have wrong places: {} of its grid edges have no crossing",
                                     surfaces[s].missed_edges));
            by_statement[at].push_back(s);
            result_.mesh_objects.push_back(surfaces[s].object);
        }
        for (const auto& [at, members] : by_statement) {
            const bool together = members.size() > many;
            for (std::size_t m = 0; m < members.size(); m += together ? members.size() : 1) {
                ObjectSurface whole = surfaces[members[m]];
                if (together)
                    for (std::size_t k = 1; k < members.size(); ++k) append(surfaces[members[k]], whole);
                HF_TRY_DONE(add_entity(at, std::move(whole), finishes[members[m]]));
            }
            result_.surfaces += members.size();
        }
        result_.transparent = transparent.size();
        return keep_live(surfaces, transparent);
    }

    /// Adds transparent objects as filters, and remembers them for write_live.
    ///
    /// transparent  indices of surfaces, in rising order.
    Result<Done> keep_live(const std::vector<ObjectSurface>& surfaces,
                           const std::vector<std::size_t>& transparent) {
        // Glass has thin walls, and triangles of filters cost little. Some objects have fine grids already.
        std::vector<GridRequest> finer;
        std::vector<ObjectSurface> measured;
        for (const std::size_t s : transparent) {
            result_.live_objects.push_back(surfaces[s].object);
            measured.push_back(surfaces[s]);
            finer.push_back(request_of(surfaces[s].object));
            finer.back().cells =
                std::max(finer.back().cells, std::min(2 * finer.back().cells, 2 * options_.detail));
        }
        HF_TRY(std::vector<FilterPart> parts,
               filter_parts(queries_, finer, measured, options_.object_seconds, progress_));
        for (FilterPart& part : parts) HF_TRY_DONE(add_filter(std::move(part)));
        return Done{};
    }

    /// Adds a part of a transparent object as a filter.
    Result<Done> add_filter(FilterPart part) {
        const std::size_t at = survey_.objects[part.surface.object].statement;
        warn(at, keeps_scene() ? "is transparent; it is not baked, but filters light and is in in_place.png"
                               : "is transparent; it is not baked, but filters light");
        SceneFilter filter;
        filter.mesh = folder_ / fmt::format("{}_{}.ply", name_, entity_name(at));
        filter.colour = part.filter;
        filter.absorption = part.absorption / static_cast<float>(scale_);
        filter.vertex_colours = part.vertex_colours;
        ObjectSurface& mesh = part.surface;
        move_to_world(mesh);
        if (!part.vertex_colours) mesh.colours.assign(mesh.positions.size(), Rgb(1.0f));
        mesh.uvs.clear();
        result_.scene.filters.push_back(filter);
        return write_surface_ply(filter.mesh, mesh);
    }

    void move_to_world(ObjectSurface& surface) const {
        for (std::size_t v = 0; v < surface.positions.size(); ++v) {
            surface.positions[v] = Vec3f(world_.point(Vec3d(surface.positions[v])));
            surface.normals[v] = Vec3f(world_.normal(Vec3d(surface.normals[v])));
        }
        if (world_.is_mirrored())
            for (auto& triangle : surface.triangles) std::swap(triangle[1], triangle[2]);
    }

    /// True if surroundings with the transparent objects can be written: their units are metres.
    bool keeps_scene() const { return scale_ == 1 && options_.queries.wrap.object.empty(); }

    /// Writes the transparent objects as POV-Ray's objects, with lights, sky and camera.
    Result<Done> write_live() {
        if (result_.live_objects.empty() || !keeps_scene()) return Done{};
        SceneQuery query;
        query.lights = query.sky = query.camera = query.extras = true;
        place_objects(result_.live_objects, query);
        Surroundings surroundings;
        const std::string live = name_ + "_live";
        surroundings.file = folder_ / live / (live + ".pov");
        surroundings.folder = std::filesystem::absolute(queries_.file()).parent_path().lexically_normal();
        const SceneFrame frame = scene_frame(survey_.camera, options_.z_up);
        surroundings.z_up = frame.z_up;
        surroundings.left_handed = frame.left_handed;
        result_.scene.surroundings = surroundings;
        return queries_.write_files(query, surroundings.file);
    }

    Result<Done> add_entity(std::size_t at, ObjectSurface surface, const MeasuredFinish& finish) {
        const std::string name = entity_name(at);
        move_to_world(surface);
        SceneMaterial material;
        material.convention = LobeConvention::povray;
        material.vertex_colours = surface.uvs.empty();
        float brightest = 1;
        if (surface.uvs.empty())
            brightest = dimmed(surface.colours, brightest_pigment(finish), at);
        else
            std::tie(material.image, brightest) = image_of_.at(surface.object);
        material.pigment = Rgb(brightest);
        material.diffuse = material.pigment * finish.diffuse;
        material.phong = finish.phong;
        material.shininess = finish.phong_size;
        material.blinn = finish.specular;
        material.roughness = finish.roughness;
        material.specular = Rgb(finish.phong > 0 || finish.specular > 0 ? 1.0f : 0.0f);
        (is_lit_by_lights() ? material.ambient : material.emission) = material.pigment * finish.emission;
        constexpr float least_reflection = 0.02f;
        if (finish.reflection > least_reflection)
            material.reflection.at_normal = material.reflection.at_grazing =
                Rgb(std::min(finish.reflection, 1.0f));
        result_.scene.materials[name] = material;
        if (!is_cut(surface.object)) return add_mesh(name, name, surface, false);
        // Tolerances are relative to the size of an entity, so that near parts need a separate one.
        const std::vector<ObjectSurface> zones = surface_zones(surface);
        const std::array<std::string, 3> names{name, name + "_around", name + "_far"};
        for (std::size_t zone = 0; zone < zones.size(); ++zone)
            if (!zones[zone].triangles.empty())
                HF_TRY_DONE(add_mesh(zone == 0 ? name : unique_name(names[zone], names_), name, zones[zone],
                                     is_flat(zones[zone])));
        return Done{};
    }

    /// Divides a surface into what is near the finite objects, what is around that, and the rest.
    std::vector<ObjectSurface> surface_zones(const ObjectSurface& surface) const {
        constexpr std::array<float, 2> reaches{2.0f, 10.0f};  // Half widths, in radii of the finite objects.
        const bool has_finite = bounds_.lower.x <= bounds_.upper.x;
        const Vec3f centre = has_finite ? bounds_.centre() : Vec3f(world_.point(eye()));
        const float radius =
            has_finite ? bounds_.radius() : static_cast<float>(reach_ * scale_) / reaches.back();
        std::vector<ObjectSurface> zones(reaches.size() + 1);
        std::vector<std::map<std::uint32_t, std::uint32_t>> numbers(zones.size());
        for (const auto& triangle : surface.triangles) {
            std::size_t zone = 0;
            for (const std::uint32_t corner : triangle) {
                const Vec3f away = surface.positions[corner] - centre;
                const float distance = std::max({std::abs(away.x), std::abs(away.y), std::abs(away.z)});
                while (zone < reaches.size() && distance > reaches[zone] * radius) ++zone;
            }
            ObjectSurface& part = zones[zone];
            std::array<std::uint32_t, 3> corners;
            for (std::size_t c = 0; c < 3; ++c) {
                const auto [entry, is_new] =
                    numbers[zone].try_emplace(triangle[c], static_cast<std::uint32_t>(part.positions.size()));
                corners[c] = entry->second;
                if (!is_new) continue;
                part.positions.push_back(surface.positions[triangle[c]]);
                part.normals.push_back(surface.normals[triangle[c]]);
                part.colours.push_back(surface.colours[triangle[c]]);
                if (!surface.uvs.empty()) part.uvs.push_back(surface.uvs[triangle[c]]);
            }
            part.triangles.push_back(corners);
        }
        return zones;
    }

    static bool is_flat(const ObjectSurface& surface) {
        constexpr float least_cosine = 0.999999f;
        return std::ranges::all_of(surface.normals, [&](const Vec3f& normal) {
            return normal.dot(surface.normals.front()) > least_cosine;
        });
    }

    /// Tests whether the camera is in the interior of a closed surface: POV-Ray shows walls from both sides.
    bool has_camera_inside(const ObjectSurface& surface) const {
        if (!survey_.camera) return false;
        const Vec3d from = world_.point(survey_.camera->start());
        return surface_crossings(surface, from, {0.57, 0.31, 0.76}).size() % 2 == 1;
    }

    /// Writes a mesh, and adds an entity with one instance.
    Result<Done> add_mesh(const std::string& name, const std::string& material, const ObjectSurface& surface,
                          bool is_flat) {
        Entity entity;
        entity.name = name;
        entity.mesh = folder_ / fmt::format("{}_{}.ply", name_, name);
        entity.material = material;
        if (is_flat) entity.coarse_triangles = RenderSettings().exact_triangles;
        if (!is_cut(surface.object) && has_camera_inside(surface)) entity.faces = ClosedFaces::inwards;
        HF_TRY_DONE(write_surface_ply(entity.mesh, surface));
        Instance instance;
        instance.entity = result_.scene.entities.size();
        vertex_counts_.push_back(surface.positions.size());
        result_.scene.entities.push_back(std::move(entity));
        result_.scene.instances.push_back(instance);
        return Done{};
    }

    /// Vertices of the meshes suffice, unless the user wants more.
    void share_vertices() {
        constexpr std::uint32_t fewest = 500, fewest_samples = 400;
        const double total = std::accumulate(vertex_counts_.begin(), vertex_counts_.end(), 0.0);
        const auto fields = static_cast<std::uint32_t>(std::max<std::size_t>(1, vertex_counts_.size() / 2));
        for (std::size_t e = 0; e < vertex_counts_.size(); ++e) {
            Entity& entity = result_.scene.entities[e];
            const double share = static_cast<double>(vertex_counts_[e]) / total * options_.vertices;
            entity.fine_vertices = std::max(fewest, static_cast<std::uint32_t>(share / 100) * 100);
            entity.planar_samples = std::max(fewest_samples, entity.planar_samples / fields);
            entity.spherical_samples = std::max(fewest_samples, entity.spherical_samples / fields);
        }
    }

    void add_lights() {
        std::set<std::string> taken;
        for (const ModelLight& light : survey_.lights) {
            SceneLamp lamp = scene_lamp(light, world_, scale_);
            lamp.name = unique_name("light", taken);
            bool is_negative = false;
            for (int c = 0; c < 3; ++c) {
                is_negative = is_negative || lamp.colour[c] < 0;
                lamp.colour[c] = std::max(0.0f, lamp.colour[c]);
            }
            if (is_negative)
                result_.warnings.emplace_back("a light with a negative colour is left out or darker");
            if (is_bright(lamp.colour)) result_.scene.lamps.push_back(std::move(lamp));
        }
        for (const std::size_t light : survey_.unread_lights)
            warn(light, "has properties that haarfield does not have; left out");
    }

    void set_camera() {
        Scene& scene = result_.scene;
        const std::optional<SurveyedCamera>& camera = survey_.camera;
        scene.finds_camera = !camera || !camera->is_perspective;
        if (!camera) result_.warnings.emplace_back("the file has no camera");
        if (camera && !camera->is_perspective)
            result_.warnings.emplace_back("the camera is not a perspective camera; another one is chosen");
        if (scene.finds_camera) return;
        const Bounds& box = bounds_.lower.x <= bounds_.upper.x ? bounds_ : cut_bounds_;
        scene.camera = imported_camera(*camera, world_, box, result_.warnings);
    }

    /// Renders the sky and distant objects around the camera.
    Result<Done> add_environment() {
        AffineMap turn = world_;
        for (Vec3d& axis : turn.axes) axis /= scale_;
        HF_TRY(Image environment,
               surrounding_light(queries_, eye(), turn, distant_, gamma_.is_legacy, progress_));
        if (std::ranges::all_of(environment.pixels, [](const Rgb& pixel) { return pixel == Rgb(0.0f); }))
            return Done{};
        if (gamma_.exponent != 1)
            for (Rgb& pixel : environment.pixels)
                for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(gamma_.number(double(pixel[c])));
        const std::filesystem::path file = folder_ / (name_ + "_environment.exr");
        HF_TRY_DONE(write_image(environment, file));
        result_.scene.environment.image = file;
        result_.scene.environment.lights = !is_lit_by_lights();
        return Done{};
    }

    void name_unused() {
        for (const UnusedStatement& unused : queries_.scene().unused) {
            if (unused.keyword == "interior" || unused.keyword == "radiosity") continue;
            result_.warnings.push_back(
                fmt::format("{}:{}: {} is left out{}", unused.file, unused.line, unused.keyword,
                            unused.count > 1 ? fmt::format(" ({} times)", unused.count) : std::string()));
        }
    }

    const SceneQueries& queries_;
    std::filesystem::path folder_;
    std::string name_;
    const PovrayImport& options_;
    const Progress& progress_;
    const SceneGamma& gamma_;
    SceneSurvey survey_;
    std::vector<GridRequest> requests_;  ///< Sorted by object.
    std::vector<std::size_t> distant_;   ///< Objects of the environment, sorted.
    double reach_ = 1;                   ///< Distance from the eye to the farthest near object.
    double scale_ = 1;                   ///< From the file's unit to metres.
    AffineMap world_;
    /// Images of pigments, each with the colour that multiplies it, by object.
    std::map<std::size_t, std::pair<std::filesystem::path, float>> image_of_;
    std::set<std::string> names_;
    std::vector<std::size_t> vertex_counts_;  ///< By entity.
    Bounds bounds_, cut_bounds_;  ///< In the scene: of the finite objects, and of those that are cut.
    ImportedPovrayScene result_;
};

}  // namespace

Camera imported_camera(const SurveyedCamera& surveyed, const AffineMap& world, const Bounds& box,
                       std::vector<std::string>& warnings) {
    assert(surveyed.is_perspective);
    Camera camera;
    if (surveyed.plane)
        warnings.emplace_back(
            fmt::format("the camera is orthographic; a perspective camera at {:.0f} times the width of its "
                        "picture replaces it",
                        surveyed.direction.length() / surveyed.right.length()));
    const Vec3d position = world.point(surveyed.position),
                ahead = world.direction(surveyed.direction).normalized();
    const double distance =
        std::max(1e-3 * double(box.radius()), (Vec3d(box.centre()) - position).dot(ahead));
    camera.position = Vec3f(position);
    camera.target = Vec3f(position + ahead * distance);
    const double up = surveyed.up.length(), right = surveyed.right.length(),
                 depth = surveyed.direction.length();
    camera.vertical_fov = static_cast<float>(2 * std::atan(up / (2 * depth)));
    camera.width = 640;
    camera.height = std::clamp(static_cast<int>(std::lround(640 * up / right)), 16, 4096);
    if (std::abs(world.direction(surveyed.right).normalized().y) > 0.02)
        warnings.emplace_back("the camera is rolled; the import's camera is upright");
    if (std::abs(surveyed.direction.dot(surveyed.up)) > 0.01 * up * depth ||
        std::abs(surveyed.direction.dot(surveyed.right)) > 0.01 * right * depth)
        warnings.emplace_back("the camera is sheared; the import's camera is not");
    return camera;
}

Result<ImportedPovrayScene> imported_povray_scene(const std::filesystem::path& file,
                                                  const std::filesystem::path& folder,
                                                  const std::string& name, const PovrayImport& options,
                                                  const Progress& progress) {
    HF_TRY(SceneQueries queries, SceneQueries::create(file, options.queries));
    HF_TRY_DONE(queries.measure_gamma(progress));
    HF_TRY_DONE(make_folder(folder));
    return Importer(queries, folder, name, options, progress).imported();
}

}  // namespace haarfield
