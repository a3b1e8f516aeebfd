#include "tests/fuzz/fuzz_inputs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace haarfield {
namespace {

/// Values that often reveal errors in readers.
constexpr std::array<std::uint64_t, 14> odd_numbers{0,          1,
                                                    2,          0x7f,
                                                    0xff,       0x7fff,
                                                    0xffff,     0x7fffffff,
                                                    0x80000000, 0xfffffffe,
                                                    0xffffffff, 0x7fffffffffffffff,
                                                    ~0ull,      0x7ff0000000000000};

constexpr std::array<std::string_view, 16> odd_texts{
    "0",    "-1",   "1e999", "-1e-999",    "nan",         "inf",        "2147483647",           "4294967295",
    "1e38", "0x7f", "9",     "1000000007", "-2147483649", "3000000000", "18446744073709551615", "0.1e"};

struct Piece {
    std::size_t begin, size;
};

Piece random_piece(const std::string& bytes, FuzzRandom& random, std::size_t first) {
    const std::size_t begin = first + random_index(random, bytes.size() - first);
    const std::size_t most = std::min<std::size_t>(bytes.size() - begin, 1 + random_index(random, 64));
    return {begin, most};
}

void put(std::string& bytes, std::size_t at, std::string_view piece) {
    std::memcpy(bytes.data() + at, piece.data(), std::min(piece.size(), bytes.size() - at));
}

/// Applies a change that preserves the size.
void damage_in_place(std::string& bytes, FuzzRandom& random, std::string_view other, std::size_t first) {
    const Piece piece = random_piece(bytes, random, first);
    char& byte = bytes[piece.begin];
    switch (random_index(random, 5)) {
        case 0: byte = static_cast<char>(byte ^ (1 << random_index(random, 8))); break;
        case 1: byte = static_cast<char>(random()); break;
        case 2: {
            const std::uint64_t number = odd_numbers[random_index(random, odd_numbers.size())];
            const std::size_t size = std::size_t(1) << random_index(random, 4);
            put(bytes, piece.begin, std::string_view(reinterpret_cast<const char*>(&number), size));
            break;
        }
        case 3:
            put(bytes, first + random_index(random, bytes.size() - first),
                std::string(bytes, piece.begin, piece.size));
            break;
        case 4:
            if (!other.empty())
                put(bytes, piece.begin, other.substr(random_index(random, other.size()), piece.size));
            break;
    }
}

/// Replaces a number in a text.
void change_number(std::string& bytes, FuzzRandom& random, std::size_t first) {
    constexpr std::string_view digits = "0123456789";
    const std::size_t begin = bytes.find_first_of(digits, first + random_index(random, bytes.size() - first));
    if (begin == std::string::npos) return;
    const std::size_t end = std::min(bytes.find_first_not_of("0123456789.eE", begin), bytes.size());
    bytes.replace(begin, end - begin, odd_texts[random_index(random, odd_texts.size())]);
}

void damage_once(std::string& bytes, FuzzRandom& random, std::string_view other,
                 const std::vector<std::string_view>& dictionary, std::size_t first) {
    const Piece piece = random_piece(bytes, random, first);
    switch (random_index(random, 10)) {
        case 0:
            if (random_index(random, 8) == 0) bytes.resize(piece.begin);
            break;
        case 1: bytes.erase(piece.begin, piece.size); break;
        case 2: bytes.insert(piece.begin, std::string(bytes, piece.begin, piece.size)); break;
        case 3: bytes.insert(piece.begin, std::string(piece.size, static_cast<char>(random()))); break;
        case 4:
        case 5: change_number(bytes, random, first); break;
        case 6:
            if (!dictionary.empty())
                bytes.insert(piece.begin, dictionary[random_index(random, dictionary.size())]);
            break;
        default: damage_in_place(bytes, random, other, first);
    }
}

template <class T>
void append(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

constexpr std::array<std::array<float, 3>, 4> corners{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
constexpr std::array<std::array<std::uint32_t, 3>, 4> faces{{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};

std::string binary_ply() {
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\ncomment a tetrahedron\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nproperty uchar red\nelement face 4\n"
        "property list uchar int vertex_indices\nend_header\n";
    for (const auto& corner : corners) {
        for (const float x : corner) append(bytes, x);
        append(bytes, std::uint8_t(200));
    }
    for (const auto& face : faces) {
        append(bytes, std::uint8_t(3));
        for (const std::uint32_t index : face) append(bytes, index);
    }
    return bytes;
}

std::string binary_stl() {
    std::string bytes(80, ' ');
    append(bytes, std::uint32_t(faces.size()));
    for (const auto& face : faces) {
        for (int k = 0; k < 3; ++k) append(bytes, 0.0f);
        for (const std::uint32_t index : face)
            for (const float x : corners[index]) append(bytes, x);
        append(bytes, std::uint16_t(0));
    }
    return bytes;
}

std::string text_stl() {
    std::string text = "solid tetrahedron\n";
    for (const auto& face : faces) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (const std::uint32_t index : face) {
            text += "vertex";
            for (const float x : corners[index]) text += x == 0 ? " 0.0" : " 1.0e0";
            text += '\n';
        }
        text += "endloop\nendfacet\n";
    }
    return text + "endsolid tetrahedron\n";
}

/// Returns a file with two nodes, 16 bit indices and a material.
std::string gltf_json(std::string_view buffer) {
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,)"
           R"("translation":[0,5,0],"scale":[-2,1,1]},{"mesh":0,"rotation":[0,0,0,1]}],)"
           R"("materials":[{"name":"clay"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},)"
           R"("indices":1,"material":0}]}],"buffers":[{"byteLength":44)" +
           std::string(buffer) +
           R"(}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],)"
           R"("max":[1,1,0]},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]})";
}

std::string gltf_buffer() {
    std::string bytes;
    for (int corner = 0; corner < 3; ++corner)
        for (const float x : corners[static_cast<std::size_t>(corner)]) append(bytes, x);
    for (const std::uint16_t index : {0, 1, 2, 0}) append(bytes, index);
    return bytes;
}

std::string glb() {
    std::string json = gltf_json(""), buffer = gltf_buffer(), bytes = "glTF";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    append(bytes, std::uint32_t(2));
    append(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + buffer.size()));
    append(bytes, static_cast<std::uint32_t>(json.size()));
    bytes += "JSON" + json;
    append(bytes, static_cast<std::uint32_t>(buffer.size()));
    return bytes + std::string("BIN\0", 4) + buffer;
}

}  // namespace

void damage(std::string& bytes, FuzzRandom& random, std::string_view other,
            const std::vector<std::string_view>& dictionary, std::size_t first, bool same_size) {
    do {
        if (bytes.size() <= first) return;
        if (same_size)
            damage_in_place(bytes, random, other, first);
        else
            damage_once(bytes, random, other, dictionary, first);
    } while (random_index(random, 3) != 0);
}

/// Returns a file with a triangle with vertex colours, and a material with a transformed embedded image.
std::string example_textured_gltf() {
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0},{"mesh":0,"scale":[2,-1,1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2},"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},{"bufferView":2,"componentType":5126,"count":3,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":0,"byteLength":24},
{"buffer":0,"byteOffset":0,"byteLength":36}],
"images":[{"uri":"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="}],
"samplers":[{}],"textures":[{"source":0,"sampler":0}],"extensionsUsed":["KHR_texture_transform"],
"materials":[{"name":"a","alphaMode":"MASK","alphaCutoff":0.25,"emissiveFactor":[0,0.5,1],"pbrMetallicRoughness":
{"baseColorFactor":[0.75,0.5,0.25,1],"metallicFactor":0.5,"roughnessFactor":0.125,"baseColorTexture":{"index":0,"extensions":
{"KHR_texture_transform":{"offset":[0.3,-0.2],"rotation":0.7,"scale":[2,0.5]}}}}}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
}

std::vector<std::string> example_mesh_files(std::string_view ending) {
    const std::string table = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    if (ending == "obj")
        return {
            "mtllib box.mtl\no box\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
            "f 4 3 2 1\nf 5 6 7 8\nusemtl lid\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n",
            "v -.5 0 0 1\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\ng a b\ns 1\nf 1/1/1 2/1/1 3/1/1\nf -3//1 -2//1 "
            "-1//1\nf 1/1 2/1 \\\n3/1\nl 1 2\np 3\n# end\n"};
    if (ending == "ply")
        return {
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty double y\nproperty float "
            "z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n" +
                table,
            binary_ply()};
    if (ending == "stl") return {text_stl(), binary_stl()};
    if (ending == "off")
        return {"OFF\n4 4 6\n" + table,
                "NOFF\n# normals\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"};
    if (ending == "gltf")
        return {example_textured_gltf(),
                gltf_json(R"(,"uri":"data:application/octet-stream;base64,)"
                          R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA=")")};
    if (ending == "glb") return {glb()};
    if (ending == "inc")
        return {
            "#ifndef (Done)\n#declare Done = 1;\n#declare Box = mesh2 {\nvertex_vectors { 4, <0,0,0>, x, <0, "
            "1.0, 0>, "
            "<0,0,1e0> }\nnormal_vectors { 1 <0,-.5,2> }\n#declare Red = texture { pigment { rgb x } }\n"
            "texture_list { 2, texture { Red }, texture { pigment { rgb 1 } } }\nface_indices { 4, "
            "<0,2,1>,0, "
            "<0,1,3>,1, <1,2,3>,0,1,0, <2,0,3> }\nnormal_indices { 1 <0,0,0> }\nhollow off rotate -30*y\n"
            "matrix <1,0,0, 0,0,1, 0,-1,0, 1,2,3> }\n#end\nunion { object { Box scale -1 material { M } } "
            "object "
            "{ Box }\n/* a /* b */ c */ translate <1,2,3> }\n",
            "mesh2 { vertex_vectors { 3 <0,0,0> <1,0,0> <0,1,0> } uv_vectors { 3 <0,0> <1,0> <0,1> } // "
            "plain\n"
            "face_indices { 1 <0,1,2> } }\n"};
    return {};
}

const std::vector<std::string_view>& mesh_words() {
    static const std::vector<std::string_view> words{"\nv 0 0 0",
                                                     "\nf 1 2 3 4 5",
                                                     "\nf -1/-1/-1",
                                                     "\nvt 1 1 1",
                                                     "\nusemtl x",
                                                     "\nmtllib /dev/zero",
                                                     "\nmtllib .",
                                                     "\nelement vertex 9",
                                                     "\nproperty list int int x",
                                                     "\nproperty float",
                                                     "\nelement edge 3",
                                                     "facet",
                                                     "endloop",
                                                     "OFF",
                                                     "4OFF",
                                                     "STOFF",
                                                     "mesh2 {",
                                                     "object { Box",
                                                     "#declare Box = union {",
                                                     "scale 0",
                                                     "#if (1)",
                                                     "#end",
                                                     "#ifdef (Box)",
                                                     "/*",
                                                     "*/",
                                                     "}",
                                                     "\"uri\":\"/dev/zero\"",
                                                     "\"byteOffset\":4294967295",
                                                     "\"byteStride\":0",
                                                     "\"sparse\":{\"count\":9}",
                                                     "\"children\":[0]",
                                                     "[[[[[[[[[[[[[[[[",
                                                     "\"indices\":0",
                                                     "\"mode\":5",
                                                     "\"skin\":0",
                                                     "{}",
                                                     ",",
                                                     "\n"};
    return words;
}

const std::vector<std::string_view>& scene_words() {
    static const std::vector<std::string_view> words{"\n[[instances]]\n",
                                                     "\n[camera]\n",
                                                     "entity = \"table\"\n",
                                                     "[[[[[[[[[[[[[[[[[[[[",
                                                     "{a={a={a={a=",
                                                     "\"\"\"",
                                                     "\\u0000",
                                                     "nan",
                                                     "inf",
                                                     "1979-05-27T07:32:00Z",
                                                     "= [",
                                                     ".x",
                                                     "sky = {}",
                                                     "image = \"/dev/zero\"\n",
                                                     "mesh = \"/\"\n",
                                                     "fine_vertices = 9999999999\n",
                                                     "\xff",
                                                     "\n"};
    return words;
}

std::vector<std::string> example_scene_files() {
    return {R"([camera]
position = [3.2, 1.8, 4]
target = [0.0, 0.5, 0.0]
vertical_fov = 35.0
resolution = [640, 480]
[environment]
sky = { turbidity = 3, sun_elevation = 40, sun_azimuth = 90, sun_angular_radius = 0.5, ground = [0.2, 0.2, 0.1] }
rotation = 90
exposure = -1.5
[materials.lacquer]
diffuse = [0.25, 0.08, 0.04]
specular = [0.3, 0.3, 0.3]
shininess = 60
convention = "povray"
[materials.cloth]
diffuse = [1, 0, 0.5]
[entities.table]
mesh = "box.obj"
material = "lacquer"
materials = { seat = "cloth" }
fine_vertices = 25000
coarse_triangles = 0
planar_samples = 200
spherical_samples = 100
[[instances]]
entity = "table"
translate = [0.0, -1, 0.5]
scale = 2
rotate = [0, 90, 0]
[[instances]]
entity = "table"
scale = [2, -0.5, 1]
[[instances]]
entity = "table"
matrix = [[1, 0.5, 0, 2], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]
)",
            R"(camera.position = [0, 1, 2]
camera.target = [0, 0, 0]
[environment]
image = "light.exr"
[materials.clay]
diffuse = [0.5, 0.5, 0.5]
[entities.box]
mesh = "box.obj"
material = "clay"
[[instances]]
entity = "box"
)"};
}

}  // namespace haarfield
