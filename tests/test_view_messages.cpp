#include "tests/fixtures/view_messages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <sstream>

#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

TEST(ViewMessages, ValidMessagesAreRead) {
    for (const std::string& text : good_messages()) {
        const Result<Message> message = read_message(text);
        EXPECT_TRUE(bool(message)) << text << ": " << message.error().message();
    }
    const Result<Message> place = read_message(good_messages()[5]);
    ASSERT_TRUE(bool(place));
    const auto& content = std::get<PartialPlace>(place->content);
    EXPECT_EQ(content.object, 3u);
    EXPECT_EQ(content.translate, Vec3f(1, 2, 3));
    EXPECT_EQ(content.scale, 2);
    EXPECT_FALSE(content.rotate);
}

TEST(ViewMessages, ErrorsNameTheExpectedValue) {
    for (const auto& [text, what] : std::vector<std::pair<std::string, std::string>>{
             {"", "no JSON object"},
             {"[]", "no JSON object"},
             {"{\"type\":\"undo\"", "no JSON object"},
             {"{}", "type is missing"},
             {R"({"type":"dance"})", "type is unknown"},
             {R"({"type":"undo","often":3})", "unknown key: often"},
             {R"({"type":"undo","number":-1})", "number is invalid"},
             {R"({"type":"undo","number":4294967296})", "number is invalid"},
             {R"({"type":"place","object":1})", "at least one of"},
             {R"({"type":"place","object":1,"scale":0})", "scale is invalid"},
             {R"({"type":"place","object":1,"translate":[1,2]})", "translate is invalid; expected 3 numbers"},
             {R"({"type":"place","object":1,"translate":[1,2,1e300]})", "translate is invalid"},
             {R"({"type":"place","object":1,"rotation":[0,0,0,0]})", "a quaternion x, y, z, w"},
             {R"({"type":"mix","share":1.01})", "share is invalid"},
             {R"({"type":"exposure","stops":"much"})", "stops is invalid"},
             {R"({"type":"material","name":"oak","pigment":[1,1,1]})", "finish is missing"},
             {R"({"type":"material","name":"oak","pigment":[1,1,1],"finish":{"shine":1}})", "finish.shine"},
             {R"({"type":"look","position":[0,0,0],"target":[0,0,0],"vertical_fov":40,"width":8,"height":6})",
              "differs from position"},
             {R"({"type":"save","name":""})", "a text of 1 to 100 bytes"},
             {R"({"type":"start","task":"rm"})", "bake, reference or picture"}}) {
        const Result<Message> message = read_message(text);
        ASSERT_FALSE(bool(message)) << text;
        EXPECT_NE(message.error().message().find(what), std::string::npos)
            << text << ": " << message.error().message();
    }
    EXPECT_FALSE(bool(read_message(std::string(longest_message + 1, ' '))));
}

TEST(ViewMessages, ErrorsNameTheMessageThatTheyAnswer) {
    const auto answer_to = [](std::string_view text) {
        const Result<Message> message = read_message(text);
        EXPECT_FALSE(bool(message)) << text;
        return error_answer(message.error(), read_message_head(text));
    };
    const nlohmann::json of_broken = answer_to(R"({"type":"mix","share":2,"number":7})");
    EXPECT_EQ(of_broken["about"], "mix");
    EXPECT_EQ(of_broken["number"], 7);
    EXPECT_EQ(of_broken["type"], "error");
    const nlohmann::json of_unknown = answer_to(R"({"number":8,"type":"dance"})");
    EXPECT_FALSE(of_unknown.contains("about"));
    EXPECT_EQ(of_unknown["number"], 8);
    const nlohmann::json without_type = answer_to(R"({"number":9,"type":3})");
    EXPECT_FALSE(without_type.contains("about"));
    EXPECT_EQ(without_type["number"], 9);
    for (const char* headless : {"", "[7]", "{", R"({"type":7,"number":"7"})"}) {
        const nlohmann::json answer = answer_to(headless);
        EXPECT_FALSE(answer.contains("about") || answer.contains("number")) << headless;
    }
}

TEST(ViewMessages, TheProtocolDescribesEachType) {
    const std::string page = text_of(HAARFIELD_SOURCE_DIR "/tools/view/PROTOCOL.md");
    const std::size_t first = page.find("## Texts to the server"), last = page.find("## Texts from", first);
    ASSERT_LT(first, last);
    std::istringstream lines(page.substr(first, last - first));
    std::vector<std::string> described;
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with("| `")) continue;
        const std::string cell = line.substr(0, line.find('|', 1));
        const std::regex type("`([^`]*)`");
        for (std::sregex_iterator found(cell.begin(), cell.end(), type); found != std::sregex_iterator();
             ++found)
            described.push_back((*found)[1]);
    }
    std::ranges::sort(described);
    EXPECT_EQ(described, message_types());
}

// The error names the key and cuts long keys, possibly within a character.
TEST(ViewMessages, ErrorsCanBeSentForAnyKey) {
    for (std::size_t letters = 0; letters < 50; ++letters) {
        const std::string key = std::string(letters, 'a') + "\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80";
        const Result<Message> message = read_message(R"({"type":"undo",")" + key + "\":1}");
        ASSERT_FALSE(bool(message));
        const std::string answer = message_text({{"type", "error"}, {"message", message.error().what}});
        EXPECT_TRUE(nlohmann::json::accept(answer)) << letters << " letters: " << answer;
        EXPECT_NE(answer.find("unknown key: " + key.substr(0, std::min<std::size_t>(letters, 40))),
                  std::string::npos)
            << answer;
    }
}

// Changes, removes and inserts bytes, including pieces of other messages.
std::string mutated(std::string text, std::mt19937& random) {
    const auto below = [&](std::size_t n) { return random() % n; };
    for (std::size_t times = 1 + below(4); times > 0; --times) {
        const std::size_t at = below(text.size() + 1);
        switch (below(4)) {
            case 0: text.insert(at, 1, static_cast<char>(below(256))); break;
            case 1: text.erase(at, below(8)); break;
            case 2: {
                const std::string& other = good_messages()[below(good_messages().size())];
                const std::size_t from = below(other.size());
                text.insert(at, other.substr(from, below(30)));
                break;
            }
            default: {
                static const std::vector<std::string> odd{
                    "1e999", "-0", "null", "[[[[", "\"\\ud800\"", "18446744073709551616", "{}", "NaN"};
                text.insert(at, odd[below(odd.size())]);
            }
        }
    }
    return text;
}

TEST(ViewMessages, TenThousandMutatedOnesAreReadOrRefused) {
    std::mt19937 random(19);
    int refused = 0;
    for (int i = 0; i < 10000; ++i) {
        const std::string text = mutated(good_messages()[std::size_t(i) % good_messages().size()], random);
        const Result<Message> message = read_message(text);
        if (message)
            EXPECT_EQ(message_defect(*message), "") << text;
        else
            ++refused;
    }
    EXPECT_GT(refused, 5000);
}

TEST(ViewMessages, RotationsGoToPagesAndBack) {
    for (int i = 0; i < 50; ++i) {
        const Rotation rotation = rotation_about({std::sin(i), std::cos(3 * i), 0.3}, 0.4 * i);
        const nlohmann::json text{{"type", "turn_light"}, {"rotation", json_of(rotation)}};
        const Result<Message> message = read_message(text.dump());
        ASSERT_TRUE(bool(message));
        const Rotation& back = std::get<TurnLight>(message->content).turn;
        for (std::size_t row = 0; row < 3; ++row)
            EXPECT_LT((back.row[row] - rotation.row[row]).length(), 1e-6) << i;
    }
    EXPECT_TRUE(is_identity(
        std::get<TurnLight>(read_message(R"({"type":"turn_light","rotation":[0,0,0,2]})")->content).turn));
}

TEST(ViewMessages, MaterialsGoToPagesAndBack) {
    SceneMaterial plain, finish;
    plain.diffuse = {0.1f, 0.5f, 0.25f};
    plain.specular = {0.5f, 0.5f, 0.25f};
    plain.shininess = 12;
    finish.convention = LobeConvention::povray;
    finish.pigment = {0.5f, 0.25f, 1};
    finish.diffuse = finish.pigment * 0.75f;
    finish.specular = Rgb(1.0f);
    finish.phong = 0;
    finish.shininess = 40;
    finish.blinn = 0.5f;
    finish.roughness = 0.125f;
    SceneMaterial tinted = finish;  // A finish has white specular light.
    tinted.pigment = Rgb(1.0f);
    tinted.specular = {1, 0.5f, 0.5f};
    tinted.blinn = 0;
    for (const SceneMaterial& material : {plain, finish, tinted}) {
        nlohmann::json text = json_of(material);
        text["type"] = "material";
        text["name"] = "oak";
        const Result<Message> message = read_message(text.dump());
        ASSERT_TRUE(bool(message)) << message.error().message();
        const SceneMaterial& back = std::get<SetMaterial>(message->content).material;
        EXPECT_LT((back.diffuse - material.diffuse).length(), 1e-6f);
        EXPECT_EQ(back.specular, material.specular);
        EXPECT_EQ(back.convention, material.convention);
        EXPECT_EQ(back.blinn, material.blinn);
        EXPECT_EQ(back.pigment, material.pigment);
        EXPECT_EQ(back.shininess, material.shininess);
    }
}

}  // namespace
}  // namespace haarfield
