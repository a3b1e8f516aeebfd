#include "scenes/scene_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "fields/base/names.h"
#include "fields/mesh/mesh_topology.h"
#include "fields/model/mesh_reader.h"
#include "fields/model/model_file.h"
#include "scenes/scene_environment.h"
#include "scenes/shape.h"
#include "shading/scene/shaded_scene.h"

namespace haarfield {
namespace {

/// Returns upright_frame, scaled uniformly.
AffineMap turned_and_scaled(bool z_up, bool left_handed, double scale) {
    AffineMap map = upright_frame(z_up, left_handed);
    for (Vec3d& axis : map.axes) axis *= scale;
    return map;
}

/// Returns a name that is valid in files and in POV-Ray.
std::string file_name(const std::string& name, const std::string& otherwise) {
    std::string plain = plain_name(name);
    plain.erase(0, plain.find_first_not_of("_-."));
    plain = plain.substr(0, 60);
    return plain.empty() ? otherwise : plain;
}

/// An instance that has no place in the scene yet.
struct Placed {
    std::size_t entity;
    std::string name;
    AffineMap place;   ///< In the file's coordinates.
    std::size_t file;  ///< Index of its file.
};

/// The size of an entity's mesh.
struct Extent {
    Bounds bounds;  ///< In its own frame.
    double area = 0;
};

Extent extent_of(const Mesh& mesh) {
    Extent extent{mesh_bounds(mesh), 0};
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3d p(mesh.positions[a]);
        extent.area += (Vec3d(mesh.positions[b]) - p).cross(Vec3d(mesh.positions[c]) - p).length() / 2;
    }
    return extent;
}

/// The closed pieces of a mesh of which some face inwards: rooms, or solids turned inside out.
struct PossibleRooms {
    std::vector<Vec3f> positions;     ///< Positions of the mesh.
    std::vector<ClosedPiece> pieces;  ///< Empty if no piece faces inwards.
    std::vector<Vec3f> contents;      ///< A point in each open piece.
};

PossibleRooms possible_rooms(Mesh mesh) {
    MeshFindings ignored;
    leave_out_bad_triangles(mesh, ignored);
    PossibleRooms possible{mesh.positions, closed_pieces(mesh), {}};
    if (std::ranges::none_of(possible.pieces, &ClosedPiece::faces_inwards)) return {};
    const std::vector<std::uint8_t> open = triangles_of_open_pieces(mesh);
    const std::vector<std::uint32_t> piece_of = triangle_pieces(mesh, merged_positions(mesh.positions));
    std::map<std::uint32_t, Bounds> open_pieces;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (open[t])
            for (const std::uint32_t corner : mesh.triangles[t])
                open_pieces[piece_of[t]].add(mesh.positions[corner]);
    for (const auto& [piece, bounds] : open_pieces) possible.contents.push_back(bounds.centre());
    return possible;
}

/// Returns the point that an invertible map moves to `moved`.
Vec3d point_before(const AffineMap& map, const Vec3d& moved) {
    const auto& [x, y, z] = map.axes;
    const Vec3d d = moved - map.origin;
    return Vec3d(d.dot(y.cross(z)), d.dot(z.cross(x)), d.dot(x.cross(y))) / x.dot(y.cross(z));
}

std::array<Vec3d, 8> corners_of(const Bounds& bounds) {
    std::array<Vec3d, 8> corners;
    for (std::size_t k = 0; k < 8; ++k)
        corners[k] = {double(k & 1 ? bounds.upper.x : bounds.lower.x),
                      double(k & 2 ? bounds.upper.y : bounds.lower.y),
                      double(k & 4 ? bounds.upper.z : bounds.lower.z)};
    return corners;
}

double longest_side(const Bounds& bounds) {
    const Vec3f size = bounds.upper - bounds.lower;
    return double(std::max({size.x, size.y, size.z}));
}

/// Tests whether two boxes overlap in a volume.
bool overlap(const Bounds& a, const Bounds& b) {
    for (int axis = 0; axis < 3; ++axis)
        if (std::min(a.upper[axis], b.upper[axis]) <= std::max(a.lower[axis], b.lower[axis])) return false;
    return true;
}

/// Returns the approximate factor by which a map scales areas.
double area_scale(const AffineMap& map) {
    const auto& [x, y, z] = map.axes;
    return (x.cross(y).length() + y.cross(z).length() + z.cross(x).length()) / 3;
}

class Importer {
public:
    Importer(const SceneImport& wanted, const Progress& progress) : wanted_(wanted), progress_(progress) {}

    Result<Done> add(const std::filesystem::path& path) {
        HF_TRY(const ModelFile opened, ModelFile::open(path));
        const ModelFile& model = opened;
        const std::size_t file = files_.size();
        files_.push_back({path.string(), Vec3d(0, 0, 0), model.is_left_handed()});
        const std::string stem = file_name(path.stem().string(), "model");
        const ModelParts& parts = model.parts();
        const bool stands_still =
            parts.nodes.size() == parts.names.size() &&
            std::ranges::all_of(parts.nodes, [](const ModelNode& node) { return node.place == AffineMap(); });
        if (!camera_ && parts.camera) camera_ = {*parts.camera, file};
        for (const ModelLight& light : parts.lights) lights_.push_back({light, file});
        if (parts.unread_lights > 0)
            warnings.push_back(fmt::format("{}: {} light_sources are not plain data; left out", path.string(),
                                           parts.unread_lights));
        if (wanted_.whole || stands_still || parts.names.size() == 1) {
            const bool is_part = parts.names.size() == 1 && !wanted_.whole && !stands_still;
            HF_TRY(const std::optional<std::size_t> entity,
                   add_entity(model, is_part ? std::optional<std::size_t>(0) : std::nullopt, stem, path));
            if (!entity) return Done{};
            if (!is_part) placed_.push_back({*entity, stem, AffineMap(), file});
            for (const ModelNode& node : parts.nodes)
                if (is_part) placed_.push_back({*entity, file_name(node.name, stem), node.place, file});
            return Done{};
        }
        std::vector<std::optional<std::size_t>> entity_of_part;
        for (std::size_t part = 0; part < parts.names.size(); ++part) {
            if (progress_.stop.stop_requested()) return interruption();
            HF_TRY(const std::optional<std::size_t> entity,
                   add_entity(model, part, file_name(parts.names[part], stem), path));
            entity_of_part.push_back(entity);
            if (progress_.report) progress_.report("parts of " + stem, part + 1, parts.names.size());
        }
        for (const ModelNode& node : parts.nodes)
            if (const auto entity = entity_of_part[node.part])
                placed_.push_back(
                    {*entity, file_name(node.name, scene.entities[*entity].name), node.place, file});
        return Done{};
    }

    Result<Done> place() {
        if (placed_.empty()) return Error{"", "found no surface; expected a model with triangles"};
        set_shifts();
        Bounds all;
        for (const Bounds& box : upright_bounds())
            if (box.lower.x <= box.upper.x) all.add(box.lower), all.add(box.upper);
        const double longest = longest_side(all);
        scale_ = wanted_.size && longest > 0 ? *wanted_.size / longest : wanted_.unit;
        if (wanted_.stand_at) {
            const Vec3d shift = *wanted_.stand_at / scale_ -
                                Vec3d(double(all.centre().x), double(all.lower.y), double(all.centre().z));
            for (File& file : files_) file.shift += shift;
            all.lower += Vec3f(shift);
            all.upper += Vec3f(shift);
        }
        if (!wanted_.size && longest * scale_ < smallest_usual_size)
            warnings.push_back(fmt::format(
                "the models are {:.2g} m large; is their scale applied twice? See --unit and --scale-to",
                longest * scale_));
        double area = 0;
        std::set<std::string> taken;
        for (const Entity& entity : scene.entities) taken.insert(entity.name);
        std::map<std::string, std::size_t> count;
        for (const Placed& placed : placed_) ++count[placed.name];
        for (const Placed& placed : placed_) {
            const AffineMap place = world_of(placed.file) * placed.place;
            const Result<PlacedShape> parts = placed_shape(place.rows());
            if (!parts) return Error{placed.name, "its transform " + parts.error().what};
            Instance instance;
            instance.entity = placed.entity;
            // A single instance that has the name of its entity needs no explicit name.
            const bool is_own = placed.name == scene.entities[placed.entity].name;
            if (!is_own || count[placed.name] > 1) instance.name = unique_name(placed.name, taken);
            instance.placement = parts->placement;
            instance.placement.translate = Vec3f(place.origin);
            instance.shape = parts->shape;
            const double own_area = extents_[placed.entity].area * area_scale(place);
            area += own_area;
            triangles_ += triangle_counts_[placed.entity];
            areas_[placed.entity] += own_area;
            ++instances_[placed.entity];
            scene.instances.push_back(std::move(instance));
        }
        share_vertices(area);
        find_rooms();
        for (int axis = 0; axis < 3; ++axis) {
            bounds.lower[axis] = static_cast<float>(double(all.lower[axis]) * scale_);
            bounds.upper[axis] = static_cast<float>(double(all.upper[axis]) * scale_);
        }
        set_camera();
        for (const PlacedLight& light : lights_)
            scene.lamps.push_back(placed_lamp(light.light, world_of(light.file), scale_));
        find_open_room();
        enter_room();
        expose_lights();
        return Done{};
    }

    Scene scene;
    Bounds bounds;  ///< Of all placed models.
    std::vector<std::string> warnings;
    bool has_sky = true;      ///< No light comes from a POV-Ray scene.
    bool is_in_room = false;  ///< One room encloses everything.

private:
    /// A file, and the translation of its models once they are upright, in its units.
    struct File {
        std::string path;
        Vec3d shift;
        bool left_handed;  ///< Its coordinates.
    };
    struct PlacedLight {
        ModelLight light;
        std::size_t file;
    };
    struct PlacedCamera {
        ModelCamera camera;
        std::size_t file;
    };
    static constexpr double smallest_usual_size = 0.01;  // [m]

    /// Returns the map from a file's coordinates to the scene.
    AffineMap world_of(std::size_t file) const {
        AffineMap world = turned_and_scaled(wanted_.z_up, files_[file].left_handed, scale_);
        world.origin = files_[file].shift * scale_;
        return world;
    }

    /// Returns the bounds by file, in its units, upright and shifted. A file without a surface has an empty
    /// box.
    std::vector<Bounds> upright_bounds() const {
        std::vector<Bounds> boxes(files_.size());
        for (const Placed& instance : placed_) {
            const File& file = files_[instance.file];
            const AffineMap upright = turned_and_scaled(wanted_.z_up, file.left_handed, 1) * instance.place;
            for (const Vec3d& corner : corners_of(extents_[instance.entity].bounds))
                boxes[instance.file].add(Vec3f(upright.point(corner) + file.shift));
        }
        return boxes;
    }

    /// Places the models of files side by side if any two overlap.
    void set_shifts() {
        const std::vector<Bounds> boxes = upright_bounds();
        std::vector<std::size_t> full;
        for (std::size_t i = 0; i < boxes.size(); ++i)
            if (boxes[i].lower.x <= boxes[i].upper.x) full.push_back(i);
        if (full.size() < 2) return;
        warn_of_units(boxes, full);
        std::optional<std::pair<std::size_t, std::size_t>> overlapping;
        for (const std::size_t i : full)
            for (const std::size_t j : full)
                if (i < j && !overlapping && overlap(boxes[i], boxes[j])) overlapping = {i, j};
        if (wanted_.keep_places || !overlapping) return;
        double widest = 0;
        for (const std::size_t i : full)
            widest = std::max(widest, double(boxes[i].upper.x - boxes[i].lower.x));
        const Bounds& first = boxes[full.front()];
        double left = double(first.lower.x);
        for (const std::size_t i : full) {
            const Bounds& box = boxes[i];
            files_[i].shift = Vec3d(left - double(box.lower.x), double(first.lower.y - box.lower.y),
                                    double(first.centre().z - box.centre().z));
            left += double(box.upper.x - box.lower.x) + 0.1 * widest;
        }
        warnings.push_back(fmt::format(
            "{} overlaps {}: the models are placed side by side; --keep-places leaves them where their files "
            "place them",
            files_[overlapping->second].path, files_[overlapping->first].path));
    }

    void warn_of_units(const std::vector<Bounds>& boxes, const std::vector<std::size_t>& full) {
        constexpr double unusual_ratio = 100;
        const auto size = [&](std::size_t i) { return longest_side(boxes[i]); };
        const std::size_t small = *std::ranges::min_element(full, {}, size),
                          large = *std::ranges::max_element(full, {}, size);
        if (size(large) > unusual_ratio * size(small))
            warnings.push_back(fmt::format("{} is {:.0f} times as large as {}; are both in the same unit?",
                                           files_[large].path, size(large) / size(small),
                                           files_[small].path));
    }

    /// Adds an entity. Returns nothing, with a warning, for one of several parts if it has no surface.
    Result<std::optional<std::size_t>> add_entity(const ModelFile& model, std::optional<std::size_t> part,
                                                  const std::string& name,
                                                  const std::filesystem::path& path) {
        const Result<ImportedMesh> imported = read_mesh(model, part, {});
        if (!imported && part && model.parts().names.size() > 1) {
            warnings.push_back(imported.error().message() + "; left out");
            return std::optional<std::size_t>();
        }
        if (!imported) return imported.error();
        Entity entity;
        entity.name = unique_name(name, names_);
        entity.mesh = path;
        if (part) entity.part = model.parts().names[*part];
        scene.entities.push_back(std::move(entity));
        extents_.push_back(extent_of(imported->mesh));
        HF_TRY(const FaceGatherer as_it_is, model.faces(part));
        possible_rooms_.push_back(possible_rooms(as_it_is.mesh));
        triangle_counts_.push_back(as_it_is.mesh.triangles.size());
        faces_.push_back(as_it_is.mesh.triangles.size() > most_room_triangles ? Mesh() : as_it_is.mesh);
        emits_light_ |= std::ranges::any_of(
            imported->materials, [](const MeshMaterial& material) { return material.emission != Rgb(0.0f); });
        areas_.push_back(0);
        instances_.push_back(0);
        return std::optional(scene.entities.size() - 1);
    }

    /// Sets Entity::faces.
    void find_rooms() {
        std::vector<Vec3d> contents;
        for (const Placed& placed : placed_)
            contents.push_back(
                (world_of(placed.file) * placed.place).point(Vec3d(extents_[placed.entity].bounds.centre())));
        for (const PlacedLight& light : lights_)
            if (light.light.kind != ModelLight::Kind::parallel)
                contents.push_back(world_of(light.file).point(Vec3d(light.light.position)));
        if (camera_) contents.push_back(world_of(camera_->file).point(Vec3d(camera_->camera.position)));
        for (std::size_t i = 0; i < placed_.size(); ++i) {
            const PossibleRooms& possible = possible_rooms_[placed_[i].entity];
            if (possible.pieces.empty()) continue;
            const AffineMap place = world_of(placed_[i].file) * placed_[i].place;
            std::vector<Vec3f> inside = possible.contents;
            for (std::size_t other = 0; other < contents.size(); ++other)
                if (other != i) inside.emplace_back(point_before(place, contents[other]));
            const Vec3d up = Vec3d(place.axes[0].y, place.axes[1].y, place.axes[2].y).normalized();
            const std::vector<std::size_t> found = rooms(possible.positions, possible.pieces, inside, up);
            if (found.empty()) continue;
            scene.entities[placed_[i].entity].faces = ClosedFaces::inwards;
            const ClosedPiece& largest = possible.pieces[found[0]];
            if (const double size = room_size(largest, place); !room_ || size > room_->size) {
                room_ = Room{placed_[i].entity, size, {}};
                add_walls(possible.positions, largest.triangles, place, /*are_turned=*/true);
            }
        }
    }

    /// Adds triangles to the room's walls. Triangles of closed pieces face outwards and must be reversed.
    void add_walls(std::span<const Vec3f> positions, std::span<const std::array<std::uint32_t, 3>> triangles,
                   const AffineMap& place, bool are_turned) {
        const auto& [x, y, z] = place.axes;
        const bool mirrors = x.cross(y).dot(z) < 0;
        for (const auto& [a, b, c] : triangles) {
            const auto corner = [&](std::uint32_t v) { return place.point(Vec3d(positions[v])); };
            if (are_turned == mirrors)
                room_->walls.push_back({corner(a), corner(b), corner(c)});
            else
                room_->walls.push_back({corner(a), corner(c), corner(b)});
        }
    }

    /// Recognizes a room with windows or doors: triangles that face a place and surround it on most sides.
    void find_open_room() {
        if (room_ || camera_ || triangles_ == 0 || triangles_ > most_room_triangles) return;
        room_ = Room{placed_[0].entity, 0, {}};
        for (const Placed& placed : placed_)
            add_walls(faces_[placed.entity].positions, faces_[placed.entity].triangles,
                      world_of(placed.file) * placed.place, /*are_turned=*/false);
        if (const std::optional<Vec3d> place = standing_place(); place && is_between_walls(*place)) return;
        room_.reset();
    }

    /// Tests whether most horizontal rays meet walls, and most vertical rays a level floor and a ceiling.
    bool is_between_walls(const Vec3d& place) const {
        constexpr int rays = 32;
        const Vec3d size(bounds.upper - bounds.lower);
        int walls = 0, floors = 0, ceilings = 0;
        for (int i = 0; i < rays; ++i) {
            const double angle = 2 * pi * (i + 0.5) / rays;
            const Vec3d ahead(std::cos(angle), 0, std::sin(angle));
            if (const auto wall = first_wall(place, ahead))
                walls += std::abs(wall->normal.y) < 0.02 && wall->normal.dot(ahead) < 0;
            const Vec3d aside = place + ahead * (0.02 * std::min(size.x, size.z));
            if (const auto floor = first_wall(aside, {0, -1, 0})) floors += floor->normal.y > 0.98;
            if (const auto ceiling = first_wall(aside, {0, 1, 0})) ceilings += ceiling->normal.y < -0.5;
        }
        return std::min({walls, floors, ceilings}) >= rays / 2;
    }

    /// Returns the winding number of the room's walls: negative inside.
    double winding_of_walls(const Vec3d& place) const {
        std::vector<Vec3f> positions;
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (const std::array<Vec3d, 3>& wall : room_->walls) {
            const auto first = static_cast<std::uint32_t>(positions.size());
            for (const Vec3d& corner : wall) positions.emplace_back(corner - place);
            triangles.push_back({first, first + 1, first + 2});
        }
        return winding_number(positions, triangles, Vec3d(0, 0, 0));
    }

    Bounds room_bounds() const {
        Bounds box;
        for (const std::array<Vec3d, 3>& wall : room_->walls)
            for (const Vec3d& corner : wall) box.add(Vec3f(corner));
        return box;
    }

    /// Tests whether a place and four places around it are inside.
    bool is_clear(const Vec3d& place, const Vec3d& size) const {
        constexpr double inside = -0.6;  // Winding number.
        constexpr std::array<std::array<double, 2>, 5> near{{{0, 0}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
        const double reach = 0.05 * std::min(size.x, size.z);
        return std::ranges::all_of(near, [&](const auto& aside) {
            return winding_of_walls(place + Vec3d(aside[0], 0, aside[1]) * reach) < inside;
        });
    }

    /// Returns the middle of the room. If it is not clear, returns the place at half height that is farthest
    /// from walls.
    std::optional<Vec3d> standing_place() const {
        constexpr int cells = 6, directions = 8;
        const Bounds box = room_bounds();
        const Vec3d middle(box.centre()), size(box.upper - box.lower);
        if (is_clear(middle, size)) return middle;
        std::optional<Vec3d> best;
        double farthest = 0;
        for (int i = 0; i < cells * cells; ++i) {
            const Vec3d place = middle + Vec3d(size.x * ((i % cells + 0.5) / cells - 0.5), 0,
                                               size.z * ((i / cells + 0.5) / cells - 0.5));
            double nearest = size.length();
            for (int d = 0; d < directions; ++d) {
                const double angle = 2 * pi * (d + 0.5) / directions;
                if (const auto wall = first_wall(place, {std::cos(angle), 0, std::sin(angle)}))
                    nearest = std::min(nearest, wall->distance);
            }
            if (nearest > farthest && is_clear(place, size)) {
                farthest = nearest;
                best = place;
            }
        }
        return best;
    }

    /// Returns the camera's direction at a place: where walls are far, with a preference for left and ahead.
    Vec3d viewing_direction(const Vec3d& place) const {
        const Vec3d usual(-0.57, -0.12, -0.81);
        const auto depth = [&](const Vec3d& ahead) {
            return distance_to_wall(place, ahead) + distance_to_wall(place, -ahead);
        };
        Vec3d best = usual;
        double deepest = 1.25 * depth(usual);
        for (int quarter = 1; quarter < 4; ++quarter) {
            const double c = std::cos(quarter * pi / 2), s = std::sin(quarter * pi / 2);
            const Vec3d turned(c * usual.x + s * usual.z, usual.y, c * usual.z - s * usual.x);
            if (const double here = depth(turned); here > deepest) {
                deepest = here;
                best = turned;
            }
        }
        return best;
    }

    static double room_size(const ClosedPiece& piece, const AffineMap& place) {
        const Vec3f size = piece.bounds.upper - piece.bounds.lower;
        return place.direction(Vec3d(size)).length();
    }

    /// If one room encloses everything, places the camera in it, and adds a lamp if nothing emits light.
    void enter_room() {
        if (!room_) return;
        const Bounds room = room_bounds();
        constexpr float wall = 0.1f;  // Of the room's size.
        for (int axis = 0; axis < 3; ++axis) {
            const float most = wall * (room.upper[axis] - room.lower[axis]);
            if (room.lower[axis] - bounds.lower[axis] > most || bounds.upper[axis] - room.upper[axis] > most)
                return;
        }
        const std::optional<Vec3d> place = standing_place();
        if (!place) return;
        is_in_room = true;
        const Vec3d size(room.upper - room.lower);
        const double winding = winding_of_walls(*place);
        if (scene.finds_camera) {
            scene.finds_camera = false;
            const Vec3d ahead = viewing_direction(*place);
            const double through_opening = 0.4 * std::min(size.x, size.z);
            const auto free_way = [&](const Vec3d& direction) {
                const double distance = distance_to_wall(*place, direction);
                return distance > 0 ? distance : through_opening;
            };
            const double back = 0.85 * free_way(-ahead), front = free_way(ahead);
            scene.camera.position = Vec3f(*place - ahead * back);
            scene.camera.target = Vec3f(*place + ahead * (0.5 * front));
            scene.camera.vertical_fov = static_cast<float>(60 * pi / 180);
        }
        constexpr double closed = -0.999;  // Winding number: almost no light enters through openings.
        if (winding > closed) return;
        if (!scene.lamps.empty() || emits_light_) return;
        SceneLamp lamp;
        lamp.name = "ceiling_lamp";
        lamp.position = Vec3f(*place + Vec3d(0, 0.4 * size.y, 0));
        lamp.colour = Rgb(0.35f);  // Indirect light adds at least as much again.
        lamp.fade_distance = static_cast<float>(0.9 * size.y);
        lamp.area = LampArea{Vec3f(static_cast<float>(0.1 * size.x), 0, 0),
                             Vec3f(0, 0, static_cast<float>(0.1 * size.z))};
        scene.lamps.push_back(lamp);
        warnings.push_back(
            fmt::format("nothing emits light in the closed room {}: a lamp is added below its ceiling",
                        scene.entities[room_->entity].name));
    }

    /// Scales the lights of files, whose units are unrelated to the picture's exposure. Does so if they are
    /// too bright, or if nothing else lights the models.
    void expose_lights() {
        if (!has_sky || lights_.empty()) return;
        constexpr double white = 0.8;  // Albedo of a sphere amid the models.
        double radiance = 0;
        for (const SceneLamp& lamp : scene.lamps)
            radiance +=
                white * double(luminance(lamp.colour)) * lamp_light(lamp, Vec3d(bounds.centre())).share;
        if (!(radiance > 1 || (is_in_room && radiance > 0))) return;
        for (SceneLamp& lamp : scene.lamps) lamp.colour /= static_cast<float>(radiance);
        warnings.push_back(
            fmt::format("the lights of the files are scaled by {:.2g}, so that they light a white sphere "
                        "amid the models to 1",
                        1 / radiance));
    }

    /// The first intersection of a ray with the room.
    struct Wall {
        double distance = INFINITY;  ///< In units of the direction's length.
        Vec3d normal{0, 0, 0};       ///< Unit length.
    };
    std::optional<Wall> first_wall(const Vec3d& from, const Vec3d& direction) const {
        Wall nearest;
        for (const std::array<Vec3d, 3>& wall : room_->walls) {
            const Vec3d a = wall[0] - from, b = wall[1] - from, c = wall[2] - from,
                        across = (b - a).cross(c - a);
            // The ray passes all edges on the same side.
            const double u = direction.dot(a.cross(b)), v = direction.dot(b.cross(c)),
                         w = direction.dot(c.cross(a)), normal = direction.dot(across);
            if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) continue;
            const double distance = normal != 0 ? a.dot(across) / normal : -1;
            if (distance > 0 && distance < nearest.distance) nearest = {distance, across.normalized()};
        }
        return std::isfinite(nearest.distance) ? std::optional(nearest) : std::nullopt;
    }

    /// Returns the distance to the first wall; 0 if there is none.
    double distance_to_wall(const Vec3d& from, const Vec3d& direction) const {
        const std::optional<Wall> wall = first_wall(from, direction);
        return wall ? wall->distance : 0;
    }

    void share_vertices(double area) {
        constexpr std::uint32_t fewest = 500, fewest_samples = 400;
        const auto entities = static_cast<std::uint32_t>(scene.entities.size());
        for (std::size_t e = 0; e < scene.entities.size(); ++e) {
            Entity& entity = scene.entities[e];
            const double share = area > 0 ? areas_[e] / area : 1,
                         wanted = share * wanted_.vertices / std::max<std::size_t>(1, instances_[e]);
            // Round numbers are easier to read.
            entity.fine_vertices = std::max(fewest, static_cast<std::uint32_t>(wanted / 100) * 100);
            // With many entities, each field gets fewer samples.
            const std::uint32_t fields = std::max(1u, entities / 2);
            entity.planar_samples = std::max(fewest_samples, entity.planar_samples / fields);
            entity.spherical_samples = std::max(fewest_samples, entity.spherical_samples / fields);
        }
    }

    void set_camera() {
        scene.finds_camera = !camera_;
        if (!camera_) return;
        const ModelCamera& camera = camera_->camera;
        const AffineMap world = world_of(camera_->file);
        const Vec3d position = world.point(Vec3d(camera.position)),
                    ahead = world.direction(Vec3d(camera.direction));
        // At the depth of the models' centre.
        const double distance = std::max(1e-3 * double(bounds.radius()),
                                         (Vec3d(bounds.centre()) - position).dot(ahead.normalized()));
        scene.camera.position = Vec3f(position);
        scene.camera.target = Vec3f(position + ahead.normalized() * distance);
        if (camera.vertical_fov) scene.camera.vertical_fov = *camera.vertical_fov;
    }

    /// Returns a light as a lamp of the scene; lengths are multiplied by `scale`.
    SceneLamp placed_lamp(const ModelLight& light, const AffineMap& world, double scale) {
        SceneLamp lamp = scene_lamp(light, world, scale);
        lamp.name = unique_name(file_name(light.name, "light"), lamp_names_);
        if (light.is_physical)
            make_physical(light, scale, lamp);
        else
            has_sky = false;
        return lamp;
    }

    /// Converts physical units, intensity or irradiance, to POV-Ray's colours. The result does not depend on
    /// the scale.
    void make_physical(const ModelLight& light, double scale, Lamp& lamp) const {
        if (light.kind == ModelLight::Kind::parallel) {
            lamp.colour /= static_cast<float>(pi);
            // In front of all models.
            const Vec3f ahead = (lamp.target - lamp.position).normalized();
            lamp.target = bounds.centre();
            lamp.position = lamp.target - ahead * (2 * bounds.radius());
            return;
        }
        // Much smaller than any distance to a surface: there, 2 / (1 + (d / f)^2) is about 2 f^2 / d^2.
        lamp.fade_distance = static_cast<float>(1e-3 * scale);
        lamp.fade_power = 2;
        lamp.colour *= static_cast<float>(scale * scale / (2 * pi * squared(lamp.fade_distance)));
    }

    const SceneImport& wanted_;
    const Progress& progress_;
    double scale_ = 1;  ///< From the file's unit to metres.
    std::vector<File> files_;
    std::vector<PlacedLight> lights_;  ///< Of all files.
    bool emits_light_ = false;         ///< A material of some file emits light.
    /// The room around the models or the camera.
    struct Room {
        std::size_t entity;
        double size;                              ///< [m]
        std::vector<std::array<Vec3d, 3>> walls;  ///< Triangles in the scene's coordinates, facing inwards.
    };
    std::optional<Room> room_;  ///< The largest room.
    static constexpr std::size_t most_room_triangles = 20000;
    std::vector<std::size_t> triangle_counts_;  ///< By entity.
    std::size_t triangles_ = 0;                 ///< Of all instances.
    std::set<std::string> lamp_names_;
    std::vector<Placed> placed_;
    std::set<std::string> names_;
    std::vector<PossibleRooms> possible_rooms_;  ///< By entity, and
    std::vector<Mesh> faces_;                    ///< the file's triangles, for small meshes.
    std::vector<Extent> extents_;                ///< By entity, and
    std::vector<double> areas_;                  ///< of all its instances, in the scene. [m^2]
    std::vector<std::size_t> instances_;
    std::optional<PlacedCamera> camera_;
};

/// Returns the floor as OBJ: a square below the models, a wider one around it, and the ground up to the
/// horizon in rings of doubling size. The squares have two and eight triangles; bakes subdivide them.
std::string floor_text(const Bounds& bounds) {
    constexpr int rings = 8, cells = 12;   // Cells along a side.
    constexpr float near = 0.8f, far = 2;  // Half widths, relative to the models' longest side.
    const Vec3f size = bounds.upper - bounds.lower, middle = bounds.centre();
    const float longest = std::max({size.x, size.z, size.y}), half = far * longest;
    const auto vertex = [&](float x, float z) {
        return fmt::format("v {} {} {}\n", middle.x + x, bounds.lower.y, middle.z + z);
    };
    std::string text = "o floor\n";
    for (const float reach : {near * longest, half})
        for (const auto& [x, z] : {std::pair(-1, -1), std::pair(-1, 1), std::pair(1, 1), std::pair(1, -1)})
            text += vertex(float(x) * reach, float(z) * reach);
    text += "f 1 2 3\nf 1 3 4\no apron\n";
    for (int side = 0; side < 4; ++side) {
        const int a = 1 + side, b = 1 + (side + 1) % 4;
        text += fmt::format("f {0} {2} {3}\nf {0} {3} {1}\n", a, b, a + 4, b + 4);
    }
    text += "o ground\n";
    constexpr int around = 4 * cells;
    for (int ring = 0; ring < rings; ++ring)
        for (int i = 0; i < around; ++i) {
            const float reach = half * static_cast<float>(1 << ring),
                        along = reach * (2 * static_cast<float>(i % cells) / cells - 1);
            const std::array<std::pair<float, float>, 4> sides{
                {{-reach, along}, {along, reach}, {reach, -along}, {-along, -reach}}};
            const auto& [x, z] = sides[static_cast<std::size_t>(i / cells)];
            text += vertex(x, z);
        }
    for (int ring = 0; ring + 1 < rings; ++ring)
        for (int i = 0; i < around; ++i) {
            const int inner = 9 + ring * around + i, next = 9 + ring * around + (i + 1) % around;
            text += fmt::format("f {0} {1} {2}\nf {0} {2} {3}\n", inner, inner + around, next + around, next);
        }
    return text;
}

/// Returns the albedo, by channel, of a floor that is as bright as the environment just below the horizon.
Rgb floor_albedo(const Environment& light) {
    constexpr double lowest = -0.35;  // Sine of the lowest elevation that is compared.
    constexpr float darkest = 0.05f, brightest = 0.8f;
    const LatLongImage& image = light.image;
    Vec3d irradiance(0, 0, 0), below(0, 0, 0);
    double solid_angle = 0;
    for (int row = 0; row < image.height; ++row) {
        const double up = lat_long_direction(0.5, (row + 0.5) / image.height).y,
                     pixel = lat_long_pixel_solid_angle(row, image.width, image.height);
        for (int column = 0; column < image.width; ++column) {
            const Vec3d radiance(
                image.pixels[std::size_t(row) * std::size_t(image.width) + std::size_t(column)]);
            if (up > 0) irradiance += radiance * (up * pixel);
            if (up < 0 && up > lowest) {
                below += radiance * pixel;
                solid_angle += pixel;
            }
        }
    }
    for (const SunDisc& sun : light.suns)
        irradiance += Vec3d(sun.irradiance) * std::max(0.0, Vec3d(sun.direction).y);
    Rgb albedo(0.5f);
    for (int c = 0; c < 3; ++c)
        if (irradiance[c] > 0 && solid_angle > 0)
            albedo[c] = std::clamp(static_cast<float>(below[c] / solid_angle * pi / irradiance[c]), darkest,
                                   brightest);
    return albedo;
}

/// Adds the entities of the floor; their file is in the scene's directory.
void add_floor(const std::filesystem::path& folder, const Rgb& albedo, Scene& scene) {
    std::set<std::string> taken;
    for (const Entity& entity : scene.entities) taken.insert(entity.name);
    SceneMaterial matt;
    matt.diffuse = albedo;
    scene.materials["floor"] = matt;
    for (const char* part : {"floor", "apron", "ground"}) {
        Entity entity;
        entity.name = unique_name(part, taken);
        entity.mesh = folder / "floor.obj";
        entity.part = part;
        entity.material = "floor";
        entity.coarse_triangles = RenderSettings().exact_triangles;
        if (std::string_view(part) == "ground") entity.fine_vertices = 1;  // Not subdivided.
        Instance instance;
        instance.entity = scene.entities.size();
        scene.entities.push_back(entity);
        scene.instances.push_back(instance);
    }
}

}  // namespace

AffineMap upright_frame(bool z_up, bool left_handed) {
    AffineMap frame;
    if (z_up) frame.axes = {Vec3d(1, 0, 0), Vec3d(0, 0, -1), Vec3d(0, 1, 0)};
    if (left_handed) frame.axes[z_up ? 1 : 2] *= -1;
    return frame;
}

SceneLamp scene_lamp(const ModelLight& light, const AffineMap& world, double scale) {
    SceneLamp lamp;
    lamp.kind = std::array{LampKind::point, LampKind::spot, LampKind::cylinder,
                           LampKind::parallel}[std::size_t(light.kind)];
    lamp.position = Vec3f(world.point(Vec3d(light.position)));
    lamp.target = Vec3f(world.point(Vec3d(light.target)));
    lamp.colour = light.colour;
    lamp.radius = light.radius;
    lamp.falloff = light.falloff;
    if (light.kind == ModelLight::Kind::cylinder) {
        lamp.radius *= static_cast<float>(scale);
        lamp.falloff *= static_cast<float>(scale);
    }
    lamp.tightness = light.tightness;
    lamp.shadowless = light.shadowless;
    if (light.fade_distance > 0 && light.fade_power > 0) {
        lamp.fade_distance = light.fade_distance * static_cast<float>(scale);
        lamp.fade_power = light.fade_power;
    }
    if (light.area) {
        const ModelLight::Area& area = *light.area;
        lamp.area = {Vec3f(world.direction(Vec3d(area.across))),
                     Vec3f(world.direction(Vec3d(area.along))),
                     area.columns,
                     area.rows,
                     area.circular,
                     area.orient,
                     area.illumination};
    }
    return lamp;
}

Result<ImportedScene> scene_of_models(std::span<const std::filesystem::path> files,
                                      const std::filesystem::path& folder, const SceneImport& wanted,
                                      const Progress& progress) {
    Importer importer(wanted, progress);
    for (const std::filesystem::path& file : files) HF_TRY_DONE(importer.add(file));
    HF_TRY_DONE(importer.place());
    ImportedScene imported{std::move(importer.scene), {}, importer.warnings, importer.bounds};
    Scene& scene = imported.scene;
    EnvironmentDescription& environment = scene.environment;
    constexpr float floor_grey = 0.3f;
    if (!wanted.environment.empty()) {
        environment.image = wanted.environment;
        environment.exposure.reset();
    } else if (importer.has_sky && !wanted.no_environment) {
        environment.sky = AnalyticSky();
        environment.sky->turbidity = 3;
        environment.sky->sun_elevation = static_cast<float>(40 * pi / 180);
        if (wanted.floor) environment.sky->ground = Rgb(floor_grey);
        environment.exposure.reset();
    }
    if (wanted.floor && importer.is_in_room) {
        imported.warnings.emplace_back("the models stand in a room, which has a floor; --floor adds none");
    } else if (wanted.floor) {
        imported.floor_obj = floor_text(importer.bounds);
        Rgb albedo(floor_grey);
        if (!environment.image.empty()) {
            HF_TRY(const Environment light, described_environment(scene, imported.warnings));
            albedo = floor_albedo(light);
        }
        add_floor(folder, albedo, scene);
    }
    return imported;
}

}  // namespace haarfield
