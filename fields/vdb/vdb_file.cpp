#include "fields/vdb/vdb_file.h"

#include <fmt/format.h>

#include <bit>
#include <type_traits>

#include "fields/base/exception_message.h"
#include "fields/file/guarded_read.h"
#include "fields/file/input_file.h"
#include "fields/vdb/vdb_archive.h"

namespace haarfield {
namespace {

namespace vdb = openvdb;

// ---- In the reader process ----

std::vector<VdbMetadata> metadata_of(const vdb::MetaMap& map) {
    constexpr std::size_t longest = 1000;
    std::vector<VdbMetadata> metadata;
    for (auto meta = map.beginMeta(); meta != map.endMeta(); ++meta)
        metadata.push_back({meta->first, meta->second->typeName(), meta->second->str().substr(0, longest)});
    return metadata;
}

std::array<double, 16> matrix_of(const vdb::GridBase& grid) {
    std::array<double, 16> rows{};
    const vdb::Mat4d matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column) rows[std::size_t(4 * row + column)] = matrix(row, column);
    return rows;
}

VdbGrid description_of(const vdb::GridBase& grid) {
    VdbGrid described;
    described.name = grid.getName();
    described.type = grid.valueType();
    described.grid_class = vdb::GridBase::gridClassToString(grid.getGridClass());
    described.active_voxels = grid.activeVoxelCount();
    described.leaves = grid.constBaseTree().leafCount();
    if (described.active_voxels > 0) {
        const vdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
        for (int k = 0; k < 3; ++k) {
            described.lower[std::size_t(k)] = box.min()[k];
            described.upper[std::size_t(k)] = box.max()[k];
        }
    }
    described.index_to_world = matrix_of(grid);
    described.metadata = metadata_of(grid);
    return described;
}

void write_metadata(const std::vector<VdbMetadata>& metadata, ByteSink& sink) {
    sink.value(std::uint64_t(metadata.size()));
    for (const VdbMetadata& meta : metadata)
        for (const std::string* text : {&meta.name, &meta.type, &meta.value}) sink.text(*text);
}

Result<Done> write_listing(VdbInput& input, ByteSink& sink) {
    sink.text(input.version());
    write_metadata(metadata_of(input.metadata()), sink);
    sink.value(std::uint64_t(input.grid_count()));
    for (std::size_t i = 0; i < input.grid_count(); ++i) {
        const vdb::GridBase::Ptr topology = input.topology(i);
        topology->setName(input.name(i));
        const VdbGrid grid = description_of(*topology);
        for (const std::string* text : {&grid.name, &grid.type, &grid.grid_class}) sink.text(*text);
        sink.value(grid.active_voxels);
        sink.value(grid.leaves);
        sink.value(grid.lower);
        sink.value(grid.upper);
        sink.value(grid.index_to_world);
        write_metadata(grid.metadata, sink);
    }
    return Done{};
}

/// The numbers of a value as 4-byte words.
template <class T>
struct Words {
    static constexpr std::uint32_t components = 1;
    static constexpr bool is_integer = std::is_integral_v<T>;
    static void append(const T& value, std::vector<std::uint32_t>& words) {
        if constexpr (is_integer)
            words.push_back(static_cast<std::uint32_t>(value));
        else
            words.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(value)));
    }
};
template <class T>
struct Words<vdb::math::Vec3<T>> {
    static constexpr std::uint32_t components = 3;
    static constexpr bool is_integer = std::is_integral_v<T>;
    static void append(const vdb::math::Vec3<T>& value, std::vector<std::uint32_t>& words) {
        for (int k = 0; k < 3; ++k) Words<T>::append(value[k], words);
    }
};

std::array<std::int32_t, 3> numbers_of(const vdb::Coord& at) {
    return {at.x(), at.y(), at.z()};
}

template <class Grid>
VdbLeaves leaves_of(const Grid& grid) {
    using Value = typename Grid::ValueType;
    using Leaf = typename Grid::TreeType::LeafNodeType;
    static_assert(Leaf::SIZE == VdbLeaves::leaf_voxels);
    VdbLeaves result;
    result.type = Words<Value>::is_integer ? VdbLeaves::Type::ints : VdbLeaves::Type::floats;
    result.components = Words<Value>::components;
    result.index_to_world = matrix_of(grid);
    std::vector<std::uint32_t> background;
    Words<Value>::append(grid.background(), background);
    std::ranges::copy(background, result.background.begin());
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        VdbLeaves::Leaf& added = result.leaves.emplace_back();
        added.origin = numbers_of(leaf->origin());
        for (vdb::Index i = 0; i < Leaf::SIZE; ++i) {
            added.active[i / 64] |= std::uint64_t(leaf->isValueOn(i)) << (i % 64);
            Words<Value>::append(leaf->getValue(i), result.values);
        }
    }
    auto value = grid.cbeginValueAll();
    value.setMaxDepth(value.getLeafDepth() - 1);
    for (; value; ++value) {
        if (!value.isValueOn() && value.getValue() == grid.background()) continue;
        vdb::CoordBBox box;
        value.getBoundingBox(box);
        result.tiles.push_back({numbers_of(box.min()), box.dim().x(), value.isValueOn()});
        Words<Value>::append(value.getValue(), result.values);
    }
    return result;
}

void write_leaves(const VdbLeaves& leaves, ByteSink& sink) {
    sink.value(leaves.type);
    sink.value(leaves.components);
    sink.value(leaves.background);
    sink.value(leaves.index_to_world);
    sink.values(leaves.leaves);
    sink.values(leaves.tiles);
    sink.values(leaves.values);
}

/// Writes the leaves of a grid if it is one of these types.
template <class... Grids>
bool write_leaves_of(const vdb::GridBase& grid, ByteSink& sink) {
    const auto write = [&]<class Grid>(const Grid*) {
        if (!grid.isType<Grid>()) return false;
        write_leaves(leaves_of(static_cast<const Grid&>(grid)), sink);
        return true;
    };
    return (write(static_cast<const Grids*>(nullptr)) || ...);
}

Result<Done> write_grid(VdbInput& input, std::string_view name, ByteSink& sink) {
    const std::size_t i = input.find(name);
    if (i == input.grid_count()) return Error{"", fmt::format("has no grid \"{}\"", name)};
    const vdb::GridBase::Ptr grid = input.grid(i);
    if (write_leaves_of<vdb::FloatGrid, vdb::DoubleGrid, vdb::Int32Grid, vdb::BoolGrid, vdb::Vec3SGrid,
                        vdb::Vec3DGrid, vdb::Vec3IGrid>(*grid, sink))
        return Done{};
    return Error{"",
                 fmt::format("grid \"{}\" has values of type {}; expected float, double, int32, bool, vec3s, "
                             "vec3d or vec3i",
                             name, grid->valueType())};
}

constexpr std::string_view task_name = "vdb 1";  // incremented whenever the output changes

/// details: empty for the listing, or `grid` and the name of a grid.
Result<Done> read_task(std::string_view bytes, std::string_view details, ByteSink& answer) {
    VdbInput input(bytes);
    constexpr std::string_view one_grid = "grid";
    if (!details.starts_with(one_grid)) return write_listing(input, answer);
    return write_grid(input, details.substr(one_grid.size()), answer);
}

// ---- In the program ----

Result<MappedFile> answer_for(const std::filesystem::path& file, const std::string& details) {
    constexpr double memory_per_byte = 100;  // constant voxels compress well
    HF_TRY(const InputFile opened, InputFile::open(file));
    return guarded_read(vdb_reader_task(), opened.descriptor(), details, memory_per_byte, file.string());
}

Error broken_answer(const std::filesystem::path& file) {
    return {file.string(), "the reader process returned an invalid list of grids"};
}

std::vector<VdbMetadata> metadata_from(ByteSource& source) {
    std::vector<VdbMetadata> metadata;
    for (std::uint64_t left = source.count(3 * sizeof(std::uint64_t)); left > 0; --left) {
        VdbMetadata& meta = metadata.emplace_back();
        for (std::string* text : {&meta.name, &meta.type, &meta.value}) *text = source.text();
    }
    return metadata;
}

}  // namespace

Result<VdbListing> read_vdb_listing(const std::filesystem::path& file) {
    HF_TRY(const MappedFile answer, answer_for(file, ""));
    ByteSource source(answer.bytes);
    VdbListing listing;
    listing.version = source.text();
    listing.metadata = metadata_from(source);
    for (std::uint64_t left = source.count(3 * sizeof(std::uint64_t)); left > 0; --left) {
        VdbGrid& grid = listing.grids.emplace_back();
        for (std::string* text : {&grid.name, &grid.type, &grid.grid_class}) *text = source.text();
        grid.active_voxels = source.value<std::uint64_t>();
        grid.leaves = source.value<std::uint64_t>();
        grid.lower = source.value<std::array<std::int32_t, 3>>();
        grid.upper = source.value<std::array<std::int32_t, 3>>();
        grid.index_to_world = source.value<std::array<double, 16>>();
        grid.metadata = metadata_from(source);
    }
    if (!source.is_at_end()) return broken_answer(file);
    return listing;
}

Result<VdbLeaves> read_vdb_leaves(const std::filesystem::path& file, std::string_view grid) {
    HF_TRY(const MappedFile answer, answer_for(file, "grid" + std::string(grid)));
    ByteSource source(answer.bytes);
    VdbLeaves leaves;
    leaves.type = source.value<VdbLeaves::Type>();
    leaves.components = source.value<std::uint32_t>();
    leaves.background = source.value<std::array<std::uint32_t, 3>>();
    leaves.index_to_world = source.value<std::array<double, 16>>();
    leaves.leaves = source.values<VdbLeaves::Leaf>();
    leaves.tiles = source.values<VdbLeaves::Tile>();
    leaves.values = source.values<std::uint32_t>();
    const bool is_valid =
        source.is_at_end() && (leaves.components == 1 || leaves.components == 3) &&
        (leaves.type == VdbLeaves::Type::floats || leaves.type == VdbLeaves::Type::ints) &&
        leaves.values.size() ==
            leaves.components * (VdbLeaves::leaf_voxels * leaves.leaves.size() + leaves.tiles.size());
    if (!is_valid) return broken_answer(file);
    return leaves;
}

ReaderTask vdb_reader_task() {
    return {task_name, read_task, nullptr, MappedPages::as_read};
}

}  // namespace haarfield
