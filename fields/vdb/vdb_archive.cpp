#include "fields/vdb/vdb_archive.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cctype>
#include <mutex>
#include <sstream>
#include <stdexcept>

namespace haarfield {
namespace {

/// Bytes in memory as a seekable stream.
class MemoryBuffer final : public std::streambuf {
public:
    explicit MemoryBuffer(std::string_view bytes) {
        char* const begin = const_cast<char*>(bytes.data());  // only read
        setg(begin, begin, begin + bytes.size());
    }

protected:
    pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
        const off_type base = from == std::ios_base::beg   ? 0
                              : from == std::ios_base::cur ? gptr() - eback()
                                                           : egptr() - eback();
        const off_type size = egptr() - eback();
        // The sum may overflow: offsets are numbers from the file.
        if (offset < -base || offset > size - base) return pos_type(off_type(-1));
        setg(eback(), eback() + base + offset, egptr());
        return pos_type(base + offset);
    }
    pos_type seekpos(pos_type position, std::ios_base::openmode mode) override {
        return seekoff(off_type(position), std::ios_base::beg, mode);
    }
};

/// OpenVDB's writer for any seekable stream. io::File writes to files only and does not report a full disk.
class OutputArchive final : public openvdb::io::Archive {
public:
    using openvdb::io::Archive::write;
};

/// Offsets in the header of an OpenVDB file: u64 magic, u32 version of the format, u32 major and u32 minor
/// version of the library, u8 flag for seekable files, and a random UUID as text.
constexpr std::size_t uuid_offset = 21, uuid_size = 36;

/// Replaces the UUID by one computed from the content. Returns false if there is no UUID at its offset.
bool number_by_content(std::string& bytes) {
    if (bytes.size() < uuid_offset + uuid_size) return false;
    const auto is_dash = [](std::size_t i) { return i == 8 || i == 13 || i == 18 || i == 23; };
    for (std::size_t i = 0; i < uuid_size; ++i) {
        char& c = bytes[uuid_offset + i];
        if (is_dash(i) ? c != '-' : std::isxdigit(static_cast<unsigned char>(c)) == 0) return false;
        c = '0';
    }
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    std::string uuid = fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
    uuid[12] = '8';  // version 8: custom
    uuid[16] = '8';
    for (const std::size_t dash : {8u, 13u, 18u, 23u}) uuid.insert(dash, 1, '-');
    bytes.replace(uuid_offset, uuid_size, uuid);
    return true;
}

}  // namespace

void initialize_openvdb() {
    static std::once_flag once;
    std::call_once(once, [] { openvdb::initialize(); });
}

VdbInput::VdbInput(std::string_view bytes)
    : buffer_(std::make_unique<MemoryBuffer>(bytes)), stream_(buffer_.get()) {
    initialize_openvdb();
    stream_.exceptions(std::ios_base::badbit | std::ios_base::failbit | std::ios_base::eofbit);
    readHeader(stream_);
    about_stream_ = std::make_shared<openvdb::io::StreamMetadata>();
    openvdb::io::setStreamMetadataPtr(stream_, about_stream_, /*transfer=*/false);
    setFormatVersion(stream_);
    setLibraryVersion(stream_);
    setDataCompression(stream_);
    metadata_.readMeta(stream_);
    for (std::int32_t left = readGridCount(stream_); left > 0; --left) {
        Listed listed;
        const openvdb::GridBase::Ptr grid = listed.descriptor.read(stream_);
        if (inputHasGridOffsets()) {
            listed.descriptor.seekToEnd(stream_);
        } else {
            readGrid(grid, listed.descriptor, stream_);
            listed.whole = grid;
        }
        grids_.push_back(std::move(listed));
    }
    trailing_bytes_ = bytes.size() - static_cast<std::uint64_t>(stream_.tellg());
}

VdbInput::~VdbInput() = default;

const std::string& VdbInput::name(std::size_t i) const {
    return grids_[i].descriptor.gridName();
}

std::string VdbInput::type(std::size_t i) const {
    return grids_[i].descriptor.gridType();
}

std::size_t VdbInput::find(std::string_view name) const {
    return static_cast<std::size_t>(
        std::ranges::find_if(grids_,
                             [&](const Listed& listed) { return listed.descriptor.gridName() == name; }) -
        grids_.begin());
}

openvdb::GridBase::Ptr VdbInput::head(std::size_t i) {
    const Listed& listed = grids_[i];
    if (listed.whole) return listed.whole;
    const openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(listed.descriptor.gridType());
    listed.descriptor.seekToGrid(stream_);
    readGridCompression(stream_);
    grid->readMeta(stream_);
    grid->removeMeta("file_delayed_load");  // tables for delayed loading
    grid->readTransform(stream_);
    return grid;
}

openvdb::GridBase::Ptr VdbInput::topology(std::size_t i) {
    const openvdb::GridBase::Ptr grid = head(i);
    // An instance shares the tree of another grid, which the file holds once.
    if (!grids_[i].whole && !grids_[i].descriptor.isInstance()) grid->readTopology(stream_);
    return grid;
}

openvdb::GridBase::Ptr VdbInput::grid(std::size_t i) {
    const Listed& listed = grids_[i];
    const openvdb::GridBase::Ptr grid = topology(i);
    if (!listed.whole && !listed.descriptor.isInstance()) grid->readBuffers(stream_);
    if (!listed.descriptor.isInstance()) return grid;
    for (std::size_t parent = 0; parent < grids_.size(); ++parent)
        if (const auto& other = grids_[parent].descriptor;
            other.uniqueName() == listed.descriptor.instanceParentName() && !other.isInstance()) {
            grid->setTree(this->grid(parent)->baseTreePtr());
            return grid;
        }
    throw std::runtime_error(fmt::format("grid \"{}\" shares the voxels of a missing grid", name(i)));
}

std::string vdb_bytes(const openvdb::GridPtrVec& grids) {
    initialize_openvdb();
    std::ostringstream stream(std::ios::binary);
    OutputArchive archive;
    archive.setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    archive.write(stream, openvdb::GridCPtrVec(grids.begin(), grids.end()), /*seekable=*/true);
    if (!stream) throw std::runtime_error("the file could not be written to memory");
    std::string bytes = std::move(stream).str();
    if (!number_by_content(bytes)) throw std::runtime_error("the file has no UUID where one is expected");
    return bytes;
}

}  // namespace haarfield
