#pragma once
/// OpenVDB files of any program: their grids, and the voxels of one grid.
///
/// OpenVDB trusts its input, so that a reader process parses the files (fields/file/reader_process.h).

#include "fields/base/result.h"
#include "fields/file/reader_process.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// One piece of metadata of a file or a grid.
struct VdbMetadata {
    std::string name, type;
    std::string value;  ///< As text, cut after 1000 bytes.
};

/// A grid without its values.
struct VdbGrid {
    std::string name;
    std::string type;        ///< That of its values: `float`, `int32`, `vec3s` ...
    std::string grid_class;  ///< `fog volume`, `level set`, `staggered` or `unknown`.
    std::uint64_t active_voxels = 0;
    std::uint64_t leaves = 0;                      ///< Blocks of 8^3 voxels that are stored.
    std::array<std::int32_t, 3> lower{}, upper{};  ///< Bounds of the active voxels, inclusive.
    /// Rows of the matrix that maps (x, y, z, 1) in index space, a row vector, to world space. The rounded
    /// matrix of a transform that is not affine is that at its origin.
    std::array<double, 16> index_to_world{};
    std::vector<VdbMetadata> metadata;
};

/// The content of a file.
struct VdbListing {
    std::string version;  ///< Of the library and of the format: `10.0/224`.
    std::vector<VdbMetadata> metadata;
    std::vector<VdbGrid> grids;
};

/// Reads which grids a file has.
///
/// errors  no OpenVDB file, cut short, or with a type of grid that OpenVDB does not know; those of
///         guarded_read.
/// cost    reads which voxels are active, and no values.
Result<VdbListing> read_vdb_listing(const std::filesystem::path& file);

/// The voxels of a grid.
struct VdbLeaves {
    static constexpr std::size_t leaf_voxels = 512;

    /// Type of the values.
    enum class Type { floats, ints };
    /// 8^3 voxels. Voxel (x, y, z) of the leaf has the number 64 x + 8 y + z.
    struct Leaf {
        std::array<std::int32_t, 3> origin;   ///< Its lowest voxel; multiples of 8.
        std::array<std::uint64_t, 8> active;  ///< Bit y * 8 + z of word x: the voxel is active.
    };
    /// A cube with one value.
    struct Tile {
        std::array<std::int32_t, 3> origin;
        std::int32_t size;    ///< Voxels along an edge: 8, 128 or 4096.
        std::int32_t active;  ///< 1 or 0.
    };
    Type type = Type::floats;
    std::uint32_t components = 1;               ///< 1 or 3 numbers per voxel.
    std::array<std::uint32_t, 3> background{};  ///< The bits of its numbers.
    std::array<double, 16> index_to_world{};    ///< See VdbGrid.
    std::vector<Leaf> leaves;
    std::vector<Tile> tiles;  ///< Those that are active or differ from the background.
    /// The bits of `components` numbers for each voxel of each leaf, then for each tile.
    std::vector<std::uint32_t> values;
};

/// Reads one grid. Values of type double are rounded to float; bool becomes 0 or 1.
///
/// errors  those of read_vdb_listing; no such grid; values other than float, double, int32, bool and vectors
///         of three floats, doubles or int32.
Result<VdbLeaves> read_vdb_leaves(const std::filesystem::path& file, std::string_view grid);

/// Calls act(voxel, numbers) for each active voxel outside tiles. The numbers are floats: only for
/// Type::floats.
template <class Act>
void for_each_active(const VdbLeaves& leaves, const Act& act);

/// Returns the task of reader processes that reads listings and leaves.
ReaderTask vdb_reader_task();

template <class Act>
void for_each_active(const VdbLeaves& leaves, const Act& act) {
    const auto* value = reinterpret_cast<const float*>(leaves.values.data());
    for (const VdbLeaves::Leaf& leaf : leaves.leaves)
        for (std::int32_t i = 0; i < std::int32_t(VdbLeaves::leaf_voxels); ++i, value += leaves.components)
            if (leaf.active[std::size_t(i) / 64] >> (i % 64) & 1)
                act(std::array{leaf.origin[0] + i / 64, leaf.origin[1] + i / 8 % 8, leaf.origin[2] + i % 8},
                    value);
}

}  // namespace haarfield
