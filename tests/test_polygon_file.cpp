#include "fields/model/polygon_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace haarfield {
namespace {

template <class T>
void append(std::string& bytes, T value, bool big_endian) {
    std::string raw(reinterpret_cast<const char*>(&value), sizeof value);
    if (big_endian) std::reverse(raw.begin(), raw.end());
    bytes += raw;
}

/// Returns two faces of three and four corners with five vertices, and other data to be skipped.
std::string example_ply(const std::string& form) {
    std::string bytes =
        "ply\r\nformat " + form +
        " 1.0\ncomment element of surprise\nobj_info none\nelement vertex 5\nproperty double x\n"
        "property float y\nproperty uchar red\nproperty short z\nproperty float nx\nproperty float ny\n"
        "property float nz\nelement tristrips 1\nproperty list int int vertex_indices\nelement face 2\n"
        "property uchar quality\nproperty list uchar uint vertex_index\nproperty list char double "
        "weights\nend_header\n";
    const bool big = form == "binary_big_endian";
    if (form == "ascii") {
        for (int v = 0; v < 5; ++v)
            bytes += std::to_string(v) + ".5 -1e0 255 " + std::to_string(-v) + " 0 +1 0\n";
        return bytes + "3 0 1 2\n7 3 0 1 2 0\n7 4 1 2\n3 4 2 .5 0.25\n";
    }
    for (int v = 0; v < 5; ++v) {
        append(bytes, v + 0.5, big);
        append(bytes, -1.0f, big);
        append(bytes, std::uint8_t(255), big);
        append(bytes, static_cast<std::int16_t>(-v), big);
        for (const float n : {0.0f, 1.0f, 0.0f}) append(bytes, n, big);
    }
    for (const std::int32_t strip : {3, 0, 1, 2}) append(bytes, strip, big);
    for (const std::uint32_t corners : {3u, 4u}) {
        append(bytes, std::uint8_t(7), big);
        append(bytes, static_cast<std::uint8_t>(corners), big);
        for (std::uint32_t c = 0; c < corners; ++c) append(bytes, c + corners - 3, big);
        append(bytes, static_cast<std::int8_t>(corners == 3 ? 0 : 2), big);
        if (corners == 4)
            for (const double weight : {0.5, 0.25}) append(bytes, weight, big);
    }
    return bytes;
}

TEST(PolygonFile, PlyIsReadAsTextAndInBothByteOrders) {
    for (const char* form : {"ascii", "binary_little_endian", "binary_big_endian"}) {
        const Result<PolygonFile> file = read_ply(example_ply(form));
        ASSERT_TRUE(file) << form << ": " << file.error().what;
        ASSERT_EQ(file->positions.size(), 5u) << form;
        for (int v = 0; v < 5; ++v) {
            const auto f = static_cast<float>(v);
            EXPECT_EQ(file->positions[static_cast<std::size_t>(v)], Vec3f(f + 0.5f, -1, -f)) << form;
            EXPECT_EQ(file->normals[static_cast<std::size_t>(v)], Vec3f(0, 1, 0)) << form;
        }
        EXPECT_EQ(file->face_corners, (std::vector<std::uint32_t>{3, 4})) << form;
        EXPECT_EQ(file->corners, (std::vector<std::uint32_t>{0, 1, 2, 1, 2, 3, 4})) << form;
    }
}

TEST(PolygonFile, PlyHasImageCoordinates) {
    using Names = std::pair<std::string, std::string>;
    for (const auto& [s, t] : {Names("s", "t"), Names("u", "v"), Names("texture_u", "texture_v")}) {
        const Result<PolygonFile> file = read_ply(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nproperty float " +
            t + "\nproperty float " + s +
            "\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0 .5 .25\n1 0 0 .5 .75\n0 1 0 1 .25\n3 0 1 2\n");
        ASSERT_TRUE(file) << file.error().what;
        EXPECT_EQ(file->uvs, (std::vector<Vec2f>{{0.25f, 0.5f}, {0.75f, 0.5f}, {0.25f, 1.0f}})) << s;
        EXPECT_TRUE(file->colours.empty());
    }
}

TEST(PolygonFile, PlyCutShortIsAnError) {
    for (const std::string form : {"ascii", "binary_little_endian", "binary_big_endian"}) {
        const std::string whole = example_ply(form);
        // The last number of a text may lose digits and stay valid.
        const std::size_t sizes = form == "ascii" ? whole.size() - 4 : whole.size();
        for (std::size_t size = 0; size < sizes; ++size)
            EXPECT_FALSE(read_ply(std::string_view(whole).substr(0, size))) << form << ' ' << size;
    }
}

std::string message_of(const Result<PolygonFile>& file) {
    return file ? "accepted" : file.error().what;
}

TEST(PolygonFile, PlyErrorsNameThePlace) {
    const std::string head =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    const auto with = [&](const std::string& from, const std::string& to, const std::string& body) {
        std::string text = head + body;
        text.replace(text.find(from), from.size(), to);
        return message_of(read_ply(text));
    };
    const std::string good = "0 0 0 1 0 0 0 1 0 3 0 1 2";
    EXPECT_EQ(with("ply", "ply", good), "accepted");
    EXPECT_NE(with("ply", "plx", good).find("begin"), std::string::npos);
    EXPECT_NE(with("ascii", "utf8", good).find("line 2"), std::string::npos);
    EXPECT_NE(with("vertex 3", "vertex 4000000000", good).find("line 3"), std::string::npos);
    EXPECT_NE(with("vertex 3", "vertex -3", good).find("line 3"), std::string::npos);
    EXPECT_NE(with("vertex 3", "vertex nan", good).find("line 3"), std::string::npos);
    EXPECT_NE(with("float x", "quad x", good).find("line 4"), std::string::npos);
    EXPECT_NE(with("uchar int", "uchar", good).find("line 8"), std::string::npos);
    EXPECT_NE(with("end_header\n", "", "").find("header"), std::string::npos);
    EXPECT_NE(with("ply", "ply", "0 0 0 1 0 0 0 one 0 3 0 1 2").find("vertex 2 of 3"), std::string::npos);
    EXPECT_NE(with("ply", "ply", "0 0 0 1 0 0 0 1 0 3 0 1 3").find("face 0 has the corner 3"),
              std::string::npos);
    EXPECT_NE(with("ply", "ply", "0 0 0 1 0 0 0 1 0 3 0 1 1.5").find("corner 1.5"), std::string::npos);
    EXPECT_NE(with("ply", "ply", "0 0 0 1 0 0 0 1 0 3 0 -1 2").find("corner -1"), std::string::npos);
    EXPECT_NE(with("ply", "ply", "0 0 0 1 0 0 0 1 0 4000000000 0 1 2").find("face 0 of 1"),
              std::string::npos);
}

TEST(PolygonFile, NumbersOutOfRangeAreInfiniteOrZero) {
    const Result<PolygonFile> file = read_off("OFF\n3 0 0\n1e999 -1e-999 nan\n1E+300 inf 0x7\n1 2 3\n");
    EXPECT_FALSE(file) << "0x7 is not a number";
    const Result<PolygonFile> other = read_off("OFF\n2 0 0\n1e999 1e-999 nan\n1E+300 inf 7\n");
    ASSERT_TRUE(other) << other.error().what;
    EXPECT_TRUE(std::isinf(other->positions[0].x) && std::isnan(other->positions[0].z));
    EXPECT_EQ(other->positions[0].y, 0);
    EXPECT_TRUE(std::isinf(other->positions[1].x) && std::isinf(other->positions[1].y));
}

TEST(PolygonFile, OffKnowsItsVariants) {
    const std::string faces = "3 0 1 2 255 0 0\n# a comment\n\n4 0 1 2 1 0.5\n";
    const struct {
        std::string text;
        bool normals;
    } variants[] = {
        {"OFF\n3 2 0\n0 0 0\n1 0 0\n0 2 0\n" + faces, false},
        {"OFF 3 2 0\r\n0 0 0\r\n1 0 0\r\n0 2 0\r\n" + faces, false},
        {"# first\nCOFF\n3 2\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 2 0 1 1 1 1\n" + faces, false},
        {"NOFF\n3 2 0\n0 0 0 0 0 2\n1 0 0 0 0 2\n0 2 0 0 0 2\n" + faces, true},
        {"STCNOFF\n3 2 0\n0 0 0 0 0 2 9 9\n1 0 0 0 0 2 9 9\n0 2 0 0 0 2 9 9\n" + faces, true},
        {"4OFF\n3 2 0\n0 0 0 1\n2 0 0 2\n0 1 0 .5\n" + faces, false},
    };
    for (const auto& [text, normals] : variants) {
        const Result<PolygonFile> file = read_off(text);
        ASSERT_TRUE(file) << text << file.error().what;
        EXPECT_EQ(file->positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}})) << text;
        EXPECT_EQ(file->normals, normals ? std::vector<Vec3f>(3, Vec3f(0, 0, 2)) : std::vector<Vec3f>())
            << text;
        EXPECT_EQ(file->face_corners, (std::vector<std::uint32_t>{3, 4})) << text;
        EXPECT_EQ(file->corners, (std::vector<std::uint32_t>{0, 1, 2, 0, 1, 2, 1})) << text;
    }
}

TEST(PolygonFile, OffErrorsNameTheLine) {
    for (const auto& [text, line] : {std::pair("", "line 0"),
                                     {"OF\n", "line 1"},
                                     {"nOFF\n3\n3 0 0\n", "line 2"},
                                     {"OFF BINARY\n", "line 1"},
                                     {"OFF\n3\n", "line 2"},
                                     {"OFF\n3000 1 0\n0 0 0\n", "line 2"},
                                     {"OFF\n1 1 0\n0 0\n", "line 3"},
                                     {"OFF\n1 1 0\n0 0 0\n\n#\n9 0\n", "line 6"},
                                     {"OFF\n1 1 0\n0 0 0\n3 0 0\n", "line 4"},
                                     {"OFF\n2 1 0\n0 0 0\n", "line 3"}})
        EXPECT_NE(message_of(read_off(text)).find(line), std::string::npos)
            << text << message_of(read_off(text));
    EXPECT_NE(message_of(read_off("OFF\n1 1 0\n0 0 0\n3 0 0 1\n")).find("corner 1"), std::string::npos);
}

}  // namespace
}  // namespace haarfield
