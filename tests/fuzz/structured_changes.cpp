#include "tests/fuzz/structured_changes.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>

namespace haarfield {
namespace {

struct Span {
    std::size_t begin = 0, size = 0;

    std::string of(const std::string& text) const { return text.substr(begin, size); }
};

/// Returns runs of characters of a kind, starting at a random place; the first ones if there are very many.
template <class IsPart>
std::vector<Span> runs(const std::string& text, const IsPart& is_part) {
    std::vector<Span> found;
    for (std::size_t at = 0; at < text.size();) {
        if (!is_part(text[at])) {
            ++at;
            continue;
        }
        const std::size_t begin = at;
        while (at < text.size() && is_part(text[at])) ++at;
        found.push_back({begin, at - begin});
    }
    return found;
}

std::vector<Span> numbers_of(const std::string& text) {
    std::vector<Span> found = runs(text, [](char c) {
        return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+' || c == 'e' || c == 'E';
    });
    std::erase_if(found, [&](const Span& span) {
        return std::ranges::none_of(span.of(text), [](char c) { return c >= '0' && c <= '9'; });
    });
    return found;
}

std::vector<Span> words_of(const std::string& text) {
    return runs(text, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; });
}

std::vector<Span> lines_of(const std::string& text) {
    return runs(text, [](char c) { return c != '\n'; });
}

std::string written(double number) {
    std::array<char, 40> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
    return {buffer.data(), end};
}

/// Returns a number close to the given one, or close to the limits of number types.
std::string other_number(const std::string& text, FuzzRandom& random) {
    double value = 0;
    std::from_chars(text.data() + (text[0] == '+'), text.data() + text.size(), value);
    switch (random_index(random, 9)) {
        case 0: return written(value + 1);
        case 1: return written(value - 1);
        case 2: return written(-value);
        case 3: return written(value * std::pow(10.0, double(random_index(random, 90)) - 45));
        case 4: return written(std::ldexp(1.0, int(random_index(random, 300)) - 150));
        case 5: return written(std::ldexp(1.0, int(random_index(random, 70))) - 1);
        case 6: return random_index(random, 2) ? "nan" : "-inf";
        case 7: return written(value * (1 + 1e-7));
        default: return "0";
    }
}

Span any(const std::vector<Span>& spans, FuzzRandom& random) {
    return spans[random_index(random, spans.size())];
}

void change_text_once(std::string& text, FuzzRandom& random) {
    const std::size_t what = random_index(random, 8);
    const std::vector<Span> spans = what < 4 ? numbers_of(text) : what < 7 ? lines_of(text) : words_of(text);
    if (spans.empty()) return;
    const Span one = any(spans, random), other = any(spans, random);
    const std::string of_other = other.of(text);
    constexpr std::size_t longest = 1 << 16;
    switch (what) {
        case 0:
        case 1:
        case 2: text.replace(one.begin, one.size, other_number(one.of(text), random)); break;
        case 3:
        case 7: text.replace(one.begin, one.size, of_other); break;
        case 4: text.erase(one.begin, one.size); break;
        case 5: text.insert(one.begin, of_other + "\n"); break;
        case 6: {
            std::string many;
            for (std::size_t i = 1 + random_index(random, 200); i > 0 && many.size() < longest; --i)
                many += of_other + "\n";
            text.insert(one.begin, many);
            break;
        }
    }
}

template <class Word>
void change_word(std::string& bytes, FuzzRandom& random) {
    if (bytes.size() < 2 * sizeof(Word)) return;
    // Usually aligned to its size.
    const auto place = [&] {
        const std::size_t at = random_index(random, bytes.size() - sizeof(Word));
        return random_index(random, 4) ? at / sizeof(Word) * sizeof(Word) : at;
    };
    const std::size_t at = place(), from = place();
    Word word, other;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    std::memcpy(&other, bytes.data() + from, sizeof other);
    switch (random_index(random, 7)) {
        case 0: ++word; break;
        case 1: --word; break;
        case 2: word = static_cast<Word>(word * 2); break;
        case 3: word = other; break;
        case 4: word = static_cast<Word>(~word); break;
        case 5: word = static_cast<Word>(Word(1) << random_index(random, 8 * sizeof(Word))); break;
        default: word = static_cast<Word>(random_index(random, 300)); break;
    }
    std::memcpy(bytes.data() + at, &word, sizeof word);
}

std::uint32_t big_endian(const char* at) {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(at[i]);
    return value;
}

/// Returns the checksum of a PNG chunk, as defined in its specification.
std::uint32_t crc(std::string_view bytes) {
    std::uint32_t sum = 0xffffffff;
    for (const char c : bytes) {
        sum ^= static_cast<std::uint8_t>(c);
        for (int bit = 0; bit < 8; ++bit) sum = sum & 1 ? sum >> 1 ^ 0xedb88320 : sum >> 1;
    }
    return ~sum;
}

void right_png(std::string& bytes) {
    constexpr std::size_t signature = 8, head = 8, tail = 4;
    for (std::size_t at = signature; at + head + tail <= bytes.size();) {
        const std::size_t length = big_endian(bytes.data() + at);
        if (length > bytes.size() - at - head - tail) return;
        const std::uint32_t sum = crc(std::string_view(bytes).substr(at + 4, length + 4));
        for (std::size_t i = 0; i < 4; ++i)
            bytes[at + head + length + i] = static_cast<char>(sum >> (24 - 8 * i) & 0xff);
        at += head + length + tail;
    }
}

/// Replaces the text of the JSON chunk.
void change_glb(std::string& bytes, FuzzRandom& random) {
    constexpr std::size_t head = 20;
    std::uint32_t length = 0;
    if (bytes.size() < head) return;
    std::memcpy(&length, bytes.data() + 12, sizeof length);
    if (length > bytes.size() - head) return;
    std::string json = bytes.substr(head, length);
    change_structure(json, random, FileKind::text);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    bytes.replace(head, length, json);
    const auto chunk = static_cast<std::uint32_t>(json.size()),
               all = static_cast<std::uint32_t>(bytes.size());
    std::memcpy(bytes.data() + 12, &chunk, sizeof chunk);
    std::memcpy(bytes.data() + 8, &all, sizeof all);
}

}  // namespace

void change_structure(std::string& bytes, FuzzRandom& random, FileKind kind) {
    if (kind == FileKind::glb && random_index(random, 4)) return change_glb(bytes, random);
    do {
        if (bytes.empty()) return;
        if (kind == FileKind::text)
            change_text_once(bytes, random);
        else if (random_index(random, 2))
            change_word<std::uint32_t>(bytes, random);
        else
            change_word<std::uint16_t>(bytes, random);
    } while (random_index(random, 3) != 0);
    if (kind == FileKind::png && random_index(random, 8)) right_png(bytes);
}

}  // namespace haarfield
