#include "fields/file/mapped_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace haarfield {

Result<MappedFile> mapped_file(const std::filesystem::path& file, MappedPages pages) {
    const auto failure = [&](int number) {
        return Error{file.string(), fmt::format("cannot be read: {}", std::strerror(number))};
    };
    // Without O_NONBLOCK a pipe would keep us waiting for its writer.
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0) return failure(errno);
    struct stat status {};
    if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
        close(descriptor);
        return Error{file.string(), "not a file"};
    }
    const auto size = static_cast<std::size_t>(status.st_size);
    if (size == 0) {
        close(descriptor);
        return MappedFile{};
    }
    const int flags = MAP_PRIVATE | (pages == MappedPages::now ? MAP_POPULATE : 0);
    void* const address = mmap(nullptr, size, PROT_READ, flags, descriptor, 0);
    const int number = errno;
    close(descriptor);
    if (address == MAP_FAILED) return failure(number);
    return MappedFile{{static_cast<const char*>(address), size},
                      {address, [size](const void* mapped) { munmap(const_cast<void*>(mapped), size); }}};
}

}  // namespace haarfield
