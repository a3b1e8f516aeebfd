#include "tools/render_options.h"

#include <gtest/gtest.h>

#include <set>

namespace haarfield {
namespace {

TEST(RenderOptions, HaveDistinctNamesAndSummariesOfOneShortLine) {
    std::set<std::string> names;
    for (const RenderOption& row : render_options()) {
        EXPECT_TRUE(names.insert(row.name).second) << row.name;
        EXPECT_LE(row.summary.size(), 70u) << row.name;
        EXPECT_EQ(row.summary.find('\n'), std::string::npos) << row.name;
        EXPECT_NE(row.summary, "") << row.name;
    }
    EXPECT_GT(names.size(), 15u);
}

TEST(RenderOptions, DefaultsAreValuesAndSettingThemChangesNothing) {
    for (const RenderOption& row : render_options()) {
        RenderChoices choices;
        const std::string text = row.text(choices);
        if (text.empty()) {
            EXPECT_TRUE(row.is_optional || row.is_list) << row.name;
            continue;
        }
        EXPECT_EQ(row.trouble(text), "") << row.name;
        row.set_text(choices, text);
        EXPECT_EQ(row.text(choices), text) << row.name;
    }
}

TEST(RenderOptions, SetEveryWordAndBothEndsOfEveryRange) {
    for (const RenderOption& row : render_options()) {
        std::vector<std::string> values = row.words;
        if (row.range && !row.range->without_highest)
            values.push_back(std::to_string(int(row.range->highest)));
        if (row.range && row.range->lowest >= 1) values.push_back(std::to_string(int(row.range->lowest)));
        for (const std::string& value : values) {
            RenderChoices choices;
            ASSERT_EQ(row.trouble(value), "") << row.name;
            row.set_text(choices, value);
            const bool is_automatic = row.name == "bounces" && value == "1000";
            EXPECT_EQ(row.text(choices), is_automatic ? "auto" : value) << row.name;
        }
    }
}

TEST(RenderOptions, RefuseOtherWordsAndNumbersWithTheValidValues) {
    for (const RenderOption& row : render_options())
        for (const std::string value : {"", "nan", "-1", "1e30", "magic", "1,magic"}) {
            const std::string trouble = row.trouble(value);
            EXPECT_NE(trouble.find(row.values()), std::string::npos) << row.name << ' ' << value;
        }
}

TEST(RenderOptions, FaceSizesOfFieldsAndShadingAgree) {
    RenderChoices choices;
    EXPECT_EQ(choices.entities.face_size, choices.shading.face_size);
    render_option("face-size").set_text(choices, "32");
    EXPECT_EQ(choices.entities.face_size, 32);
    EXPECT_EQ(choices.shading.face_size, 32);
}

TEST(RenderOptions, ArgumentsLeaveOutAbsentValues) {
    RenderChoices choices;
    const auto arguments = [&] {
        return option_arguments(choices, {OptionSet::fields, OptionSet::vertices, OptionSet::bake});
    };
    for (const std::string option : {"--refine", "--pass", "--original-vertices"})
        EXPECT_EQ(std::ranges::count(arguments(), option), 0) << option;
    choices.bake.refine = 0.25f;
    choices.bake.passes = {"diffuse", "occlusion"};
    const std::vector<std::string> given = arguments();
    EXPECT_EQ(*(std::ranges::find(given, "--refine") + 1), "0.25");
    EXPECT_EQ(*(std::ranges::find(given, "--pass") + 1), "diffuse,occlusion");
}

}  // namespace
}  // namespace haarfield
