#include "fields/file/mapped_file.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "fields/file/input_file.h"

namespace haarfield {

namespace {

Error failure(const std::string& where, int number) {
    return {where, fmt::format("cannot be read: {}", std::strerror(number))};
}

/// [bytes]
std::uint64_t machine_memory() {
    return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
           static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

Result<MappedFile> mapped_file(const std::filesystem::path& file, MappedPages pages) {
    HF_TRY(const InputFile opened, InputFile::open(file));
    return mapped_file(opened.descriptor(), file.string(), pages);
}

Result<MappedFile> mapped_file(int descriptor, const std::string& where, MappedPages pages) {
    struct stat status {};
    if (fstat(descriptor, &status) != 0) return failure(where, errno);
    if (!S_ISREG(status.st_mode)) return Error{where, "is not a regular file"};
    const auto size = static_cast<std::size_t>(status.st_size);
    if (size == 0) return MappedFile{};
    void* const address = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (address == MAP_FAILED) return failure(where, errno);
    MappedFile mapped{{static_cast<const char*>(address), size},
                      {address, [size](const void* bytes) { munmap(const_cast<void*>(bytes), size); }}};
    if (pages == MappedPages::as_read) return mapped;
    HF_TRY_DONE(load_pages(mapped, where));
    return mapped;
}

Result<Done> load_pages(const MappedFile& file, const std::string& where) {
    if (file.bytes.size() > machine_memory())
        return Error{where, fmt::format("has {} bytes; this machine has memory for {}", file.bytes.size(),
                                        machine_memory())};
#ifdef MADV_POPULATE_READ
    // Only for speed: pages that are not loaded here are loaded on access.
    if (!file.bytes.empty())
        madvise(const_cast<char*>(file.bytes.data()), file.bytes.size(), MADV_POPULATE_READ);
#endif
    return Done{};
}

void release_pages(std::string_view bytes) {
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const auto address = reinterpret_cast<std::uintptr_t>(bytes.data());
    const std::uintptr_t first = (address + page - 1) / page * page,
                         end = (address + bytes.size()) / page * page;
    // Only for memory: a failure has no other effect.
    if (first < end) madvise(const_cast<char*>(bytes.data()) + (first - address), end - first, MADV_DONTNEED);
}

}  // namespace haarfield
