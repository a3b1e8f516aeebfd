// haarfield-image-reader: reads images for haarfield-reader, which starts it.

#include <array>

#include "fields/file/reader_program.h"
#include "scenes/image_reader.h"

int main() {
    const std::array tasks{haarfield::image_reader_task()};
    return haarfield::run_reader_program("haarfield-image-reader", tasks);
}
