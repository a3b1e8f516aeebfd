#include "fields/field/field_grids.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <sstream>

#include "fields/base/exception_message.h"
#include "fields/field/ambient_visibility.h"
#include "fields/field/field_transfer.h"
#include "fields/file/guarded_read.h"
#include "fields/vdb/vdb_archive.h"

namespace haarfield {
namespace {

namespace vdb = openvdb;

static_assert(std::endian::native == std::endian::little, "grids hold the tables as they lie in memory");

// Names of grids and metadata: see README.md.
constexpr const char *planar_grid = "planar_handles", *spherical_grid = "spherical_handles",
                     *local_grid = "local_handles", *cubemap_grid = "cubemaps", *face_grid = "faces",
                     *ambient_grid = "ambient_visibility", *direction_grid = "open_direction";
constexpr std::string_view prefix = "haarfield_", optional_prefix = "derived_";
constexpr const char *version_name = "haarfield_version", *hash_name = "haarfield_hash",
                     *field_name = "haarfield_field";

/// Values of a grid of nodes: 4 MiB, so that reading needs little memory besides the field's own.
constexpr std::uint64_t node_grid_values = std::uint64_t{1} << 20;
constexpr std::int32_t unoccluded = -1;  // background of the grids of handles

std::string node_grid(std::uint64_t index) {
    return fmt::format("nodes_{}", index);
}

std::uint64_t node_grids(std::uint64_t node_bytes) {
    return (node_bytes + 4 * node_grid_values - 1) / (4 * node_grid_values);
}

/// Returns the voxel of value i: the order in which OpenVDB's iterators visit the voxels of a full tree.
vdb::Coord linear_voxel(std::uint64_t i) {
    const auto bits = [i](unsigned first, unsigned count, unsigned to) {
        return static_cast<int>((i >> first & ((1u << count) - 1)) << to);
    };
    return {bits(6, 3, 0) | bits(17, 4, 3) | bits(31, 5, 7), bits(3, 3, 0) | bits(13, 4, 3) | bits(26, 5, 7),
            bits(0, 3, 0) | bits(9, 4, 3) | bits(21, 5, 7)};
}

vdb::Coord coord(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
    return {static_cast<int>(x), static_cast<int>(y), static_cast<int>(z)};
}

/// Returns the voxels of samples by number.
auto planar_voxels(const PlanarSampler& sampler) {
    return [angles = std::uint64_t(sampler.angles)](std::uint64_t i) {
        return coord(i / angles, i % angles, 0);
    };
}

auto spherical_voxels(const SphericalSampler& sampler) {
    return [polar = std::uint64_t(sampler.polar), azimuths = std::uint64_t(sampler.azimuths)](
               std::uint64_t i) { return coord(i / azimuths / polar, i / azimuths % polar, i % azimuths); };
}

/// The hash of a grid.
class GridHash {
public:
    GridHash() : state_(XXH3_createState(), XXH3_freeState) { XXH3_128bits_reset(state_.get()); }

    void add(std::string_view bytes) { XXH3_128bits_update(state_.get(), bytes.data(), bytes.size()); }
    /// Adds haarfield's metadata but for the hashes themselves, in order of names.
    void add_metadata(const vdb::GridBase& grid) {
        for (auto meta = grid.beginMeta(); meta != grid.endMeta(); ++meta) {
            const std::string& name = meta->first;
            if (!name.starts_with(prefix) || name == hash_name || name == field_name) continue;
            std::ostringstream value(std::ios::binary);
            meta->second->write(value);
            add(name + '\n' + meta->second->typeName() + '\n' + value.str());
        }
    }
    std::string hex() const {
        const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
        return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
    }

private:
    std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
};

template <class T>
std::string_view bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::string hash_of(const vdb::GridBase& grid, std::string_view values) {
    GridHash hash;
    hash.add(values);
    hash.add_metadata(grid);
    return hash.hex();
}

/// Returns the hash of a field from those of its grids.
std::string field_hash(std::vector<std::pair<std::string, std::string>> hash_by_grid) {
    std::ranges::sort(hash_by_grid);
    GridHash hash;
    for (const auto& [name, of_grid] : hash_by_grid) hash.add(name + ' ' + of_grid + '\n');
    return hash.hex();
}

/// The coordinates and the value of an active voxel.
template <class Value>
struct ActiveVoxel {
    std::array<std::int32_t, 3> at;
    Value value;
};

/// Returns the active voxels of a grid, in order of x, y, z. Throws if there are more than `most`.
template <class Grid>
auto active_voxels(const Grid& grid, std::uint64_t most) {
    using Voxel = ActiveVoxel<typename Grid::ValueType>;
    std::vector<Voxel> voxels;
    if (grid.activeVoxelCount() > most) throw std::runtime_error("more active voxels than it had");
    for (auto value = grid.cbeginValueOn(); value; ++value)
        for (const vdb::Coord& at : value.getBoundingBox())
            voxels.push_back({{at.x(), at.y(), at.z()}, value.getValue()});
    std::ranges::sort(voxels, {}, &Voxel::at);
    return voxels;
}

// ---- Writing ----

template <class T>
void set(vdb::GridBase& grid, const char* name, const T& value) {
    grid.insertMeta(std::string(prefix) + name, vdb::TypedMetadata<T>(value));
}

void set(vdb::GridBase& grid, const char* name, const Vec3f& value) {
    set(grid, name, vdb::Vec3s(value.x, value.y, value.z));
}

void set_error(vdb::GridBase& grid, const SamplerError& error) {
    set(grid, "error", error.relative);
    set(grid, "error_bands", fmt::format("{}", fmt::join(error.band, " ")));
}

/// Names a grid, states the number of its values, and computes its hash. All other metadata must be set.
void finish(vdb::GridBase& grid, const std::string& name, const char* schema, std::uint64_t count,
            std::string_view values) {
    grid.setName(name);
    set(grid, "version", vdb::Int32(field_format_version));
    set(grid, "schema", std::string(schema));
    set(grid, "count", static_cast<vdb::Int64>(count));
    set(grid, "hash", hash_of(grid, values));
}

/// Returns the factor by which voxels must grow so that OpenVDB accepts their transform. It rejects volumes
/// below about 3e-15 m^3. Viewers therefore show entities of a few tenths of a millimetre too large.
double needed_growth(const vdb::Vec3d& voxel) {
    constexpr double smallest = 1e-14;
    const double volume = voxel.x() * voxel.y() * voxel.z();
    return volume < smallest ? std::cbrt(smallest / volume) : 1;
}

/// Places a grid of a table over the bounding box of the entity, so that a viewer that shows all grids frames
/// the entity. last: the largest coordinates of its voxels.
void place_over(vdb::GridBase& grid, const Bounds& bounds, const vdb::Coord& last) {
    const double shortest = std::max(1e-3 * bounds.radius(), 1e-6);  // gives flat entities a volume
    vdb::Vec3d scale, centre;
    for (int k = 0; k < 3; ++k) {
        const double extent = std::max(double(bounds.upper[k]) - bounds.lower[k], shortest);
        scale[k] = extent / (last[k] + 1);
    }
    scale *= needed_growth(scale);
    for (int k = 0; k < 3; ++k) centre[k] = bounds.lower[k] + 0.5 * scale[k];
    grid.setTransform(std::make_shared<vdb::math::Transform>(
        std::make_shared<vdb::math::ScaleTranslateMap>(scale, centre)));
}

/// Returns a grid of handles whose voxels are those of `voxel`; unoccluded samples are inactive.
template <class Voxel>
vdb::Int32Grid::Ptr handle_grid(const std::vector<std::int32_t>& handles, std::int32_t open,
                                const Bounds& bounds, const Voxel& voxel, std::vector<std::int32_t>& values) {
    const auto grid = vdb::Int32Grid::create(unoccluded);
    auto accessor = grid->getAccessor();
    vdb::Coord last(0);
    values.resize(handles.size());
    for (std::size_t i = 0; i < handles.size(); ++i) {
        const vdb::Coord at = voxel(i);
        last.maxComponent(at);
        values[i] = handles[i] == open ? unoccluded : handles[i];
        if (values[i] != unoccluded) accessor.setValueOn(at, values[i]);
    }
    place_over(*grid, bounds, last);
    return grid;
}

/// Returns a grid with all values in linear order.
vdb::Int32Grid::Ptr linear_grid(std::span<const std::int32_t> values, const Bounds& bounds) {
    using Leaf = vdb::Int32Tree::LeafNodeType;
    const auto grid = vdb::Int32Grid::create(0);
    vdb::Coord last(0);
    for (std::size_t first = 0; first < values.size(); first += Leaf::SIZE) {
        Leaf& leaf = *grid->tree().touchLeaf(linear_voxel(first));
        const std::size_t count = std::min<std::size_t>(Leaf::SIZE, values.size() - first);
        for (std::size_t i = 0; i < count; ++i)
            leaf.setValueOn(static_cast<vdb::Index>(i), values[first + i]);
        last.maxComponent(leaf.origin() + vdb::Coord(Leaf::DIM - 1));
    }
    place_over(*grid, bounds, last);
    return grid;
}

/// The 4-byte words of a table.
template <class T>
std::span<const std::int32_t> words_of(const SharedArray<T>& table) {
    static_assert(sizeof(T) % sizeof(std::int32_t) == 0 && alignof(T) == alignof(std::int32_t));
    return {reinterpret_cast<const std::int32_t*>(table.data()),
            table.size() * sizeof(T) / sizeof(std::int32_t)};
}

void add_linear(vdb::GridPtrVec& grids, vdb::Int32Grid::Ptr grid, const std::string& name, const char* schema,
                std::span<const std::int32_t> values) {
    finish(*grid, name, schema, values.size(),
           {reinterpret_cast<const char*>(values.data()), values.size_bytes()});
    grids.push_back(std::move(grid));
}

/// Adds the grids of the pool. The first has the metadata of the field.
void add_pool(vdb::GridPtrVec& grids, const VisibilityField& field) {
    const auto cubemaps = linear_grid(words_of(field.pool.cubemaps), field.bounds);
    set(*cubemaps, "entity", field.entity);
    set(*cubemaps, "key", field.keys.whole.hex());
    set(*cubemaps, "surroundings", field.keys.surroundings.hex());
    set(*cubemaps, "face_size", field.settings.face_size);
    set(*cubemaps, "coefficients", field.settings.coefficients);
    set(*cubemaps, "relative_l2_error", field.settings.relative_l2_error);
    set(*cubemaps, "planar_samples", vdb::Int64(field.settings.planar_samples));
    set(*cubemaps, "spherical_samples", vdb::Int64(field.settings.spherical_samples));
    set(*cubemaps, "lower", field.bounds.lower);
    set(*cubemaps, "upper", field.bounds.upper);
    set(*cubemaps, "node_bytes", static_cast<vdb::Int64>(field.pool.node_bytes.size()));
    add_linear(grids, cubemaps, cubemap_grid, "linear; 6 per cubemap: faces +x -x +y -y +z -z",
               words_of(field.pool.cubemaps));
    add_linear(grids, linear_grid(words_of(field.pool.faces), field.bounds), face_grid,
               "linear; 3 per face: first byte of its nodes (low, high), number of nodes and mean",
               words_of(field.pool.faces));
    const std::size_t bytes = field.pool.node_bytes.size();
    std::vector<std::int32_t> words;
    for (std::uint64_t grid = 0; grid < node_grids(bytes); ++grid) {
        const std::size_t first = 4 * node_grid_values * grid,
                          count = std::min<std::size_t>(4 * node_grid_values, bytes - first);
        words.assign((count + 3) / 4, 0);
        std::memcpy(words.data(), field.pool.node_bytes.data() + first, count);
        add_linear(grids, linear_grid(words, field.bounds), node_grid(grid),
                   "linear; 4 bytes of nodes per value, lowest first", words);
    }
}

void add_handles(vdb::GridPtrVec& grids, const VisibilityField& field) {
    const std::int32_t open = unoccluded_cubemap(field.pool);
    std::vector<std::int32_t> values;
    const PlanarSampler& planar = field.planar;
    auto grid = handle_grid(field.planar_handles, open, field.bounds, planar_voxels(planar), values);
    set(*grid, "centre", planar.centre);
    set(*grid, "rings", planar.rings);
    set(*grid, "angles", planar.angles);
    set(*grid, "outer_radius", planar.outer_radius);
    set(*grid, "growth", planar.growth);
    set_error(*grid, field.error.planar);
    finish(*grid, planar_grid, "ring, angle, 0: cubemap", values.size(), bytes_of(values));
    grids.push_back(grid);

    const SphericalSampler& spherical = field.spherical;
    grid = handle_grid(field.spherical_handles, open, field.bounds, spherical_voxels(spherical), values);
    set(*grid, "centre", spherical.centre);
    set(*grid, "shells", spherical.shells);
    set(*grid, "polar", spherical.polar);
    set(*grid, "azimuths", spherical.azimuths);
    set(*grid, "outer_radius", spherical.outer_radius);
    set(*grid, "growth", spherical.growth);
    set_error(*grid, field.error.spherical);
    finish(*grid, spherical_grid, "shell, row, azimuth: cubemap", values.size(), bytes_of(values));
    grids.push_back(grid);

    grid = handle_grid(field.local_handles, open, field.bounds, linear_voxel, values);
    finish(*grid, local_grid, "linear; vertex: cubemap", values.size(), bytes_of(values));
    grids.push_back(grid);
}

/// Minimum blocked fraction of directions of an active voxel. Viewers then show a hull that follows the
/// entity.
constexpr float least_occlusion = 0.1f;

template <class Grid>
void finish_active(Grid& grid, const char* name, const char* schema) {
    const auto voxels = active_voxels(grid, std::numeric_limits<std::uint64_t>::max());
    finish(grid, name, schema, voxels.size(), bytes_of(voxels));
}

/// Adds the two grids for viewers.
void add_ambient(vdb::GridPtrVec& grids, const VisibilityField& field) {
    const AmbientVisibility volume = ambient_visibility(field);
    const auto open = vdb::FloatGrid::create(1.0f);
    const auto direction = vdb::Vec3SGrid::create(vdb::Vec3s(0.0f));
    open->setGridClass(vdb::GRID_FOG_VOLUME);
    direction->setVectorType(vdb::VEC_CONTRAVARIANT_RELATIVE);  // vectors rotate with the grid
    const auto transform = vdb::math::Transform::createLinearTransform(
        double(volume.voxel_size) * needed_growth(vdb::Vec3d(volume.voxel_size)));
    transform->postTranslate(vdb::Vec3d(volume.origin.x, volume.origin.y, volume.origin.z));
    open->setTransform(transform);
    direction->setTransform(transform->copy());
    auto open_voxels = open->getAccessor();
    auto direction_voxels = direction->getAccessor();
    std::size_t i = 0;
    for (std::int32_t x = 0; x < volume.size[0]; ++x)
        for (std::int32_t y = 0; y < volume.size[1]; ++y)
            for (std::int32_t z = 0; z < volume.size[2]; ++z, ++i) {
                if (!(volume.values[i] < 1 - least_occlusion)) continue;
                const Vec3f& mean = volume.directions[i];
                open_voxels.setValueOn(vdb::Coord(x, y, z), volume.values[i]);
                direction_voxels.setValueOn(vdb::Coord(x, y, z), vdb::Vec3s(mean.x, mean.y, mean.z));
            }
    finish_active(*open, ambient_grid, "x, y, z: fraction of all directions that is unoccluded");
    finish_active(*direction, direction_grid, "x, y, z: mean of all directions that are unoccluded");
    grids.push_back(open);
    grids.push_back(direction);
}

// ---- Reading ----

Error grid_error(const std::string& name, const std::string& what) {
    return {"", fmt::format("grid \"{}\": {}", name, what)};
}

/// Reads metadata of a grid. After a missing or wrong one, all further reads fail.
class MetadataSource {
public:
    explicit MetadataSource(const vdb::GridBase& grid) : grid_(grid) {}

    template <class T>
    T value(const char* name) {
        const auto meta = grid_.getMetadata<vdb::TypedMetadata<T>>(std::string(prefix) + name);
        if (!meta && missing_.empty()) missing_ = name;
        return meta ? meta->value() : T{};
    }
    Vec3f vector(const char* name) {
        const auto v = value<vdb::Vec3s>(name);
        return {v.x(), v.y(), v.z()};
    }
    std::uint64_t count(const char* name) {
        const auto number = value<vdb::Int64>(name);
        if (number < 0 && missing_.empty()) missing_ = name;
        return static_cast<std::uint64_t>(std::max<vdb::Int64>(number, 0));
    }
    ContentHash hash(const char* name) {
        const auto hex = value<std::string>(name);
        ContentHash hash;
        const bool good = hex.size() == 32 && parse(hex.substr(0, 16), hash.high, 16) &&
                          parse(hex.substr(16), hash.low, 16);
        if (!good && missing_.empty()) missing_ = name;
        return hash;
    }
    SamplerError error() {
        SamplerError error;
        error.relative = value<float>("error");
        std::istringstream words(value<std::string>("error_bands"));
        for (float& band : error.band) {
            std::string word;
            words >> word;
            const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), band);
            if ((failed != std::errc() || end != word.data() + word.size()) && missing_.empty())
                missing_ = "error_bands";
        }
        return error;
    }

    Result<Done> result() const {
        if (missing_.empty()) return Done{};
        return grid_error(grid_.getName(),
                          fmt::format("metadata {}{} is missing or invalid", prefix, missing_));
    }

private:
    static bool parse(const std::string& text, std::uint64_t& value, int base) {
        const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value, base);
        return failed == std::errc() && end == text.data() + text.size();
    }

    const vdb::GridBase& grid_;
    std::string missing_;
};

/// The grids of a file.
class FieldInput {
public:
    explicit FieldInput(std::string_view bytes) : input_(bytes) {}

    /// Verifies which grids there are, and reads their metadata.
    Result<FieldHead> head() {
        HF_TRY_DONE(check_version());
        FieldHead head;
        HF_TRY_DONE(read_pool_head(head));
        HF_TRY_DONE(read_sampler_heads(head));
        HF_TRY_DONE(check_names(head));
        HF_TRY_DONE(check_hashes());
        if (input_.trailing_bytes() > 0)
            return Error{"", fmt::format("has {} bytes after its last grid", input_.trailing_bytes())};
        return head;
    }

    /// Reads all grids, and writes the tables.
    Result<Done> write_tables(const FieldHead& head, ByteSink& answer) {
        const FieldCounts& counts = head.counts;
        {
            QuadtreePool pool;
            HF_TRY(pool.cubemaps, table<PackedCubemap>(cubemap_grid, counts.cubemaps));
            HF_TRY(pool.faces, table<PackedFace>(face_grid, counts.faces));
            write_field_table(std::span(pool.cubemaps.begin(), pool.cubemaps.end()), answer);
            write_field_table(std::span(pool.faces.begin(), pool.faces.end()), answer);
            open_ = unoccluded_cubemap(pool);
        }
        for (std::uint64_t grid = 0, left = counts.node_bytes; grid < node_grids(counts.node_bytes); ++grid) {
            const std::uint64_t bytes = std::min(left, 4 * node_grid_values);
            HF_TRY(const std::vector<std::int32_t> words, linear_values(node_grid(grid), (bytes + 3) / 4));
            answer.bytes(bytes_of(words).substr(0, bytes));
            left -= bytes;
        }
        write_field_padding(counts.node_bytes, answer);

        const VisibilityField& field = head.field;
        HF_TRY_DONE(write_handles(planar_grid, counts.planar, planar_voxels(field.planar), answer));
        HF_TRY_DONE(
            write_handles(spherical_grid, counts.spherical, spherical_voxels(field.spherical), answer));
        HF_TRY_DONE(write_handles(local_grid, counts.local, linear_voxel, answer));
        HF_TRY_DONE(check_active<vdb::FloatGrid>(ambient_grid));
        return check_active<vdb::Vec3SGrid>(direction_grid);
    }

private:
    Result<vdb::GridBase::Ptr> grid_head(const std::string& name) {
        const std::size_t i = input_.find(name);
        if (i == input_.grid_count()) return Error{"", fmt::format("grid \"{}\" is missing", name)};
        return input_.head(i);
    }

    Result<Done> check_version() {
        constexpr const char* old_pool = "quadtree_pool";  // of versions up to 6
        // Any grid identifies a field, so that the error for a field without others names a missing one.
        for (const std::string& name :
             {std::string(cubemap_grid), std::string(planar_grid), std::string(old_pool),
              std::string(face_grid), std::string(spherical_grid), std::string(local_grid), node_grid(0),
              std::string(ambient_grid), std::string(direction_grid)}) {
            const std::size_t i = input_.find(name);
            if (i == input_.grid_count()) continue;
            const auto version = input_.head(i)->getMetadata<vdb::Int32Metadata>(version_name);
            if (version && version->value() == field_format_version) return Done{};
            if (version)
                return Error{"",
                             fmt::format("is a field of version {}; expected version {}: compute it again",
                                         version->value(), field_format_version)};
        }
        return Error{"", "is an OpenVDB file, but not a visibility field"};
    }

    /// Divides a number of words by that of an element.
    static Result<Done> elements(const std::string& name, std::uint64_t words, std::uint64_t per_element,
                                 std::uint64_t& count) {
        count = words / per_element;
        if (words % per_element == 0) return Done{};
        return grid_error(name, fmt::format("{} values; expected a multiple of {}", words, per_element));
    }

    Result<Done> read_pool_head(FieldHead& head) {
        HF_TRY(const vdb::GridBase::Ptr grid, grid_head(cubemap_grid));
        MetadataSource source(*grid);
        VisibilityField& field = head.field;
        field.entity = source.value<std::string>("entity");
        field.keys = {source.hash("surroundings"), source.hash("key")};
        field.settings.face_size = source.value<vdb::Int32>("face_size");
        field.settings.coefficients = source.value<vdb::Int32>("coefficients");
        field.settings.relative_l2_error = source.value<float>("relative_l2_error");
        field.settings.planar_samples = static_cast<std::uint32_t>(source.count("planar_samples"));
        field.settings.spherical_samples = static_cast<std::uint32_t>(source.count("spherical_samples"));
        field.bounds = {source.vector("lower"), source.vector("upper")};
        head.counts.node_bytes = source.count("node_bytes");
        const std::uint64_t cubemap_words = source.count("count");
        HF_TRY_DONE(source.result());
        HF_TRY_DONE(elements(cubemap_grid, cubemap_words, sizeof(PackedCubemap) / 4, head.counts.cubemaps));

        HF_TRY(const vdb::GridBase::Ptr faces, grid_head(face_grid));
        MetadataSource of_faces(*faces);
        const std::uint64_t face_words = of_faces.count("count");
        HF_TRY_DONE(of_faces.result());
        return elements(face_grid, face_words, sizeof(PackedFace) / 4, head.counts.faces);
    }

    Result<Done> read_sampler_heads(FieldHead& head) {
        VisibilityField& field = head.field;
        HF_TRY(const vdb::GridBase::Ptr planar, grid_head(planar_grid));
        MetadataSource of_planar(*planar);
        field.planar = {of_planar.vector("centre"), of_planar.value<vdb::Int32>("rings"),
                        of_planar.value<vdb::Int32>("angles"), of_planar.value<float>("outer_radius"),
                        of_planar.value<float>("growth")};
        field.error.planar = of_planar.error();
        head.counts.planar = of_planar.count("count");
        HF_TRY_DONE(of_planar.result());

        HF_TRY(const vdb::GridBase::Ptr spherical, grid_head(spherical_grid));
        MetadataSource of_spherical(*spherical);
        field.spherical = {of_spherical.vector("centre"),
                           of_spherical.value<vdb::Int32>("shells"),
                           of_spherical.value<vdb::Int32>("polar"),
                           of_spherical.value<vdb::Int32>("azimuths"),
                           of_spherical.value<float>("outer_radius"),
                           of_spherical.value<float>("growth")};
        field.error.spherical = of_spherical.error();
        head.counts.spherical = of_spherical.count("count");
        HF_TRY_DONE(of_spherical.result());

        HF_TRY(const vdb::GridBase::Ptr local, grid_head(local_grid));
        MetadataSource of_local(*local);
        head.counts.local = of_local.count("count");
        HF_TRY_DONE(of_local.result());

        const auto product = [](std::initializer_list<std::int32_t> factors) {
            constexpr std::int32_t most = 1 << 20;
            std::uint64_t result = 1;
            for (const std::int32_t factor : factors)
                result *= factor < 1 || factor > most ? 0 : static_cast<std::uint64_t>(factor);
            return result;
        };
        const SphericalSampler& around = field.spherical;
        if (product({field.planar.rings, field.planar.angles}) != head.counts.planar)
            return grid_error(planar_grid, "the number of values is not rings x angles");
        if (product({around.shells, around.polar, around.azimuths}) != head.counts.spherical)
            return grid_error(spherical_grid, "the number of values is not shells x polar x azimuths");
        return Done{};
    }

    /// Verifies that there are the grids of a field, each once, and no others but optional ones.
    Result<Done> check_names(const FieldHead& head) {
        names_ = {planar_grid, spherical_grid, local_grid,    cubemap_grid,
                  face_grid,   ambient_grid,   direction_grid};
        if (node_grids(head.counts.node_bytes) > input_.grid_count())
            return Error{"", fmt::format("grid \"{}\" is missing", node_grid(input_.grid_count()))};
        for (std::uint64_t grid = 0; grid < node_grids(head.counts.node_bytes); ++grid)
            names_.push_back(node_grid(grid));
        for (const std::string& name : names_)
            if (input_.find(name) == input_.grid_count())
                return Error{"", fmt::format("grid \"{}\" is missing", name)};
        std::vector<std::string> sorted = names_;
        std::ranges::sort(sorted);
        std::vector<std::string> found;
        for (std::size_t i = 0; i < input_.grid_count(); ++i) {
            const std::string& name = input_.name(i);
            if (name.starts_with(optional_prefix)) continue;
            if (!std::ranges::binary_search(sorted, name))
                return grid_error(name, "does not belong to the field");
            found.push_back(name);
        }
        std::ranges::sort(found);
        if (const auto twice = std::ranges::adjacent_find(found); twice != found.end())
            return grid_error(*twice, "is in the file twice");
        return Done{};
    }

    /// Verifies that all grids belong to one field.
    Result<Done> check_hashes() {
        std::vector<std::pair<std::string, std::string>> hash_by_grid;
        std::vector<std::pair<std::string, std::string>> field_by_grid;
        for (const std::string& name : names_) {
            HF_TRY(const vdb::GridBase::Ptr grid, grid_head(name));
            MetadataSource source(*grid);
            if (source.value<vdb::Int32>("version") != field_format_version)
                return grid_error(name, fmt::format("expected version {}", field_format_version));
            hash_by_grid.emplace_back(name, source.value<std::string>("hash"));
            field_by_grid.emplace_back(name, source.value<std::string>("field"));
            HF_TRY_DONE(source.result());
        }
        const std::string hash = field_hash(hash_by_grid);
        for (const auto& [name, field] : field_by_grid)
            if (field != hash)
                return grid_error(name, "grids of several fields: the hash of the field is wrong");
        return Done{};
    }

    /// Reads a grid of the expected type.
    template <class Grid>
    Result<typename Grid::Ptr> read(const std::string& name) {
        try {
            const auto grid = vdb::gridPtrCast<Grid>(input_.grid(input_.find(name)));
            if (!grid) return grid_error(name, "another type of values than expected");
            return grid;
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& problem) {
            return grid_error(name, fmt::format("OpenVDB cannot read it: {}", exception_message(problem)));
        }
    }

    static Result<Done> check_hash(const vdb::GridBase& grid, std::string_view values) {
        const auto hash = grid.getMetadata<vdb::StringMetadata>(hash_name);
        if (hash && hash->value() == hash_of(grid, values)) return Done{};
        return grid_error(grid.getName(), "was changed or damaged: its hash is wrong");
    }

    static Error cropped(const std::string& name) {
        return grid_error(name, "has more or fewer voxels than values");
    }

    /// Tests whether the first voxels of a leaf are active.
    static bool are_on(const vdb::Int32Tree::LeafNodeType& leaf, vdb::Index count) {
        for (vdb::Index i = 0; i < count; ++i)
            if (!leaf.isValueOn(i)) return false;
        return true;
    }

    Result<std::vector<std::int32_t>> linear_values(const std::string& name, std::uint64_t count) {
        using Leaf = vdb::Int32Tree::LeafNodeType;
        HF_TRY(const vdb::Int32Grid::Ptr grid, read<vdb::Int32Grid>(name));
        if (grid->activeVoxelCount() != count) return cropped(name);
        std::vector<std::int32_t> values(count);
        const auto accessor = grid->getConstAccessor();
        for (std::uint64_t first = 0; first < count; first += Leaf::SIZE) {
            const vdb::Coord origin = linear_voxel(first);
            const auto size = static_cast<vdb::Index>(std::min<std::uint64_t>(Leaf::SIZE, count - first));
            if (const Leaf* const leaf = accessor.probeConstLeaf(origin)) {
                if (size == Leaf::SIZE ? !leaf->isValueMaskOn() : !are_on(*leaf, size)) return cropped(name);
                std::memcpy(&values[first], leaf->buffer().data(), size * sizeof values[0]);
            } else {  // a tile: other programs merge equal voxels
                if (!accessor.isValueOn(origin)) return cropped(name);
                std::fill_n(&values[first], size, accessor.getValue(origin));
            }
        }
        HF_TRY_DONE(check_hash(*grid, bytes_of(values)));
        return values;
    }

    template <class T>
    Result<std::vector<T>> table(const char* name, std::uint64_t count) {
        HF_TRY(const std::vector<std::int32_t> words, linear_values(name, count * (sizeof(T) / 4)));
        std::vector<T> elements(count);
        if (count > 0) std::memcpy(static_cast<void*>(elements.data()), words.data(), count * sizeof(T));
        return elements;
    }

    template <class Voxel>
    Result<Done> write_handles(const char* name, std::uint64_t count, const Voxel& voxel, ByteSink& answer) {
        HF_TRY(const vdb::Int32Grid::Ptr grid, read<vdb::Int32Grid>(name));
        if (count > std::uint64_t(std::numeric_limits<std::int32_t>::max())) return cropped(name);
        std::vector<std::int32_t> handles(count, unoccluded);
        const auto accessor = grid->getConstAccessor();
        std::uint64_t active = 0;
        bool has_open = false;
        for (std::uint64_t i = 0; i < count; ++i) {
            std::int32_t value = unoccluded;
            if (accessor.probeValue(voxel(i), value)) {
                ++active;
                handles[i] = value;
            }
            has_open = has_open || handles[i] == unoccluded;
        }
        if (active != grid->activeVoxelCount()) return cropped(name);
        HF_TRY_DONE(check_hash(*grid, bytes_of(handles)));
        if (has_open && open_ < 0)
            return grid_error(name, "has unoccluded samples, but the unoccluded cubemap is missing");
        std::ranges::replace(handles, unoccluded, open_);
        write_field_table(std::span<const std::int32_t>(handles), answer);
        return Done{};
    }

    template <class Grid>
    Result<Done> check_active(const std::string& name) {
        HF_TRY(const typename Grid::Ptr grid, read<Grid>(name));
        constexpr std::uint64_t most = 1 << 20;
        if (grid->activeVoxelCount() > most) return cropped(name);
        return check_hash(*grid, bytes_of(active_voxels(*grid, most)));
    }

    VdbInput input_;
    std::vector<std::string> names_;
    std::int32_t open_ = unoccluded;
};

constexpr std::string_view task_name = "field 1";  // incremented whenever field_transfer.h changes
constexpr std::string_view head_request = "head", whole_request = "whole";

Result<Done> read_task(std::string_view bytes, std::string_view details, ByteSink& answer) {
    return read_field_grids(bytes, details == head_request ? FieldContent::head : FieldContent::whole,
                            answer);
}

}  // namespace

Result<std::string> field_file_bytes(const VisibilityField& field) {
    initialize_openvdb();
    try {
        vdb::GridPtrVec grids;
        add_ambient(grids, field);
        add_handles(grids, field);
        add_pool(grids, field);
        std::vector<std::pair<std::string, std::string>> hash_by_grid;
        for (const auto& grid : grids)
            hash_by_grid.emplace_back(grid->getName(), grid->metaValue<std::string>(hash_name));
        const std::string hash = field_hash(hash_by_grid);
        for (const auto& grid : grids) grid->insertMeta(field_name, vdb::StringMetadata(hash));
        return vdb_bytes(grids);
    } catch (const std::exception& problem) {
        return Error{"", fmt::format("OpenVDB cannot write it: {}", exception_message(problem))};
    }
}

Result<Done> read_field_grids(std::string_view bytes, FieldContent content, ByteSink& answer) {
    FieldInput input(bytes);
    HF_TRY(const FieldHead head, input.head());
    write_field_head(head, answer);
    if (content == FieldContent::head) return Done{};
    return input.write_tables(head, answer);
}

ReaderTask field_reader_task() {
    return {task_name, read_task, nullptr, MappedPages::as_read};
}

Result<MappedFile> guarded_field(int file, FieldContent content, const std::string& where) {
    constexpr double memory_per_byte = 40;
    return guarded_read(field_reader_task(), file,
                        content == FieldContent::head ? head_request : whole_request, memory_per_byte, where);
}

}  // namespace haarfield
