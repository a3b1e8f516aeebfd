#pragma once
/// What haarfield_fuzz reads: a kind of file, and what its reader may not do.

#include <filesystem>
#include <string>

#include "fields/base/result.h"
#include "tests/fuzz/fuzz_inputs.h"

namespace haarfield {

/// What became of a file.
struct Outcome {
    bool accepted = false;
    bool contained = false;  ///< Took its reader down, in a process of its own.

    /// Why it was refused. Returns what is wrong with that.
    std::string refused(const Error& error) {
        for (const char* end : {"its reader ended", "took longer", "wants more memory"})
            contained |= error.what.find(end) != std::string::npos;
        return error.what.empty() ? "refused without a reason" : "";
    }
};

/// A kind of file, and what reading it may not do.
class Subject {
public:
    virtual ~Subject() = default;
    virtual std::string file_name() const = 0;
    virtual std::string input(FuzzRandom& random) = 0;
    virtual unsigned seconds() const { return 5; }  ///< Of the processor, for one file.

    /// Reads the file; sets the outcome. Returns what is wrong with that; nothing if all is well.
    virtual std::string objection(const std::filesystem::path& file, Outcome& outcome) = 0;
};

}  // namespace haarfield
