#include "scenes/scene_comments.h"

#include <gtest/gtest.h>

#include "scenes/scene_writer.h"

namespace haarfield {
namespace {

TEST(SceneComments, ThoseAtTheTopAreDistinguishedFromOthers) {
    struct Case {
        const char *text, *on_top;
        bool has_others;
    };
    for (const Case& each : {Case{"", "", false},
                             {"[camera]\n", "", false},
                             {"# one\n# two\n\n[camera]\n", "one\ntwo\n", false},
                             {"# one\r\n#two\r\n[camera]\r\n", "one\ntwo\n", false},
                             {"#\n# after an empty one", "\nafter an empty one\n", false},
                             {"# one\n\n# apart\n", "one\n", true},
                             {"\n# not on top\n", "", true},
                             {"[camera]\n# below\n", "", true},
                             {"[camera] # beside\n", "", true},
                             {"a = [1, # in a list\n 2]", "", true},
                             {"a = 1 # at the end", "", true}}) {
        const SceneComments comments = scene_comments(each.text);
        EXPECT_EQ(comments.on_top, each.on_top) << each.text;
        EXPECT_EQ(comments.has_others, each.has_others) << each.text;
    }
}

TEST(SceneComments, QuotedTextIsNone) {
    for (const char* text :
         {R"(mesh = "a#b")", R"(mesh = 'a#b')", R"(mesh = "a\"#b")", R"("a#b" = 1)", R"(a = ["'#", '"#'])"})
        EXPECT_FALSE(scene_comments(text).has_others) << text;
    for (const char* text : {R"(mesh = "a#b" # c)", R"(mesh = 'a\' # c)", R"(mesh = "a\\" # c)",
                             R"(a = "it's" # c)", R"(a = """)", R"(a = ''')", R"(a = "open)", R"(a = "\)"})
        EXPECT_TRUE(scene_comments(text).has_others) << text;
}

TEST(SceneComments, TheWriterKeepsThoseOnTop) {
    const std::string on_top = "First.\n  Indented, with a \"quote\".\n\nLast.\n";
    const SceneComments kept = scene_comments(scene_text({}, "", on_top));
    EXPECT_EQ(kept.on_top, on_top);
    EXPECT_FALSE(kept.has_others);
}

}  // namespace
}  // namespace haarfield
