#include "fields/model/povray_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace haarfield {
namespace {

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}
bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_blank(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r') || c == '\0';
}

}  // namespace

std::size_t PovrayText::line_at(std::size_t place) const {
    return 1 + static_cast<std::size_t>(
                   std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(place), '\n'));
}

Error PovrayText::error() const {
    assert(failure_);
    return {"", fmt::format("line {}: {}", line_at(failure_->place), failure_->what)};
}

void PovrayText::fail_at(std::size_t place, std::string what) {
    if (!failure_) failure_ = Failure{place, std::move(what)};
    at_ = text_.size();
}

void PovrayText::fail(std::string_view wanted) {
    std::string found = "the end";
    if (!at_end()) {
        const std::size_t size = std::min(text_.find_first_of(" \t\r\n,;<>{}()", at_ + 1), at_ + 40) - at_;
        found = fmt::format("\"{}\"", text_.substr(at_, size));
        for (char& c : found)
            if (static_cast<unsigned char>(c) < ' ' || static_cast<unsigned char>(c) > '~') c = '?';
    }
    fail_at(at_, fmt::format("found {}; expected {}", found, wanted));
}

/// Skips a comment. False if it does not end.
bool PovrayText::skip_block_comment() {
    int depth = 0;
    while (true) {
        const std::size_t mark = text_.find_first_of("*/", at_);
        if (mark == text_.npos || mark + 1 >= text_.size()) return false;
        const std::string_view pair = text_.substr(mark, 2);
        at_ = mark + (pair == "/*" || pair == "*/" ? 2 : 1);
        depth += int(pair == "/*") - int(pair == "*/");
        if (depth == 0) return true;
    }
}

void PovrayText::skip_blanks() {
    while (!at_end()) {
        if (is_blank(text_[at_])) {
            ++at_;
        } else if (text_.substr(at_, 2) == "//") {
            at_ = std::min(text_.find('\n', at_), text_.size());
        } else if (text_.substr(at_, 2) == "/*") {
            const std::size_t begin = at_;
            if (!skip_block_comment()) return fail_at(begin, "a comment does not end");
        } else {
            return;
        }
    }
}

bool PovrayText::take(char c) {
    if (next() != c || at_end()) return false;
    ++at_;
    skip_blanks();
    return true;
}

void PovrayText::expect(char c) {
    if (!take(c)) fail(fmt::format("\"{}\"", c));
}

std::string_view PovrayText::word() {
    if (!is_letter(next())) return {};
    const std::size_t begin = at_;
    while (!at_end() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string_view found = text_.substr(begin, at_ - begin);
    skip_blanks();
    return found;
}

std::string_view PovrayText::string() {
    if (next() != '"') return {};
    const std::size_t begin = at_;
    std::size_t end = text_.find_first_of("\"\\", begin + 1);
    while (end < text_.size() && text_[end] == '\\') end = text_.find_first_of("\"\\", end + 2);
    if (end >= text_.size()) {
        fail_at(begin, "a string does not end");
        return {};
    }
    at_ = end + 1;
    skip_blanks();
    return text_.substr(begin + 1, end - begin - 1);
}

void PovrayText::skip_one() {
    if (next() == '"') {
        string();
        return;
    }
    if (is_letter(next()) || is_digit(next())) {
        while (!at_end() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    } else if (!at_end()) {
        ++at_;
    }
    skip_blanks();
}

void PovrayText::skip_braces() {
    const std::size_t begin = at_;
    expect('{');
    for (std::size_t depth = 1; depth > 0;) {
        if (failed()) return;
        if (at_end()) return fail_at(begin, "a { has no }");
        if (next() == '{') ++depth;
        if (next() == '}') --depth;
        skip_one();
    }
}

/// Fails before an operator, which would continue an expression.
void PovrayText::refuse_operator() {
    const char c = next();
    if (c == '+' || c == '-' || c == '*' || c == '/' || c == '.' || c == '(' || c == '[' || c == '?')
        fail("a plain number or vector, not an expression");
}

double PovrayText::sign() {
    double result = 1;
    while (next() == '-' || next() == '+') {
        if (next() == '-') result = -result;
        take(next());
    }
    return result;
}

double PovrayText::unsigned_number() {
    if (!is_digit(next()) && next() != '.') {
        fail("a plain number");
        return 0;
    }
    double value = 0;
    const char* const begin = text_.data() + at_;
    const auto [end, failure] = std::from_chars(begin, text_.data() + text_.size(), value);
    const bool ends_well =
        end == text_.data() + text_.size() || !(is_letter(*end) || is_digit(*end) || *end == '.');
    if (failure == std::errc::invalid_argument || !ends_well) {
        fail("a plain number");
        return 0;
    }
    if (failure == std::errc::result_out_of_range) {
        const std::string_view digits(begin, static_cast<std::size_t>(end - begin));
        const bool is_tiny = digits.find("e-") != digits.npos || digits.find("E-") != digits.npos;
        value = is_tiny ? 0 : std::numeric_limits<double>::infinity();
    }
    at_ += static_cast<std::size_t>(end - begin);
    skip_blanks();
    return value;
}

double PovrayText::number() {
    const double sign_of_it = sign();
    const double value = sign_of_it * unsigned_number();
    refuse_operator();
    return value;
}

std::uint32_t PovrayText::count() {
    const std::size_t begin = at_;
    const double value = number();
    if (value >= 0 && value <= std::numeric_limits<std::uint32_t>::max() && value == std::floor(value))
        return static_cast<std::uint32_t>(value);
    fail_at(begin, fmt::format("found {:g}; expected a whole number that is not negative", value));
    return 0;
}

template <std::size_t count>
std::array<double, count> PovrayText::numbers() {
    std::array<double, count> result{};
    expect('<');
    for (std::size_t i = 0; i < count && !failed(); ++i) {
        if (i > 0) take(',');
        result[i] = number();
    }
    expect('>');
    return result;
}

Vec3d PovrayText::vector() {
    Vec3d result(0, 0, 0);
    const double sign_of_it = sign();
    double factor = 1;
    bool is_number = false;
    if (is_digit(next()) || next() == '.') {
        factor = unsigned_number();
        is_number = !take('*');
        result = Vec3d(1, 1, 1);
    }
    if (!is_number) {
        if (next() == '<') {
            const auto [x, y, z] = numbers<3>();
            result = Vec3d(x, y, z);
        } else {
            const PovrayText before = *this;
            const std::string_view axis = word();
            if (axis != "x" && axis != "y" && axis != "z") {
                *this = before;
                fail("a vector of plain numbers");
                return result;
            }
            result = Vec3d(axis == "x", axis == "y", axis == "z");
        }
        if (take('*')) {
            const double after = sign();
            factor *= after * unsigned_number();
        }
    }
    refuse_operator();
    return result * (sign_of_it * factor);
}

std::array<float, 2> PovrayText::uv() {
    const auto [u, v] = numbers<2>();
    refuse_operator();
    return {static_cast<float>(u), static_cast<float>(v)};
}

std::array<std::uint32_t, 3> PovrayText::indices() {
    std::array<std::uint32_t, 3> result{};
    expect('<');
    for (std::size_t i = 0; i < 3 && !failed(); ++i) {
        if (i > 0) take(',');
        result[i] = count();
    }
    expect('>');
    return result;
}

std::array<double, 12> PovrayText::matrix() {
    return numbers<12>();
}

}  // namespace haarfield
