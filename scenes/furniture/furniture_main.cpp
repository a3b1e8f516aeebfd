/// Writes the meshes of the shipped scenes: haarfield_furniture OUTPUT_FOLDER

#include "fields/file/write_file.h"
#include "scenes/furniture/furniture.h"
#include "scenes/furniture/modelling.h"

#include <fmt/format.h>
#include <cstdio>
#include <filesystem>
#include <fstream>

int main(int argc, char** argv) {
    using namespace haarfield;
    if (argc != 2) {
        std::fputs("usage: haarfield_furniture OUTPUT_FOLDER\n", stderr);
        return 2;
    }
    const std::filesystem::path folder(argv[1]);
    Result<Done> written = make_folder(folder);
    for (const auto& [name, mesh] : {std::pair<const char*, Mesh>{"table.obj", table_mesh()},
                                     {"chair.obj", chair_mesh()},
                                     {"floor.obj", floor_mesh()},
                                     {"parquet.obj", parquet_mesh()},
                                     {"room.obj", room_mesh()}}) {
        if (written) written = write_file(folder / name, obj_text(mesh));
    }
    if (written) return 0;
    std::fputs((written.error().message() + "\n").c_str(), stderr);
    return 1;
}
