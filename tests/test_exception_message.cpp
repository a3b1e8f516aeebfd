#include "fields/base/exception_message.h"

#include <gtest/gtest.h>

#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

namespace haarfield {
namespace {

template <class Act>
std::string message_of(const Act& act) {
    try {
        act();
    } catch (const std::exception& exception) {
        return exception_message(exception);
    }
    return "no exception";
}

TEST(ExceptionMessage, OutOfMemoryIsReportedInWords) {
    EXPECT_EQ(message_of([] { throw std::bad_alloc(); }), "not enough memory");
    EXPECT_EQ(message_of([] { throw std::bad_array_new_length(); }), "not enough memory");
    EXPECT_EQ(message_of([] { std::vector<int>().resize(std::numeric_limits<std::size_t>::max()); }),
              "not enough memory");
}

TEST(ExceptionMessage, OtherMessagesLoseOnlyThePrefixOfALibrary) {
    EXPECT_EQ(message_of([] { throw std::runtime_error("words"); }), "words");
    for (const char* text : {"{", "", "{\"a\":1}"}) {
        const std::string message = message_of([&] { nlohmann::json::parse(text).at("b"); });
        EXPECT_EQ(message.find("json.exception"), std::string::npos) << message;
        EXPECT_GT(message.size(), 10u) << message;
    }
}

}  // namespace
}  // namespace haarfield
