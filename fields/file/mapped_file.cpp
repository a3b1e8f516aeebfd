#include "fields/file/mapped_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace haarfield {

namespace {

Error failure(const std::string& where, int number) {
    return {where, fmt::format("cannot be read: {}", std::strerror(number))};
}

}  // namespace

Result<MappedFile> mapped_file(const std::filesystem::path& file, MappedPages pages) {
    // Without O_NONBLOCK a pipe would keep us waiting for its writer.
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0) return failure(file.string(), errno);
    Result<MappedFile> mapped = mapped_file(descriptor, file.string(), pages);
    close(descriptor);
    return mapped;
}

Result<MappedFile> mapped_file(int descriptor, const std::string& where, MappedPages pages) {
    struct stat status {};
    if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return Error{where, "not a file"};
    const auto size = static_cast<std::size_t>(status.st_size);
    if (size == 0) return MappedFile{};
    const int flags = MAP_PRIVATE | (pages == MappedPages::now ? MAP_POPULATE : 0);
    void* const address = mmap(nullptr, size, PROT_READ, flags, descriptor, 0);
    if (address == MAP_FAILED) return failure(where, errno);
    return MappedFile{{static_cast<const char*>(address), size},
                      {address, [size](const void* mapped) { munmap(const_cast<void*>(mapped), size); }}};
}

}  // namespace haarfield
