#include "fields/model/obj_leading_zeros.h"

#include <cctype>

namespace haarfield {

std::string with_leading_zeros(const std::string& text) {
    std::string result;
    result.reserve(text.size() + text.size() / 16);
    bool coordinates = false;  // in a line that begins with v, vt, vn ...
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (i == 0 || text[i - 1] == '\n') coordinates = text[i] == 'v';
        const char before = i == 0 ? '\n' : text[i - 1];
        const bool begins = std::isspace(static_cast<unsigned char>(before)) ||
                            ((before == '-' || before == '+') &&
                             (i < 2 || std::isspace(static_cast<unsigned char>(text[i - 2]))));
        if (coordinates && text[i] == '.' && begins && i + 1 < text.size() && text[i + 1] >= '0' &&
            text[i + 1] <= '9')
            result += '0';
        result += text[i];
    }
    return result;
}

}  // namespace haarfield
