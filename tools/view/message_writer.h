#pragma once
/// Writing numbers into binary messages to the page.

#include <Imath/half.h>

#include <algorithm>
#include <cstdint>
#include <string>

namespace haarfield {

/// Appends the bytes of a number to a message. Messages are little-endian, as the page expects.
template <class Value>
void append(std::string& bytes, const Value& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(Value));
}

/// Returns the bits of a half float. Values above 65,000, almost its largest one, become 65,000.
inline std::uint16_t half_bits(float value) {
    constexpr float largest = 65000;
    return imath_float_to_half(std::min(value, largest));
}

}  // namespace haarfield
