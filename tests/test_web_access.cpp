#include "tools/view/web_access.h"

#include <gtest/gtest.h>

namespace haarfield {
namespace {

TEST(WebAccess, RequiresTokenAndHostName) {
    const WebAccess access{"secret", "127.0.0.1", 8000, true};
    EXPECT_FALSE(refusal(access, "127.0.0.1:8000", {}, "/secret/"));
    EXPECT_FALSE(refusal(access, "localhost:8000", "http://[::1]:8000", "/secret/main.js"));
    for (const char* host : {"127.0.0.1", "127.0.0.1:8001", "elsewhere:8000", ""})
        EXPECT_TRUE(refusal(access, host, {}, "/secret/")) << host;
    for (const char* origin : {"http://elsewhere:8000", "https://localhost:8000", "null", ""})
        EXPECT_TRUE(refusal(access, "localhost:8000", origin, "/secret/")) << origin;
    for (const char* target : {"/", "/secret", "/secret2/", "/Secret/", "secret//", ""})
        EXPECT_TRUE(refusal(access, "localhost:8000", {}, target)) << target;
    const WebAccess elsewhere{"secret", "192.0.2.1", 8000, false};
    EXPECT_FALSE(refusal(elsewhere, "192.0.2.1:8000", {}, "/secret/"));
    EXPECT_TRUE(refusal(elsewhere, "localhost:8000", {}, "/secret/"));
}

TEST(WebAccess, PathsAreDecodedOrRefused) {
    const WebAccess access{"secret", "127.0.0.1", 8000, true};
    EXPECT_EQ(below_token(access, "/secret/a%20b?c"), "a%20b?c");
    EXPECT_EQ(asked_path(access, "/secret/a%20b%2F%c3%A9?c%"), "a b/\xc3\xa9");
    EXPECT_EQ(asked_path(access, "/secret/"), "");
    for (const char* broken : {"/secret/%", "/secret/a%2", "/secret/%g0", "/secret/%0g"})
        EXPECT_FALSE(asked_path(access, broken)) << broken;
}

TEST(WebAccess, TokensAreNewEachTime) {
    EXPECT_EQ(random_token().size(), 32u);
    EXPECT_NE(random_token(), random_token());
}

}  // namespace
}  // namespace haarfield
