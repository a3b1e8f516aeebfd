#pragma once
/// Claims on work in a folder that processes and machines share, so that no two processes do the same work.
/// Correctness does not depend on claims: a process that cannot create one does the work, so at worst it is
/// done twice.

#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <chrono>
#include <filesystem>
#include <optional>
#include <thread>

namespace haarfield {

/// A file that names the process that created it. The process renews its modification time every few seconds.
class Claim {
public:
    /// Creates a claim. Waits while another process holds it. A process on this machine holds its claim while
    /// it runs and renews it, one on another machine while it renews it. (Intervals are measured with this
    /// process's clock, since the clocks of machines may differ.)
    ///
    /// file      must be in an existing folder.
    /// patience  the longest time without renewal.
    /// returns   the claim, or nothing if the folder does not support hard links.
    /// errors    those of the system (no such folder, no permission ...); `interrupted`.
    static Result<std::optional<Claim>> on(const std::filesystem::path& file, const Progress& progress = {},
                                           std::chrono::milliseconds patience = std::chrono::seconds(60));

    Claim(Claim&& other) noexcept;  ///< Takes ownership of the claim.
    Claim& operator=(Claim&&) = delete;
    ~Claim();  ///< Releases the claim.

private:
    Claim(std::filesystem::path file, int descriptor);

    std::filesystem::path file_;
    int descriptor_;         ///< -1: moved from.
    std::jthread renewing_;  ///< Renews the file.
};

/// The file name extension of claims.
inline constexpr const char* claim_ending = ".claim";

/// Removes all claims in a folder whose processes ran on this machine and have ended.
void remove_abandoned_claims(const std::filesystem::path& folder);

}  // namespace haarfield
