#include "fields/file/claim.h"

namespace haarfield {

Result<std::optional<Claim>> Claim::on(const std::filesystem::path&, const Progress&,
                                       std::chrono::milliseconds) {
    return std::optional<Claim>();
}

Claim::Claim(Claim&& other) noexcept = default;
Claim::~Claim() = default;

void remove_abandoned_claims(const std::filesystem::path&) {}

}  // namespace haarfield
