/// Writes the meshes of the shipped scenes: haarfield_furniture OUTPUT_FOLDER

#include "scenes/furniture.h"
#include "scenes/modelling.h"

#include <fmt/format.h>
#include <cstdio>
#include <filesystem>
#include <fstream>

int main(int argc, char** argv) {
    using namespace haarfield;
    if (argc != 2) {
        fmt::print(stderr, "usage: haarfield_furniture OUTPUT_FOLDER\n");
        return 2;
    }
    const std::filesystem::path folder(argv[1]);
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);
    for (const auto& [name, mesh] : {std::pair<const char*, Mesh>{"table.obj", table_mesh()},
                                     {"chair.obj", chair_mesh()},
                                     {"floor.obj", floor_mesh()}}) {
        std::ofstream out(folder / name, std::ios::binary);
        out << obj_text(mesh) << std::flush;
        if (!out) {
            fmt::print(stderr, "{}: could not be written\n", (folder / name).string());
            return 1;
        }
    }
    return 0;
}
