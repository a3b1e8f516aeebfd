// haarfield-reader: reads untrusted files for programs that use haarfield's libraries, which start it.

#include <array>

#include "fields/field/field_grids.h"
#include "fields/file/reader_program.h"
#include "fields/file/this_process.h"
#include "fields/model/assimp_content.h"
#include "fields/vdb/vdb_file.h"

int main() {
    using namespace haarfield;
    const std::array tasks{model_reader_task(), field_reader_task(), vdb_reader_task()};
    return run_reader_program("haarfield-reader", tasks,
                              running_program().parent_path() / "haarfield-image-reader");
}
