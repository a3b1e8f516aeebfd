// haarfield-reader: reads untrusted files for programs that use haarfield's libraries, which start it.

#include <sys/socket.h>
#include <sys/stat.h>

#include <array>
#include <cstdio>

#include "fields/field/field_grids.h"
#include "fields/model/assimp_content.h"
#include "fields/vdb/vdb_file.h"
#include "scenes/image_reader.h"

int main() {
    constexpr int socket = 3;  // the parent process leaves it there
    struct stat status {};
    if (fstat(socket, &status) != 0 || !S_ISSOCK(status.st_mode)) {
        std::fputs(
            "haarfield-reader reads files for programs that use haarfield's libraries; do not start it "
            "directly\n",
            stderr);
        return 2;
    }
    const std::array tasks{haarfield::model_reader_task(), haarfield::image_reader_task(),
                           haarfield::field_reader_task(), haarfield::vdb_reader_task()};
    haarfield::serve_reader_process(socket, tasks);
}
