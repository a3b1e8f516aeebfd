#pragma once
/// OpenVDB files in memory, read and written grid by grid. Internal: includes OpenVDB.

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// Registers OpenVDB's types of grids and metadata. Thread-safe; repeated calls cost nothing.
void initialize_openvdb();

/// An OpenVDB file in memory. OpenVDB trusts its input: a damaged file can crash it, so that it reads
/// untrusted files only in a reader process (fields/file/reader_process.h). Apart from that, all members
/// throw openvdb::Exception, std::bad_alloc and other exceptions for damaged files.
class VdbInput : private openvdb::io::Archive {
public:
    /// Reads the header and the list of grids. Refers to the bytes.
    explicit VdbInput(std::string_view bytes);
    ~VdbInput() override;

    using Archive::compression;
    using Archive::version;

    const openvdb::MetaMap& metadata() const { return metadata_; }  ///< That of the file.
    std::size_t grid_count() const { return grids_.size(); }        ///< Number of grids.
    const std::string& name(std::size_t i) const;                   ///< The name of grid i.
    std::string type(std::size_t i) const;                          ///< The type of its tree.

    /// Returns the number of the grid with a name, or grid_count().
    std::size_t find(std::string_view name) const;

    /// Reads metadata and transform of a grid, and none of its voxels.
    openvdb::GridBase::Ptr head(std::size_t i);
    /// Reads a grid without the values of its voxels: which voxels are active.
    openvdb::GridBase::Ptr topology(std::size_t i);
    /// Reads a grid. Nothing of it remains in this object.
    openvdb::GridBase::Ptr grid(std::size_t i);

    /// The number of bytes after the last grid, which OpenVDB ignores.
    std::uint64_t trailing_bytes() const { return trailing_bytes_; }

private:
    struct Listed {
        openvdb::io::GridDescriptor descriptor;
        openvdb::GridBase::Ptr whole;  ///< Of files without offsets, whose grids are read in order.
    };

    std::unique_ptr<std::streambuf> buffer_;
    openvdb::io::StreamMetadata::Ptr about_stream_;  // the stream refers to this pointer
    std::istream stream_;
    openvdb::MetaMap metadata_;
    std::vector<Listed> grids_;
    std::uint64_t trailing_bytes_ = 0;
};

/// Returns the file of these grids, compressed by Blosc. OpenVDB gives each file a random UUID. A UUID
/// computed from the content replaces it, so that equal grids have equal bytes.
///
/// errors  throws for a failure of OpenVDB.
std::string vdb_bytes(const openvdb::GridPtrVec& grids);

}  // namespace haarfield
