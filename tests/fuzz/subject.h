#pragma once
/// The files that haarfield_fuzz reads: kinds of files, and the requirements on their readers.

#include <filesystem>
#include <string>

#include "fields/base/result.h"
#include "tests/fuzz/fuzz_inputs.h"

namespace haarfield {

/// The outcome of reading a file.
struct Outcome {
    bool accepted = false;
    bool contained = false;  ///< The file crashed its reader process.

    /// Records a rejection. Returns a defect of its error, or an empty string.
    std::string refused(const Error& error) {
        for (const char* end : {"its reader ended", "took longer", "needs more memory"})
            contained |= error.what.find(end) != std::string::npos;
        // Files may crash workers, but not the process that starts them. Without it, all files are refused.
        for (const char* end : {"the reader process has ended", "reach the reader process"})
            if (error.what.find(end) != std::string::npos) return "refused without reading: " + error.what;
        return error.what.empty() ? "refused without a reason" : "";
    }
};

/// A kind of file, and the requirements on reading it.
class Subject {
public:
    virtual ~Subject() = default;
    virtual std::string file_name() const = 0;
    virtual std::string input(FuzzRandom& random) = 0;
    virtual unsigned seconds() const { return 5; }          ///< Processor time per file.
    virtual unsigned clock_seconds() const { return 120; }  ///< Wall time per file.

    /// Reads the file and sets the outcome. Returns the violated requirement, or an empty string.
    virtual std::string objection(const std::filesystem::path& file, Outcome& outcome) = 0;
};

}  // namespace haarfield
