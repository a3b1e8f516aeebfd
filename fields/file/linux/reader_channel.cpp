#include "fields/file/linux/reader_channel.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

extern char** environ;

namespace haarfield {

int spawned_reader(const std::filesystem::path& program) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return -1;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    // Duplicated to another number, because dup2 onto the same number would leave close-on-exec set.
    const int moved = fcntl(ends[1], F_DUPFD_CLOEXEC, 10);
    posix_spawn_file_actions_adddup2(&actions, moved, 3);
    posix_spawn_file_actions_addclosefrom_np(&actions, 4);
    const std::string name = program.string();
    char* const arguments[] = {const_cast<char*>(name.c_str()), nullptr};
    pid_t id = -1;
    const int failure =
        moved < 0 ? errno : posix_spawn(&id, name.c_str(), &actions, nullptr, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (moved >= 0) ::close(moved);
    if (failure == 0) return ends[0];
    ::close(ends[0]);
    errno = failure;
    return -1;
}

bool send_request(int socket, const ReaderRequest& head, std::string_view details,
                  const std::array<int, 3>& descriptors) {
    iovec pieces[]{{const_cast<ReaderRequest*>(&head), sizeof head},
                   {const_cast<char*>(details.data()), details.size()}};
    alignas(cmsghdr) char control[CMSG_SPACE(sizeof descriptors)] = {};
    msghdr message{};
    message.msg_iov = pieces;
    message.msg_iovlen = 2;
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    cmsghdr* const rights = CMSG_FIRSTHDR(&message);
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(sizeof descriptors);
    std::memcpy(CMSG_DATA(rights), descriptors.data(), sizeof descriptors);
    ssize_t sent = 0;
    do sent = sendmsg(socket, &message, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    return sent >= 0;
}

}  // namespace haarfield
