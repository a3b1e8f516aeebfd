#include "fields/file/reader_process.h"

#include <atomic>
#include <cstdlib>

namespace haarfield {
namespace {

std::atomic<bool> may_be_unsandboxed = false;

Error no_reader(const std::string& where) {
    return {where, "this system has no reader process for untrusted files"};
}

}  // namespace

ReaderLimits reader_limits(std::uint64_t, double) {
    return {};
}

Result<Done> fork_reader_process(std::span<const ReaderTask>) {
    return Done{};
}

void serve_reader_process(int, std::span<const ReaderTask>) {
    std::abort();  // haarfield-reader is not built
}

void allow_unsandboxed_readers() {
    may_be_unsandboxed = true;
}

Result<bool> reads_apart() {
    if (!may_be_unsandboxed)
        return Error{"",
                     "there is no sandbox for untrusted files on this system; to read it without a sandbox, "
                     "if you trust it, " +
                         std::string(unsandboxed_remedy)};
    return false;
}

Result<MappedFile> read_apart(std::string_view, int, std::string_view, const ReaderLimits&,
                              const std::string& where) {
    return no_reader(where);
}

Result<MappedFile> read_apart(std::string_view, std::string_view, std::string_view, const ReaderLimits&,
                              const std::string& where) {
    return no_reader(where);
}

}  // namespace haarfield
