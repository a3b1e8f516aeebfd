#include "fields/file/reader_process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <thread>

#include "fields/base/sanitizers.h"
#include "fields/model/assimp_content.h"
#include "fields/model/mesh_reader.h"
#include "scenes/image.h"
#include "scenes/image_reader.h"
#include "tests/fixtures/test_folder.h"
#include "tests/fuzz/fuzz_inputs.h"

namespace haarfield {
namespace {

/// A reader that executes the instruction in its file.
Result<Done> obey(std::string_view bytes, std::string_view details, ByteSink& answer) {
    if (bytes == "crash") raise(SIGSEGV);
    if (bytes == "abort") std::abort();
    if (bytes == "exit") _exit(0);
    if (bytes == "throw") throw std::runtime_error("thrown words");
    if (bytes == "refuse") return Error{"nowhere", "refused words"};
    if (bytes == "sleep") sleep(100);
    if (bytes == "think")
        for (std::atomic<int> i = 0;; ++i) {
        }
    if (bytes == "grow") {
        std::vector<std::vector<char>> much;
        while (true) much.emplace_back(std::size_t(1) << 26, 'x');
    }
    if (bytes == "answer")
        for (const std::string piece(std::size_t(1) << 20, 'x');;) answer.bytes(piece);
    if (bytes == "rights") {
        const std::string file(details);
        answer.value(open(file.c_str(), O_WRONLY | O_CREAT, 0600) >= 0);
        answer.value(unlink(file.c_str()) == 0);
        answer.value(socket(AF_INET, SOCK_STREAM, 0) >= 0);
        answer.value(fork() >= 0);
        bool has_thread = false;
        std::thread([&] { has_thread = true; }).join();
        answer.value(!has_thread);
        return Done{};
    }
    answer.text(details);
    answer.values(std::vector<char>(bytes.begin(), bytes.end()));
    return Done{};
}

/// Tests of a reader process for the process of all these tests. Other tests then use it, too.
class ReaderProcess : public testing::Test {
protected:
    static void SetUpTestSuite() {
        static constexpr std::size_t count = 3;
        static const std::array<ReaderTask, count> tasks{model_reader_task(), image_reader_task(),
                                                         ReaderTask{"obey", obey}};
        started() = fork_reader_process(tasks).operator bool();
    }
    void SetUp() override {
        const Result<bool> apart = reads_apart();
        if (!started() || !apart || !*apart) GTEST_SKIP() << "this platform cannot fork a process";
    }
    static bool& started() {
        static bool value = false;
        return value;
    }

    static constexpr ReaderLimits little{std::uint64_t(256) << 20, std::uint64_t(128) << 20, 1};

    static std::string error_of(std::string_view order) {
        const Result<MappedFile> read = read_apart("obey", order, "", little, "some.file");
        EXPECT_FALSE(read) << order;
        return read ? "" : read.error().message();
    }
};

TEST_F(ReaderProcess, AnswersComeBackWholeFromManyThreads) {
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([t] {
            for (const std::size_t size : {0, 1, 70000, 3000000}) {
                const std::string bytes(size, static_cast<char>('a' + t)), details = std::to_string(t);
                const Result<MappedFile> read = read_apart("obey", bytes, details, little, "file");
                ASSERT_TRUE(read) << read.error().message();
                ByteSource source(read->bytes);
                EXPECT_EQ(source.text(), details);
                const std::vector<char> back = source.values<char>();
                EXPECT_TRUE(source.is_at_end());
                EXPECT_EQ(std::string(back.begin(), back.end()), bytes);
            }
        });
    for (std::thread& thread : threads) thread.join();
}

TEST_F(ReaderProcess, ACrashIsAnErrorWithTheNameOfTheFile) {
    for (const char* order : {"crash", "abort", "exit"}) {
        const std::string message = error_of(order);
        EXPECT_TRUE(message.starts_with("some.file: its reader ended ")) << message;
    }
    EXPECT_EQ(error_of("throw"), "some.file: thrown words");
    EXPECT_EQ(error_of("refuse"), "some.file: refused words");
    EXPECT_TRUE(read_apart("obey", "still there", "", little, "file"));
}

TEST_F(ReaderProcess, AHangIsEndedAndAnError) {
    EXPECT_EQ(error_of("think"), "some.file: took longer than 1 s of processor time to read");
    EXPECT_EQ(error_of("sleep"), "some.file: its reader stopped responding: the file is damaged");
}

TEST_F(ReaderProcess, AnAnswerLargerThanItsLimitIsAnError) {
    EXPECT_EQ(error_of("answer"), "some.file: needs more memory than a file of its size may use");
}

TEST_F(ReaderProcess, ExcessiveMemoryUseIsAnError) {
    if (has_shadow_memory) GTEST_SKIP() << "memory is not limited under sanitizers";
    EXPECT_EQ(error_of("grow"), "some.file: needs more memory than a file of its size may use");
}

TEST_F(ReaderProcess, AReaderCannotWriteFilesOrReachOrStartProcesses) {
    const TestFolder folder;
    write_text(folder / "there", "");
    const Result<MappedFile> read =
        read_apart("obey", "rights", (folder / "there").string(), little, "some.file");
    ASSERT_TRUE(read) << read.error().message();
    ByteSource source(read->bytes);
    for (const char* right : {"write", "remove", "network", "fork", "have no threads"})
        EXPECT_FALSE(source.value<bool>()) << right;
    EXPECT_TRUE(std::filesystem::exists(folder / "there"));
}

TEST_F(ReaderProcess, ModelsAndImagesAreTheSameAsReadInThisProcess) {
    const TestFolder folder;
    for (const auto& [ending, format] : {std::pair{"obj", ModelFormat::obj},
                                         {"stl", ModelFormat::stl},
                                         {"glb", ModelFormat::glb},
                                         {"gltf", ModelFormat::gltf}})
        for (const std::string& bytes : example_mesh_files(ending)) {
            write_text(folder / "box.mtl", "newmtl lid\nKd 0.1 0.2 0.3\nmap_Kd a.png\n");
            const std::filesystem::path file = folder / (std::string("mesh.") + ending);
            const auto here = assimp_content(bytes, file, format),
                       apart = guarded_content(bytes, file, format);
            ASSERT_TRUE(here && apart) << ending;
            std::string of_here, of_apart;
            ByteSink to_here([&](std::string_view piece) { of_here += piece; }),
                to_apart([&](std::string_view piece) { of_apart += piece; });
            write_content(*here, to_here);
            write_content(*apart, to_apart);
            EXPECT_EQ(of_here, of_apart) << ending;
            EXPECT_FALSE(here->meshes.empty());
        }
    Image image{5, 3, {}, {}};
    for (int i = 0; i < 15; ++i) {
        image.pixels.emplace_back(0.1f * float(i), 1.0f, 60000.0f - float(i));
        image.coverage.push_back(float(i) / 15);
    }
    image.relative_error = 0.25f;
    ASSERT_TRUE(write_image(image, folder / "a.exr"));
    const Result<Image> read = read_image(folder / "a.exr");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->relative_error, 0.25f);
    ASSERT_EQ(read->pixels.size(), 15u);
    EXPECT_NEAR(read->pixels[14].x, 1.4f, 1e-3f);
    EXPECT_NEAR(read->coverage[7], 7 / 15.0f, 1e-3f);
}

TEST(ModelContent, DamagedBytesAreRefusedOrWithinTheirRanges) {
    const TestFolder folder;
    for (const std::string& file : example_mesh_files("gltf")) {
        const auto content = assimp_content(file, folder / "mesh.gltf", ModelFormat::gltf);
        ASSERT_TRUE(content) << content.error().what;
        const std::string bytes = written_bytes([&](ByteSink& sink) { write_content(*content, sink); });
        EXPECT_TRUE(content_from(bytes));
        EXPECT_FALSE(content_from(bytes + '\0'));
        for (std::size_t length = 0; length < bytes.size(); ++length)
            EXPECT_FALSE(content_from(std::string_view(bytes).substr(0, length))) << length;
        for (std::size_t at = 0; at < bytes.size(); ++at)
            for (const char value : {'\0', '\x7f', '\xff'}) {
                std::string changed = bytes;
                changed[at] = value;
                const auto taken = content_from(changed);
                if (!taken) continue;
                for (const ContentNode& node : taken->nodes)
                    for (const std::uint32_t mesh : node.meshes) ASSERT_LT(mesh, taken->meshes.size());
                for (const ContentMesh& mesh : taken->meshes)
                    ASSERT_TRUE(mesh.material < taken->materials.size() ||
                                mesh.material == ContentMesh::no_material);
            }
    }
}

TEST(ModelFormat, IsDetectedFromContentNotFromTheName) {
    for (const char* ending : {"obj", "ply", "stl", "off", "gltf", "glb", "inc"})
        for (const std::string& bytes : example_mesh_files(ending))
            for (const char* name : {".obj", ".ply", ".stl", ".3mf", ".fbx", ""}) {
                const TestFolder folder;
                write_text(folder / (std::string("model") + name), bytes);
                const auto mesh = read_mesh(folder / (std::string("model") + name));
                EXPECT_TRUE(mesh) << ending << " as " << name << ": " << mesh.error().message();
            }
}

TEST(ModelFormat, OtherFormatsAreRefusedWithTheList) {
    const TestFolder folder;
    for (const std::string_view bytes :
         {std::string_view("PK\3\4 a 3MF is a zip"), std::string_view("Kaydara FBX Binary  \0", 21),
          std::string_view("<?xml version=\"1.0\"?><COLLADA/>"), std::string_view("ASSIMP.binary-dump."),
          std::string_view("FORM\0\0\0\4LWO2", 12), std::string_view("; FBX 7.3.0 project file"),
          std::string_view("xof 0303txt 0032"), std::string_view("MM\0\0\0\0", 6)})
        for (const char* name : {"model.obj", "model.3mf", "model.assbin", "model.ply"}) {
            write_text(folder / name, bytes);
            const auto mesh = read_mesh(folder / name);
            ASSERT_FALSE(mesh) << bytes;
            EXPECT_NE(mesh.error().what.find("OBJ, PLY, glTF (.gltf, .glb), STL, OFF or POV-Ray's mesh2"),
                      std::string::npos)
                << mesh.error().message();
        }
}

TEST(ModelFormat, ReferencesAreOpenedOnlyInTheDirectoryOfTheFile) {
    const TestFolder folder;
    std::filesystem::create_directories(folder / "models/below");
    std::string buffer(44, '\0');
    const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::memcpy(buffer.data(), corners.data(), 36);
    buffer[38] = 1;
    buffer[40] = 2;
    for (const char* place : {"outside.bin", "models/beside.bin", "models/below/deep.bin"})
        write_text(folder / place, buffer);
    std::filesystem::create_symlink(folder / "outside.bin", folder / "models/link.bin");
    const auto is_read = [&](const std::string& uri) {
        write_text(folder / "models/model.gltf",
                   R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
                   R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
                   R"("buffers":[{"byteLength":44,"uri":")" +
                       uri +
                       R"("}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,)"
                       R"("byteLength":6}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,)"
                       R"("type":"VEC3"},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]})");
        return read_mesh(folder / "models/model.gltf").operator bool();
    };
    EXPECT_TRUE(is_read("beside.bin"));
    EXPECT_TRUE(is_read("below/deep.bin"));
    EXPECT_FALSE(is_read("../outside.bin"));
    EXPECT_FALSE(is_read("below/../../outside.bin"));
    EXPECT_FALSE(is_read("link.bin"));
    EXPECT_FALSE(is_read((folder / "outside.bin").string()));
    EXPECT_FALSE(is_read("file://" + (folder / "outside.bin").string()));
    EXPECT_FALSE(is_read("http://127.0.0.1/outside.bin"));
    EXPECT_FALSE(is_read("/dev/zero"));
}

TEST(ImageFormat, IsDetectedFromContentAndOthersAreRefusedWithTheList) {
    const TestFolder folder;
    Image image{4, 2, std::vector<Rgb>(8, Rgb(0.5f)), {}};
    ASSERT_TRUE(write_image(image, folder / "a.exr"));
    std::filesystem::rename(folder / "a.exr", folder / "a.png");
    EXPECT_TRUE(read_image(folder / "a.png"));
    for (const std::string_view bytes :
         {std::string_view("FOR4\0\0\0\4CIMG", 12), std::string_view("\x01\xda\x01\x01\0\2\0\4\0\4", 10),
          std::string_view("GIF89a"), std::string_view("SDPX\0\0\0\0", 8), std::string_view("P6 1 1 255 abc"),
          std::string_view("DDS |"), std::string_view("")}) {
        write_text(folder / "b.png", bytes);
        const Result<Image> read = read_image(folder / "b.png");
        ASSERT_FALSE(read);
        EXPECT_NE(read.error().what.find("OpenEXR, Radiance HDR, PNG, JPEG, TIFF, WebP, BMP or Targa"),
                  std::string::npos)
            << read.error().message();
    }
}

TEST(ImageFormat, DecompressionBombsAreRefused) {
    // A valid PNG header of 16000 x 16000 pixels: 256 million in 57 bytes.
    const std::string_view head(
        "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x3e\x80\0\0\x3e\x80\x08\2\0\0\0\xd2\x1b\x3b\x1e\0\0\0\0IEND", 41);
    const Result<Image> read = read_image_bytes(head, "trap");
    EXPECT_FALSE(read);
}

}  // namespace
}  // namespace haarfield
