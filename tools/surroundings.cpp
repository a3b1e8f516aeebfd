#include "tools/surroundings.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

namespace haarfield {

void tidy_surroundings() {
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    int opened = 0;
    do opened = open("/dev/null", O_RDWR);
    while (opened >= 0 && opened <= STDERR_FILENO);
    if (opened >= 0) close(opened);
}

}  // namespace haarfield
