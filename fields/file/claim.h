#pragma once
/// Who is at work on what, in a folder that processes and machines share: so that none does what another one
/// does already. Nothing else rests on it; whoever can make no claim does the work, and at worst it is done
/// twice.

#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <chrono>
#include <filesystem>
#include <optional>
#include <thread>

namespace haarfield {

/// A file that names the process that made it, and whose time of writing that process renews every few
/// seconds while it lives.
class Claim {
public:
    /// Waits while another one has the claim: while its process runs on this machine and renews it, or, of
    /// another machine, while it is renewed. (That is watched by this process's clock; those of the machines
    /// may differ.)
    ///
    /// file      its folder is there.
    /// patience  how long a claim may go without being renewed.
    /// returns   the claim; nothing where the folder knows no hard links, so that there can be none.
    /// errors    what the system says (no such folder, no right to write ...); `interrupted`.
    static Result<std::optional<Claim>> on(const std::filesystem::path& file, const Progress& progress = {},
                                           std::chrono::milliseconds patience = std::chrono::seconds(60));

    Claim(Claim&& other) noexcept;  ///< Takes it over.
    Claim& operator=(Claim&&) = delete;
    ~Claim();  ///< Gives it up.

private:
    Claim(std::filesystem::path file, int descriptor);

    std::filesystem::path file_;
    int descriptor_;         ///< -1: moved from.
    std::jthread renewing_;  ///< Of descriptor_.
};

/// The ending of claims' names.
inline constexpr const char* claim_ending = ".claim";

/// Removes the claims in a folder of this machine's processes that have ended.
void remove_abandoned_claims(const std::filesystem::path& folder);

}  // namespace haarfield
