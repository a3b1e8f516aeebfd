#include "fields/model/gltf_nodes.h"

#include <gtest/gtest.h>

#include <functional>

#include "fields/model/model_file.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

/// Returns a model with a triangle at the last node; `children` returns the list of each other node.
std::string model(std::size_t nodes, const std::function<std::string(std::size_t)>& children) {
    std::string text = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)";
    for (std::size_t node = 0; node + 1 < nodes; ++node)
        text += R"({"name":"a \" { [","translation":[1,0,0],"extras":{"children":[0]},"children":[)" +
                children(node) + "]},\n";
    return text + R"({"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
                  R"("buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)"
                  R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],)"
                  R"("bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,)"
                  R"("componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]})";
}

std::string chain(std::size_t nodes) {
    return model(nodes, [](std::size_t node) { return std::to_string(node + 1); });
}

Result<ModelFile> opened(const std::string& text) {
    const TestFolder folder;
    write_text(folder / "model.gltf", text);
    return ModelFile::open(folder / "model.gltf");
}

void expect_refused(const std::string& text, const std::string& reason) {
    const Result<GltfDepth> depth = check_gltf_nodes(text);
    ASSERT_FALSE(depth) << reason;
    EXPECT_NE(depth.error().what.find(reason), std::string::npos) << depth.error().message();
    const Result<ModelFile> model = opened(text);
    ASSERT_FALSE(model) << reason;
    EXPECT_NE(model.error().what.find(reason), std::string::npos) << model.error().message();
}

TEST(GltfNodes, AChainOfTwentyThousandNodesIsRead) {
    constexpr std::size_t nodes = 20000;
    const Result<GltfDepth> depth = check_gltf_nodes(chain(nodes));
    ASSERT_TRUE(depth) << depth.error().message();
    EXPECT_EQ(depth->nodes, nodes);
    const Result<ModelFile> model = opened(chain(nodes));
    ASSERT_TRUE(model) << model.error().message();
    ASSERT_EQ(model->parts().nodes.size(), 1u);
    EXPECT_EQ(model->parts().nodes[0].place.point(Vec3d(0, 0, 0)), Vec3d(nodes - 1, 0, 0));
}

TEST(GltfNodes, TheLengthOfLongerChainsIsNamed) {
    expect_refused(chain(100001), "a chain of 100001; expected at most 100000");
}

TEST(GltfNodes, InstancesThatDoubleWithEachLevelAreRefused) {
    // Both nodes of a pair have the next pair as children.
    const auto pairs = [](std::size_t node) {
        return std::to_string(node / 2 * 2 + 2) + "," + std::to_string(node / 2 * 2 + 3);
    };
    expect_refused(model(51, [&](std::size_t node) { return node < 48 ? pairs(node) : "50"; }),
                   "more than 1000000 instances");
    const Result<ModelFile> few =
        opened(model(9, [&](std::size_t node) { return node < 6 ? pairs(node) : "8"; }));
    ASSERT_TRUE(few) << few.error().message();
    EXPECT_EQ(few->parts().nodes.size(), 8u);
}

TEST(GltfNodes, ANodeThatDescendsFromItselfIsRefused) {
    expect_refused(model(5, [](std::size_t node) { return std::to_string(node == 3 ? 1 : node + 1); }),
                   "its own ancestor");
    expect_refused(model(2, [](std::size_t) { return "0"; }), "its own ancestor");
}

TEST(GltfNodes, DeeplyNestedValuesAreRefused) {
    const std::string deep =
        R"({"asset":{"version":"2.0"},"extras":)" + std::string(100000, '[') + std::string(100000, ']') + "}";
    expect_refused(deep, "nested 100001 deep");
}

TEST(GltfNodes, CutTextsAreLeftToTheParser) {
    const std::string whole = chain(3);
    for (std::size_t size = 0; size < whole.size(); ++size)
        EXPECT_TRUE(check_gltf_nodes(std::string_view(whole).substr(0, size))) << size;
}

}  // namespace
}  // namespace haarfield
