#include "fields/field/vdb_store.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <mutex>
#include <sstream>

#include "fields/base/exception_message.h"
#include "fields/field/ambient_visibility.h"
#include "fields/field/field_blob.h"
#include "fields/field/field_seal.h"

namespace haarfield {
namespace {

namespace vdb = openvdb;

constexpr const char* blob_name = "haarfield_blob";

/// The blob, and its offset in the file, which is known after writing.
struct PlacedBlob {
    std::string bytes;
    std::size_t offset = 0;
};

/// The blob as grid metadata. Zeros before it align it in the file, so that it can be read in place. Other
/// programs do not know the type and preserve the bytes. All copies refer to one blob, because OpenVDB copies
/// grids before it writes them.
class BlobMetadata final : public vdb::Metadata {
public:
    explicit BlobMetadata(std::shared_ptr<PlacedBlob> blob) : blob_(std::move(blob)) {}

    vdb::Name typeName() const override { return blob_name; }
    vdb::Metadata::Ptr copy() const override { return std::make_shared<BlobMetadata>(blob_); }
    void copy(const vdb::Metadata& other) override { blob_ = dynamic_cast<const BlobMetadata&>(other).blob_; }
    std::string str() const override { return fmt::format("<{} bytes>", blob_->bytes.size()); }
    bool asBool() const override { return true; }
    vdb::Index32 size() const override {
        return static_cast<vdb::Index32>(blob_->bytes.size() + field_blob_alignment);
    }

private:
    void readValue(std::istream&, vdb::Index32) override {
        throw std::logic_error("fields are not read through OpenVDB");
    }
    void writeValue(std::ostream& stream) const override {
        const std::string zeros(field_blob_alignment, '\0');
        const auto begin = static_cast<std::size_t>(stream.tellp());
        const std::size_t before = (zeros.size() - begin % zeros.size()) % zeros.size();
        blob_->offset = begin + before;
        stream.write(zeros.data(), static_cast<std::streamsize>(before));
        stream.write(blob_->bytes.data(), static_cast<std::streamsize>(blob_->bytes.size()));
        stream.write(zeros.data(), static_cast<std::streamsize>(zeros.size() - before));
    }

    std::shared_ptr<PlacedBlob> blob_;
};

/// OpenVDB's writer for any seekable stream. io::File writes to files only and does not report a full disk.
class StreamArchive : public vdb::io::Archive {
public:
    using vdb::io::Archive::write;
};

void initialize_openvdb() {
    static std::once_flag once;
    std::call_once(once, [] { vdb::initialize(); });
}

vdb::Coord coord(std::int64_t x, std::int64_t y, std::int64_t z) {
    return {static_cast<int>(x), static_cast<int>(y), static_cast<int>(z)};
}

vdb::Coord planar_place(const PlanarSampler& sampler, std::int64_t i) {
    return coord(i / sampler.angles, i % sampler.angles, 0);
}

vdb::Coord spherical_place(const SphericalSampler& sampler, std::int64_t i) {
    return coord(i / sampler.azimuths / sampler.polar, i / sampler.azimuths % sampler.polar,
                 i % sampler.azimuths);
}

/// Returns the voxel of vertex i: bricks of 8^3 voxels, in rows of 16 bricks and layers of 16 rows.
vdb::Coord local_place(std::int64_t i) {
    return coord((i >> 6 & 7) | (i >> 9 & 15) << 3, (i >> 3 & 7) | (i >> 13 & 15) << 3,
                 (i & 7) | (i >> 17) << 3);
}

void describe(vdb::GridBase& grid, const char* name, const char* schema, std::string_view hashed) {
    grid.setName(name);
    grid.insertMeta("haarfield_version", vdb::Int32Metadata(static_cast<std::int32_t>(field_blob_version)));
    grid.insertMeta("haarfield_schema", vdb::StringMetadata(schema));
    grid.insertMeta("haarfield_xxh3",
                    vdb::Int64Metadata(static_cast<std::int64_t>(XXH3_64bits(hashed.data(), hashed.size()))));
}

template <class T>
std::string_view bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Returns the factor by which voxels must grow so that OpenVDB accepts their transform. It rejects volumes
/// below about 3e-15 m^3. Viewers therefore show entities of a few tenths of a millimetre too large. The
/// field in the blob is unchanged.
double needed_growth(const vdb::Vec3d& voxel) {
    constexpr double smallest = 1e-14;
    const double volume = voxel.x() * voxel.y() * voxel.z();
    return volume < smallest ? std::cbrt(smallest / volume) : 1;
}

/// Returns a transform that maps index space to a box, from the lower corner of voxel 0 to the upper corner
/// of the last voxel.
vdb::math::Transform::Ptr box_transform(const Bounds& bounds, const vdb::Coord& last) {
    const double shortest = std::max(1e-3 * bounds.radius(), 1e-6);  // gives flat entities a volume
    vdb::Vec3d scale, centre;
    for (int k = 0; k < 3; ++k) {
        const double extent = std::max(double(bounds.upper[k]) - bounds.lower[k], shortest);
        scale[k] = extent / (last[k] + 1);
    }
    scale *= needed_growth(scale);
    for (int k = 0; k < 3; ++k) centre[k] = bounds.lower[k] + 0.5 * scale[k];
    return std::make_shared<vdb::math::Transform>(
        std::make_shared<vdb::math::ScaleTranslateMap>(scale, centre));
}

/// Returns a grid with handle i at the voxel place(i).
template <class Place>
vdb::GridBase::Ptr handle_grid(const char* name, const char* schema, const Bounds& bounds,
                               const std::vector<std::int32_t>& handles, const Place& place) {
    const auto grid = vdb::Int32Grid::create(-1);
    auto accessor = grid->getAccessor();
    vdb::Coord last(0);
    for (std::size_t i = 0; i < handles.size(); ++i) {
        const vdb::Coord voxel = place(static_cast<std::int64_t>(i));
        accessor.setValueOn(voxel, handles[i]);
        last.maxComponent(voxel);
    }
    grid->setTransform(box_transform(bounds, last));
    describe(*grid, name, schema, bytes_of(handles));
    return grid;
}

vdb::GridBase::Ptr pool_grid(const std::shared_ptr<PlacedBlob>& blob, const Bounds& bounds) {
    const auto grid = vdb::Int32Grid::create(-1);
    grid->tree().setValueOn(vdb::Coord(0), 0);  // an empty grid has an inverted box
    grid->setTransform(box_transform(bounds, vdb::Coord(0)));
    describe(*grid, "quadtree_pool", "metadata haarfield_blob: the field, as field_blob.h describes it",
             blob->bytes);
    grid->insertMeta(blob_name, BlobMetadata(blob));
    return grid;
}

/// Minimum blocked fraction of directions of an active voxel. Viewers then show a hull that follows the
/// entity.
constexpr float least_occlusion = 0.1f;

/// Returns the two grids for viewers: ambient_visibility and open_direction.
std::array<vdb::GridBase::Ptr, 2> ambient_grids(const VisibilityField& field) {
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
    std::vector<float> active;
    std::vector<Vec3f> active_directions;
    for (std::int32_t x = 0; x < volume.size[0]; ++x)
        for (std::int32_t y = 0; y < volume.size[1]; ++y)
            for (std::int32_t z = 0; z < volume.size[2]; ++z, ++i) {
                if (!(volume.values[i] < 1 - least_occlusion)) continue;
                const Vec3f& mean = volume.directions[i];
                open_voxels.setValueOn(vdb::Coord(x, y, z), volume.values[i]);
                direction_voxels.setValueOn(vdb::Coord(x, y, z), vdb::Vec3s(mean.x, mean.y, mean.z));
                active.push_back(volume.values[i]);
                active_directions.push_back(mean);
            }
    describe(*open, "ambient_visibility", "x, y, z: fraction of all directions that is open",
             bytes_of(active));
    describe(*direction, "open_direction", "x, y, z: mean of all directions that are open",
             bytes_of(active_directions));
    return {open, direction};
}

/// Offsets in the header of an OpenVDB file: u64 magic, u32 version of the format, u32 major and u32 minor
/// version of the library, u8 flag for seekable files, and a random UUID as text.
constexpr std::size_t version_offset = 8, version_size = 12, uuid_offset = 21, uuid_size = 36;

/// Replaces the UUID by one computed from the content. Returns false if there is no UUID at its offset.
bool number_by_content(std::string& bytes) {
    if (bytes.size() < uuid_offset + uuid_size) return false;
    const auto is_dash = [](std::size_t i) { return i == 8 || i == 13 || i == 18 || i == 23; };
    for (std::size_t i = 0; i < uuid_size; ++i) {
        char& c = bytes[uuid_offset + i];
        if (is_dash(i) ? c != '-' : std::isxdigit(static_cast<unsigned char>(c)) == 0) return false;
        c = '0';
    }
    std::string uuid = content_hash(bytes).hex();
    uuid[12] = '8';  // version 8: custom
    uuid[16] = '8';
    for (const std::size_t dash : {8u, 13u, 18u, 23u}) uuid.insert(dash, 1, '-');
    bytes.replace(uuid_offset, uuid_size, uuid);
    return true;
}

}  // namespace

Result<VdbFile> vdb_file(const VisibilityField& field) {
    const auto blob = std::make_shared<PlacedBlob>(PlacedBlob{field_blob(field)});
    const std::size_t size = blob->bytes.size();
    if (size > std::numeric_limits<vdb::Index32>::max() - field_blob_alignment)
        return Error{"", fmt::format("the field has {} bytes; OpenVDB's metadata ends at 4 GiB", size)};
    initialize_openvdb();
    try {
        const auto [open, direction] = ambient_grids(field);
        const vdb::GridPtrVec grids{
            open,
            direction,
            handle_grid("planar_handles", "ring, angle, 0: handle of a cubemap", field.bounds,
                        field.planar_handles, [&](auto i) { return planar_place(field.planar, i); }),
            handle_grid("spherical_handles", "shell, row, azimuth: handle of a cubemap", field.bounds,
                        field.spherical_handles, [&](auto i) { return spherical_place(field.spherical, i); }),
            handle_grid("local_handles", "vertices in bricks of 8^3: handle of a cubemap", field.bounds,
                        field.local_handles, local_place),
            pool_grid(blob, field.bounds)};
        std::ostringstream stream(std::ios::binary);
        StreamArchive archive;
        archive.setCompression(vdb::io::COMPRESS_BLOSC | vdb::io::COMPRESS_ACTIVE_MASK);
        archive.write(stream, grids, /*seekable=*/true);
        VdbFile file{std::move(stream).str(), blob->offset, size};
        if (!stream || !number_by_content(file.bytes) || file.blob().size() != size)
            return Error{"", "OpenVDB did not write it as expected"};
        return file;
    } catch (const std::exception& problem) {
        return Error{"", fmt::format("OpenVDB cannot write it: {}", exception_message(problem))};
    }
}

bool same_vdb_library(std::string_view file) {
    const std::array<std::uint32_t, 3> ours{vdb::OPENVDB_FILE_VERSION, vdb::OPENVDB_LIBRARY_MAJOR_VERSION,
                                            vdb::OPENVDB_LIBRARY_MINOR_VERSION};
    static_assert(sizeof ours == version_size);
    return file.size() >= version_offset + version_size &&
           std::memcmp(file.data() + version_offset, ours.data(), version_size) == 0;
}

}  // namespace haarfield
