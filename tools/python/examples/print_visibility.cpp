// Prints the visibility at the planar sample of a field that is nearest to a point, as a picture of six faces
// (PGM). Needs OpenVDB alone. fields/field/README.md specifies the grids. Build and use:
//   g++ -std=c++20 print_visibility.cpp -lopenvdb -o print_visibility
//   ./print_visibility FIELD.vdb X Z > faces.pgm
#include <openvdb/openvdb.h>

using openvdb::Int32Grid;

// Returns value i of a grid in linear order.
std::uint32_t value(const Int32Grid::Ptr& grid, std::uint64_t i) {
    const auto bits = [i](int first, int count) { return int(i >> first & ((1u << count) - 1)); };
    return std::uint32_t(grid->tree().getValue({bits(6, 3) | bits(17, 4) << 3 | bits(31, 5) << 7,
                                                bits(3, 3) | bits(13, 4) << 3 | bits(26, 5) << 7,
                                                bits(0, 3) | bits(9, 4) << 3 | bits(21, 5) << 7}));
}

int main(int count, char** arguments) {
    if (count != 4) return std::fputs("usage: print_visibility FIELD.vdb X Z\n", stderr), 2;
    openvdb::initialize();
    openvdb::io::File file(arguments[1]);
    file.open(false);
    const auto grid = [&](const auto& name) { return openvdb::gridPtrCast<Int32Grid>(file.readGrid(name)); };
    const auto planar = grid("planar_handles"), cubemaps = grid("cubemaps"), faces = grid("faces");
    std::vector<Int32Grid::Ptr> nodes;  // 2^20 values of four bytes each
    while (file.hasGrid("nodes_" + std::to_string(nodes.size())))
        nodes.push_back(grid("nodes_" + std::to_string(nodes.size())));
    const auto byte = [&](std::uint64_t i) {
        return std::uint8_t(value(nodes[i >> 22], i >> 2 & 0xfffff) >> (8 * (i & 3)));
    };

    // The ring and the angle of the nearest sample.
    const auto centre = planar->metaValue<openvdb::Vec3s>("haarfield_centre");
    const int rings = planar->metaValue<int>("haarfield_rings"),
              angles = planar->metaValue<int>("haarfield_angles");
    const double outer = planar->metaValue<float>("haarfield_outer_radius"),
                 growth = planar->metaValue<float>("haarfield_growth"), turn = 2 * std::acos(-1.0);
    const double x = std::atof(arguments[2]) - centre.x(), z = std::atof(arguments[3]) - centre.z();
    const double t = std::log1p(std::hypot(x, z) / outer * std::expm1(growth)) / growth;
    const int ring = int(std::lround(std::fmin(t, 1) * (rings - 1))),
              angle = int(std::lround(std::atan2(z, x) / turn * angles) + angles) % angles;
    const int handle = planar->tree().getValue({ring, angle, 0});  // -1: unoccluded

    const int size = cubemaps->metaValue<int>("haarfield_face_size");
    std::printf("P2\n# faces +x -x +y -y +z -z, from top to bottom\n%d %d\n255\n", size, 6 * size);
    struct Square {
        int x, y, width;
        float mean;
    };
    for (int side = 0; side < 6; ++side) {
        std::vector<float> texels(std::size_t(size) * size, 1.0f);
        std::vector<Square> squares;  // those with wavelets, in level order
        std::uint64_t at = 0;         // the byte of the next node
        if (handle >= 0) {
            const std::uint64_t face = 3 * std::uint64_t(value(cubemaps, 6 * std::uint64_t(handle) + side));
            at = value(faces, face) | std::uint64_t(value(faces, face + 1)) << 32;
            const int half = int(value(faces, face + 2) >> 16), exponent = half >> 10;  // not negative
            const float mean =
                std::ldexp(float(half % 1024 + (exponent ? 1024 : 0)), std::max(exponent, 1) - 25);
            texels.assign(texels.size(), mean);
            if (value(faces, face + 2) & 0xffff) squares.push_back({0, 0, size, mean});
        }
        for (std::size_t n = 0; n < squares.size(); ++n) {
            const Square square = squares[n];
            const int head = byte(at++), width = square.width / 2;
            float wavelet[3] = {};  // along x, along y, diagonal
            for (int k = 0; k < 3; ++k)
                if (head >> (4 + k) & 1) wavelet[k] = float(std::int8_t(byte(at++))) * 0.5f / 127;
            for (int q = 0; q < 4; ++q) {
                const float mean = square.mean + wavelet[0] * (q % 2 ? -1 : 1) +
                                   wavelet[1] * (q / 2 ? -1 : 1) + wavelet[2] * (q % 3 ? -1 : 1);
                squares.push_back({square.x + q % 2 * width, square.y + q / 2 * width, width, mean});
                for (int i = 0; i < width * width; ++i)
                    texels[std::size_t(size) * (squares.back().y + i / width) + squares.back().x +
                           i % width] = mean;
                if (!(head >> q & 1)) squares.pop_back();
            }
        }
        for (const float v : texels) std::printf("%ld\n", std::lround(255 * std::fmin(std::fmax(v, 0), 1)));
    }
}
