#include "fields/vdb_store.h"

#include <fmt/format.h>
#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <mutex>
#include <sstream>

#include "fields/ambient_visibility.h"
#include "fields/field_blob.h"
#include "fields/temporary_file.h"

namespace haarfield {
namespace {

namespace vdb = openvdb;
using std::filesystem::path;

constexpr const char *ambient_name = "ambient_visibility", *planar_name = "planar_handles",
                     *spherical_name = "spherical_handles", *local_name = "local_handles",
                     *pool_name = "quadtree_pool", *blob_name = "haarfield_blob";

/// Bytes as grid metadata. Other programs skip the type and keep the bytes.
class BlobMetadata final : public vdb::Metadata {
public:
    BlobMetadata() : bytes_(std::make_shared<const std::string>()) {}
    explicit BlobMetadata(std::string bytes)
        : bytes_(std::make_shared<const std::string>(std::move(bytes))) {}

    static vdb::Metadata::Ptr create() { return std::make_shared<BlobMetadata>(); }
    const std::string& bytes() const { return *bytes_; }

    vdb::Name typeName() const override { return blob_name; }
    vdb::Metadata::Ptr copy() const override {
        auto result = std::make_shared<BlobMetadata>();
        result->bytes_ = bytes_;
        return result;
    }
    void copy(const vdb::Metadata& other) override {
        bytes_ = dynamic_cast<const BlobMetadata&>(other).bytes_;
    }
    std::string str() const override { return fmt::format("<{} bytes>", bytes_->size()); }
    bool asBool() const override { return !bytes_->empty(); }
    vdb::Index32 size() const override { return static_cast<vdb::Index32>(bytes_->size()); }

private:
    void readValue(std::istream& stream, vdb::Index32 count) override {
        // In steps, so that a false count does not allocate more than there is to read.
        constexpr std::size_t step = 1 << 20;
        std::string bytes;
        while (bytes.size() < count && stream) {
            const std::size_t before = bytes.size(), more = std::min(step, count - before);
            bytes.resize(before + more);
            stream.read(bytes.data() + before, static_cast<std::streamsize>(more));
            bytes.resize(before + static_cast<std::size_t>(stream.gcount()));
        }
        if (bytes.size() != count) throw std::runtime_error("metadata ends early");
        bytes_ = std::make_shared<const std::string>(std::move(bytes));
    }
    void writeValue(std::ostream& stream) const override {
        stream.write(bytes_->data(), static_cast<std::streamsize>(bytes_->size()));
    }

    std::shared_ptr<const std::string> bytes_;  ///< Shared, because OpenVDB copies grids to write them.
};

void initialize_openvdb() {
    static std::once_flag once;
    std::call_once(once, [] {
        vdb::initialize();  // first: it empties the registry
        if (!vdb::Metadata::isRegisteredType(blob_name))
            vdb::Metadata::registerType(blob_name, BlobMetadata::create);
    });
}

/// Where a table's entries lie in index space: a box in the order of memory, or bricks of 8^3.
struct Chart {
    std::int64_t count = 0;
    std::array<std::int64_t, 3> box{};  ///< All zero: bricks.

    bool in_bricks() const { return box[0] == 0; }

    vdb::Coord place(std::int64_t i) const {
        const auto coord = [](std::int64_t x, std::int64_t y, std::int64_t z) {
            return vdb::Coord(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
        };
        if (in_bricks())
            return coord((i >> 6 & 7) | (i >> 9 & 15) << 3, (i >> 3 & 7) | (i >> 13 & 15) << 3,
                         (i & 7) | (i >> 17) << 3);
        return coord(i / box[2] / box[1], i / box[2] % box[1], i % box[2]);
    }

    /// The inverse; may lie outside of the table.
    std::int64_t index(const vdb::Coord& coord) const {
        const std::int64_t x = coord.x(), y = coord.y(), z = coord.z();
        if (in_bricks())
            return (z & 7) | (y & 7) << 3 | (x & 7) << 6 | (x >> 3) << 9 | (y >> 3) << 13 | (z >> 3) << 17;
        return (x * box[1] + y) * box[2] + z;
    }
};

Chart planar_chart(const PlanarSampler& sampler) {
    return {std::int64_t(sampler.rings) * sampler.angles, {sampler.rings, sampler.angles, 1}};
}

Chart spherical_chart(const SphericalSampler& sampler) {
    return {std::int64_t(sampler.shells) * sampler.polar * sampler.azimuths,
            {sampler.shells, sampler.polar, sampler.azimuths}};
}

Chart local_chart(std::size_t vertices) {
    return {static_cast<std::int64_t>(vertices), {}};
}

/// A map that stretches index space over a box, from the lower corner of voxel 0 to the upper of the last.
vdb::math::Transform::Ptr box_transform(const Bounds& bounds, const vdb::Coord& last) {
    const double shortest = std::max(1e-3 * bounds.radius(), 1e-6);  // a flat entity has a volume here
    vdb::Vec3d scale, centre;
    for (int k = 0; k < 3; ++k) {
        const double extent = std::max(double(bounds.upper[k]) - bounds.lower[k], shortest);
        scale[k] = extent / (last[k] + 1);
        centre[k] = bounds.lower[k] + 0.5 * scale[k];
    }
    return std::make_shared<vdb::math::Transform>(
        std::make_shared<vdb::math::ScaleTranslateMap>(scale, centre));
}

vdb::GridBase::Ptr handle_grid(const char* name, const std::vector<std::int32_t>& handles, const Chart& chart,
                               const Bounds& bounds) {
    const auto grid = vdb::Int32Grid::create(-1);
    grid->setName(name);
    auto accessor = grid->getAccessor();
    vdb::Coord last(0);
    for (std::size_t i = 0; i < handles.size(); ++i) {
        const vdb::Coord place = chart.place(static_cast<std::int64_t>(i));
        accessor.setValueOn(place, handles[i]);
        last.maxComponent(place);
    }
    grid->setTransform(box_transform(bounds, last));
    return grid;
}

vdb::GridBase::Ptr pool_grid(std::string blob, const Bounds& bounds) {
    const auto grid = vdb::Int32Grid::create(-1);
    grid->setName(pool_name);
    grid->tree().setValueOn(vdb::Coord(0), 0);  // an empty grid has an inverted box
    grid->setTransform(box_transform(bounds, vdb::Coord(0)));
    grid->insertMeta(blob_name, BlobMetadata(std::move(blob)));
    return grid;
}

/// Voxels of which less than this part of the directions is blocked are left out, so that viewers show a
/// hull that follows the entity.
constexpr float least_occlusion = 0.1f;

vdb::FloatGrid::Ptr ambient_grid(const VisibilityField& field) {
    const AmbientVisibility volume = ambient_visibility(field);
    const auto grid = vdb::FloatGrid::create(1.0f);
    grid->setName(ambient_name);
    grid->setGridClass(vdb::GRID_FOG_VOLUME);
    const auto transform = vdb::math::Transform::createLinearTransform(volume.voxel_size);
    transform->postTranslate(vdb::Vec3d(volume.origin.x, volume.origin.y, volume.origin.z));
    grid->setTransform(transform);
    auto accessor = grid->getAccessor();
    auto value = volume.values.begin();
    for (std::int32_t x = 0; x < volume.size[0]; ++x)
        for (std::int32_t y = 0; y < volume.size[1]; ++y)
            for (std::int32_t z = 0; z < volume.size[2]; ++z, ++value)
                if (*value < 1 - least_occlusion) accessor.setValueOn(vdb::Coord(x, y, z), *value);
    return grid;
}

Error system_error(const path& file, const char* action, int number) {
    return {file.string(), fmt::format("cannot {}: {}", action, std::strerror(number))};
}

/// The last bytes of a file that has a seal, once the seal itself holds.
Result<FieldSeal> checked_seal(std::ifstream& stream, std::uint64_t file_bytes) {
    std::string end(std::min<std::uint64_t>(field_seal_size, file_bytes), '\0');
    stream.seekg(static_cast<std::streamoff>(file_bytes - end.size()));
    stream.read(end.data(), static_cast<std::streamsize>(end.size()));
    if (!stream) return Error{"", "cannot be read to its end"};
    return read_field_seal(end, file_bytes);
}

struct OpenedFile {
    std::ifstream stream;
    std::uint64_t bytes = 0;
};

Result<OpenedFile> opened_file(const path& file) {
    std::error_code problem;
    if (!std::filesystem::is_regular_file(file, problem))
        return Error{file.string(), problem ? problem.message() : "not a file"};
    OpenedFile opened;
    opened.bytes = std::filesystem::file_size(file, problem);
    if (problem) return Error{file.string(), problem.message()};
    errno = 0;
    opened.stream.open(file, std::ios::binary);
    if (!opened.stream) return system_error(file, "open it", errno);
    return opened;
}

Result<std::string> read_bytes(std::ifstream& stream, std::uint64_t count) {
    std::string bytes(count, '\0');
    stream.seekg(0);
    stream.read(bytes.data(), static_cast<std::streamsize>(count));
    if (!stream) return Error{"", "cannot be read to its end"};
    return bytes;
}

/// A grid of its type by its name, or null.
template <class Grid>
typename Grid::Ptr named_grid(const vdb::GridPtrVec& grids, const char* name) {
    for (const vdb::GridBase::Ptr& grid : grids)
        if (grid && grid->getName() == name) return vdb::gridPtrCast<Grid>(grid);
    return nullptr;
}

std::size_t active_voxels(const vdb::GridPtrVec& grids, const char* name) {
    const auto grid = named_grid<vdb::Int32Grid>(grids, name);
    return grid ? grid->activeVoxelCount() : 0;
}

Result<std::vector<std::int32_t>> grid_handles(const vdb::GridPtrVec& grids, const char* name,
                                               const Chart& chart) {
    const auto grid = named_grid<vdb::Int32Grid>(grids, name);
    if (!grid) return Error{"", fmt::format("there is no grid {} of type int32", name)};
    const auto& tree = grid->tree();
    const auto mismatch =
        Error{"", fmt::format("grid {} does not hold its {} samples, and these only", name, chart.count)};
    if (tree.activeTileCount() != 0 || chart.count < 0 ||
        tree.activeLeafVoxelCount() != static_cast<std::uint64_t>(chart.count))
        return mismatch;
    std::vector<std::int32_t> handles(static_cast<std::size_t>(chart.count));
    // As many places as voxels, each voxel in its own: then all are filled.
    for (auto voxel = tree.cbeginValueOn(); voxel; ++voxel) {
        const std::int64_t index = chart.index(voxel.getCoord());
        if (index < 0 || index >= chart.count || chart.place(index) != voxel.getCoord()) return mismatch;
        handles[static_cast<std::size_t>(index)] = *voxel;
    }
    return handles;
}

/// The field in the bytes of a file whose seal holds.
Result<VisibilityField> decoded_file(std::string bytes, const ContentHash& key) {
    initialize_openvdb();
    try {
        std::istringstream stream(std::move(bytes));
        const vdb::GridPtrVecPtr grids = vdb::io::Stream(stream, /*delayLoad=*/false).getGrids();
        const auto pool = named_grid<vdb::Int32Grid>(*grids, pool_name);
        const auto blob =
            pool ? std::dynamic_pointer_cast<const BlobMetadata>(std::as_const(*pool)[blob_name]) : nullptr;
        if (!blob)
            return Error{"", fmt::format("there is no grid {} with metadata {}", pool_name, blob_name)};
        Result<VisibilityField> field = blob_field(blob->bytes());
        if (!field) return field.error();
        field->key = key;

        // The samplers' sizes have not been checked yet: keep their products from overflowing.
        for (const std::int32_t size : {field->planar.rings, field->planar.angles, field->spherical.shells,
                                        field->spherical.polar, field->spherical.azimuths})
            if (size < 1 || size > 1 << 20) return Error{"", fmt::format("a sampler's size is {}", size)};
        const std::tuple<const char*, Chart, std::vector<std::int32_t>&> tables[] = {
            {planar_name, planar_chart(field->planar), field->planar_handles},
            {spherical_name, spherical_chart(field->spherical), field->spherical_handles},
            {local_name, local_chart(active_voxels(*grids, local_name)), field->local_handles}};
        for (const auto& [name, chart, table] : tables) {
            Result<std::vector<std::int32_t>> handles = grid_handles(*grids, name, chart);
            if (!handles) return handles.error();
            table = *std::move(handles);
        }
        if (const std::string defect = field_defect(*field); !defect.empty()) return Error{"", defect};
        if (!named_grid<vdb::FloatGrid>(*grids, ambient_name))
            return Error{"", fmt::format("there is no grid {} of type float", ambient_name)};
        return *std::move(field);
    } catch (const std::exception& problem) {
        return Error{"", fmt::format("OpenVDB cannot read it: {}", problem.what())};
    }
}

struct CheckedFile {
    VisibilityField field;
    std::uint64_t bytes = 0;
};

Result<CheckedFile> checked_file(const path& file) {
    Result<OpenedFile> opened = opened_file(file);
    if (!opened) return opened.error();
    const auto refusal = [&](const std::string& reason) { return Error{file.string(), reason}; };
    const Result<FieldSeal> seal = checked_seal(opened->stream, opened->bytes);
    if (!seal) return refusal(seal.error().what);
    Result<std::string> bytes = read_bytes(opened->stream, opened->bytes);
    if (!bytes) return refusal(bytes.error().what);
    bytes->resize(bytes->size() - field_seal_size);
    if (content_hash(*bytes) != seal->content)
        return refusal("the file was changed or damaged since it was written: its checksum is wrong");
    Result<VisibilityField> decoded = decoded_file(*std::move(bytes), seal->key);
    if (!decoded) return refusal(decoded.error().what);
    return CheckedFile{*std::move(decoded), opened->bytes};
}

/// Whether two fields that field_defect passes are equal, bit for bit but for the sign of zeros.
bool same_field(const VisibilityField& a, const VisibilityField& b) {
    return a.key == b.key && a.planar_handles == b.planar_handles &&
           a.spherical_handles == b.spherical_handles && a.local_handles == b.local_handles &&
           field_blob(a) == field_blob(b);
}

/// OpenVDB's random number of a file, as text.
constexpr std::size_t uuid_offset = 21, uuid_size = 36;

/// One made from the content instead. Empty if the header is not what we know.
std::string content_uuid(std::string bytes) {
    if (bytes.size() < uuid_offset + uuid_size) return {};
    const auto is_dash = [](std::size_t i) { return i == 8 || i == 13 || i == 18 || i == 23; };
    for (std::size_t i = 0; i < uuid_size; ++i) {
        char& c = bytes[uuid_offset + i];
        if (is_dash(i) ? c != '-' : std::isxdigit(static_cast<unsigned char>(c)) == 0) return {};
        c = '0';
    }
    std::string uuid = content_hash(bytes).hex();
    uuid[12] = '8';  // version 8: made by an own rule
    uuid[16] = '8';
    for (const std::size_t dash : {8u, 13u, 18u, 23u}) uuid.insert(dash, 1, '-');
    return uuid;
}

}  // namespace

Result<Done> write_field(const VisibilityField& field, const path& file) {
    if (const std::string defect = field_defect(field); !defect.empty())
        return Error{file.string(), "the field is not written, for it has a defect: " + defect};
    std::string blob = field_blob(field);
    if (blob.size() > std::numeric_limits<vdb::Index32>::max())
        return Error{file.string(),
                     fmt::format("the field has {} bytes; OpenVDB's metadata ends at 4 GiB", blob.size())};
    TemporaryFile temporary(file);
    if (!temporary.exists()) return system_error(file, "make a file beside it", temporary.error_number());
    initialize_openvdb();
    try {
        const vdb::GridPtrVec grids{
            ambient_grid(field),
            handle_grid(planar_name, field.planar_handles, planar_chart(field.planar), field.bounds),
            handle_grid(spherical_name, field.spherical_handles, spherical_chart(field.spherical),
                        field.bounds),
            handle_grid(local_name, field.local_handles, local_chart(field.local_handles.size()),
                        field.bounds),
            pool_grid(std::move(blob), field.bounds)};
        vdb::io::File output(temporary.path().string());
        output.setCompression(vdb::io::COMPRESS_BLOSC | vdb::io::COMPRESS_ACTIVE_MASK);
        output.write(grids);
        output.close();
    } catch (const std::exception& problem) {
        return Error{file.string(), fmt::format("OpenVDB cannot write it: {}", problem.what())};
    }

    // OpenVDB does not tell of a full disk: what it wrote is read back.
    Result<OpenedFile> written = opened_file(temporary.path());
    Result<std::string> bytes =
        written ? read_bytes(written->stream, written->bytes) : Result<std::string>(written.error());
    if (!bytes) return Error{file.string(), "cannot be read back: " + bytes.error().what};
    const std::string uuid = content_uuid(*bytes);
    if (uuid.empty()) return Error{file.string(), "cannot be written whole (is the disk full?)"};
    bytes->replace(uuid_offset, uuid_size, uuid);
    const std::string seal = field_seal(*bytes, field.key);
    if (!temporary.write_at(uuid_offset, uuid) || !temporary.write_at(bytes->size(), seal))
        return system_error(file, "write it", errno);
    const Result<VisibilityField> decoded = decoded_file(*std::move(bytes), field.key);
    if (!decoded || !same_field(*decoded, field))
        return Error{file.string(), "cannot be written whole (is the disk full?)"};
    if (!temporary.replace_target()) return system_error(file, "put it in its place", errno);
    return Done{};
}

Result<VisibilityField> read_field(const path& file) {
    Result<CheckedFile> checked = checked_file(file);
    if (!checked) return checked.error();
    return std::move(checked->field);
}

Result<ContentHash> read_field_key(const path& file) {
    Result<OpenedFile> opened = opened_file(file);
    if (!opened) return opened.error();
    const Result<FieldSeal> seal = checked_seal(opened->stream, opened->bytes);
    if (!seal) return Error{file.string(), seal.error().what};
    return seal->key;
}

Result<FieldSummary> read_field_summary(const path& file) {
    const Result<CheckedFile> checked = checked_file(file);
    if (!checked) return checked.error();
    const VisibilityField& field = checked->field;
    FieldSummary summary;
    summary.entity = field.entity;
    summary.key = field.key;
    summary.settings = field.settings;
    summary.bounds = field.bounds;
    summary.planar = field.planar;
    summary.spherical = field.spherical;
    summary.local_samples = field.local_handles.size();
    summary.cubemaps = field.pool.cubemaps.size();
    summary.faces = field.pool.faces.size();
    summary.nodes = node_count(field.pool);
    summary.error = field.error;
    summary.file_bytes = checked->bytes;
    return summary;
}

Result<Done> verify_field(const path& file) {
    const Result<CheckedFile> checked = checked_file(file);
    if (!checked) return checked.error();
    return Done{};
}

}  // namespace haarfield
