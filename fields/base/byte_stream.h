#pragma once
/// Values as bytes in native byte order, for transfer between processes of one machine.

#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace haarfield {

/// Writes values as bytes.
class ByteSink {
public:
    /// write  is called with each piece in order.
    explicit ByteSink(std::function<void(std::string_view)> write) : write_(std::move(write)) {}

    void bytes(std::string_view piece) { write_(piece); }  ///< Writes the bytes without their length.

    template <class T>
    void value(const T& value) {  ///< Writes a number or a struct of numbers.
        static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
        write_({reinterpret_cast<const char*>(&value), sizeof value});
    }
    template <class T>
    void values(const std::vector<T>& values) {  ///< Writes the number of elements, then the elements.
        static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
        value(std::uint64_t(values.size()));
        write_({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
    }
    void text(std::string_view text) {  ///< Writes the length, then the characters.
        value(std::uint64_t(text.size()));
        write_(text);
    }

private:
    std::function<void(std::string_view)> write_;
};

/// Returns the bytes that write(ByteSink&) writes.
template <class Write>
std::string written_bytes(const Write& write) {
    std::string bytes;
    ByteSink sink([&bytes](std::string_view piece) { bytes += piece; });
    write(sink);
    return bytes;
}

/// Reads the bytes of a ByteSink. The bytes are untrusted: after a read past the end, this read and all
/// further ones fail.
class ByteSource {
public:
    /// Refers to the bytes, which must outlive the source.
    explicit ByteSource(std::string_view bytes) : rest_(bytes) {}

    bool is_good() const { return good_; }  ///< True if no read has failed.
    /// True if, in addition, all bytes have been read.
    bool is_at_end() const { return good_ && rest_.empty(); }

    template <class T>
    T value() {  ///< Reads a number or a struct of numbers; zeros on failure.
        static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
        T value{};
        const std::string_view piece = take(sizeof(T));
        if (good_) std::memcpy(static_cast<void*>(&value), piece.data(), sizeof value);
        return value;
    }
    template <class T>
    std::vector<T> values() {  ///< Reads a number of elements, then the elements; empty on failure.
        static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
        const std::uint64_t count = value<std::uint64_t>();
        if (count > rest_.size() / sizeof(T)) good_ = false;
        if (!good_ || count == 0) return {};
        std::vector<T> values(count);
        const std::string_view piece = take(count * sizeof(T));
        std::memcpy(static_cast<void*>(values.data()), piece.data(), piece.size());
        return values;
    }
    std::string text() {  ///< Reads a length, then the characters; empty on failure.
        const std::uint64_t size = value<std::uint64_t>();
        return std::string(take(size));
    }
    /// Reads the number of items that follow, each at least `least_bytes` long; 0 if fewer bytes remain than
    /// that.
    std::uint64_t count(std::size_t least_bytes) {
        const std::uint64_t count = value<std::uint64_t>();
        if (count > rest_.size() / least_bytes) good_ = false;
        return good_ ? count : 0;
    }

private:
    std::string_view take(std::uint64_t size) {
        if (size > rest_.size()) good_ = false;
        if (!good_) return {};
        const std::string_view piece = rest_.substr(0, size);
        rest_.remove_prefix(size);
        return piece;
    }

    std::string_view rest_;
    bool good_ = true;
};

}  // namespace haarfield
