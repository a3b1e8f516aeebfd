#include "tests/fuzz/json_changes.h"

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

using Json = nlohmann::ordered_json;

/// Lists all values of a tree.
void list_values(Json& json, std::vector<Json*>& values) {
    values.push_back(&json);
    if (json.is_structured())
        for (Json& child : json) list_values(child, values);
}

Json other_number(const Json& number, FuzzRandom& random) {
    const auto value = number.is_number() ? number.get<double>() : 1.0;
    switch (random_index(random, 10)) {
        case 0: return value + 1;
        case 1: return value - 1;
        case 2: return -value;
        case 3: return value * std::pow(10.0, double(random_index(random, 90)) - 45);
        case 4: return std::ldexp(1.0, int(random_index(random, 2100)) - 1074);
        case 5: return std::uint64_t(1) << random_index(random, 64);
        case 6: return (std::uint64_t(1) << random_index(random, 64)) - 1;
        case 7: return -static_cast<std::int64_t>(std::uint64_t(1) << random_index(random, 63));
        // Integers stay integers.
        case 8:
            return number.is_number_unsigned()
                       ? Json(number.get<std::uint64_t>() + random_index(random, 3) - 1)
                       : Json(std::nextafter(value, random_index(random, 2) ? 1e300 : -1e300));
        default: return 0;
    }
}

Json odd_value(FuzzRandom& random) {
    switch (random_index(random, 9)) {
        case 0: return nullptr;
        case 1: return random_index(random, 2) == 0;
        case 2: return "";
        case 3: return Json::array();
        case 4: return Json::object();
        case 5: return std::string(random_index(random, 300), 'x');
        case 6: return "\xc3\xa4\xf0\x9f\x98\x80\n\"<!--\\";
        case 7: return std::string("\0/../..", 7);
        default: {
            Json deep = 1;
            for (std::size_t i = random_index(random, 300); i > 0; --i)
                deep = i % 2 ? Json{{"a", deep}} : Json::array({deep});
            return deep;
        }
    }
}

/// Returns text with characters of different lengths, so that any cut may split one.
std::string other_text(const std::string& text, FuzzRandom& random) {
    std::string other = text;
    switch (random_index(random, 4)) {
        case 0: return other + other;
        case 1:
            for (std::size_t i = 1 + random_index(random, 60); i > 0; --i)
                other += std::vector{"a", "\xc3\xa4", "\xe2\x82\xac"}[random_index(random, 3)];
            return other;
        case 2: return other.substr(0, random_index(random, other.size() + 1));
        default:
            if (!other.empty())
                other[random_index(random, other.size())] = char('!' + random_index(random, 90));
            return other;
    }
}

void change_once(Json& json, FuzzRandom& random) {
    std::vector<Json*> values;
    list_values(json, values);
    Json& one = *values[random_index(random, values.size())];
    const Json other = *values[random_index(random, values.size())];
    const std::size_t what = random_index(random, 8);
    if (what == 0) {
        one = odd_value(random);
    } else if (what == 1) {
        one = other;
    } else if (one.is_number()) {
        one = other_number(one, random);
    } else if (one.is_string()) {
        one = other_text(one.get<std::string>(), random);
    } else if (one.is_array() && !one.empty()) {
        const auto at = one.begin() + static_cast<std::ptrdiff_t>(random_index(random, one.size()));
        if (what < 4)
            one.erase(at);
        else if (what < 6)
            one.insert(at, Json(*at));
        else
            one.push_back(other);
    } else if (one.is_object() && !one.empty()) {
        const auto at = std::next(one.begin(), static_cast<std::ptrdiff_t>(random_index(random, one.size())));
        const std::string key = at.key();
        const Json value = at.value();
        if (what < 4) one.erase(key);
        if (what > 2) one[other_text(key, random)] = value;
    } else {
        one = odd_value(random);
    }
}

}  // namespace

std::string changed_json(Json json, FuzzRandom& random) {
    do change_once(json, random);
    while (random_index(random, 3) != 0);
    // Cut texts may end within a character. Those bytes are written unchanged.
    std::string text = json.dump(random_index(random, 2) ? -1 : 1, ' ', false, Json::error_handler_t::ignore);
    if (random_index(random, 8) == 0)
        if (const std::size_t at = text.find("null"); at != std::string::npos)
            text.replace(at, 4, random_index(random, 2) ? "1e999" : "-0");
    return text;
}

}  // namespace haarfield
