#pragma once
/// The socket between a reader process and its client. Internal.

#include <array>
#include <filesystem>
#include <string_view>

#include "fields/file/linux/reader_message.h"

namespace haarfield {

/// Starts `program` with one end of a socket as its descriptor 3. Returns the other end, or -1 and errno.
int spawned_reader(const std::filesystem::path& program);

/// Sends a request with its details and the descriptors of file, answer and outcome. False and errno on
/// failure.
bool send_request(int socket, const ReaderRequest& head, std::string_view details,
                  const std::array<int, 3>& descriptors);

}  // namespace haarfield
