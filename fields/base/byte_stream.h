#pragma once
/// Values as bytes, from one process of a machine to another: in the machine's own order.

#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace haarfield {

/// Bytes out, in pieces.
class ByteSink {
public:
    /// write  takes each piece in turn.
    explicit ByteSink(std::function<void(std::string_view)> write) : write_(std::move(write)) {}

    void bytes(std::string_view piece) { write_(piece); }  ///< As they are.

    template <class T>
    void value(const T& value) {  ///< A number, or a struct of numbers.
        static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
        write_({reinterpret_cast<const char*>(&value), sizeof value});
    }
    template <class T>
    void values(const std::vector<T>& values) {  ///< With their number.
        static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
        value(std::uint64_t(values.size()));
        write_({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
    }
    void text(std::string_view text) {  ///< With its length.
        value(std::uint64_t(text.size()));
        write_(text);
    }

private:
    std::function<void(std::string_view)> write_;
};

/// The same bytes in. What they say is not believed: a piece that is not there makes all that follow fail.
class ByteSource {
public:
    explicit ByteSource(std::string_view bytes) : rest_(bytes) {}

    bool is_good() const { return good_; }                     ///< Whether all that was asked for was there.
    bool is_at_end() const { return good_ && rest_.empty(); }  ///< And nothing more is.

    template <class T>
    T value() {  ///< A number, or a struct of numbers; zeros if it is not there.
        static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
        T value{};
        const std::string_view piece = take(sizeof(T));
        if (good_) std::memcpy(static_cast<void*>(&value), piece.data(), sizeof value);
        return value;
    }
    template <class T>
    std::vector<T> values() {  ///< As many as they say they are.
        static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
        const std::uint64_t count = value<std::uint64_t>();
        if (count > rest_.size() / sizeof(T)) good_ = false;
        if (!good_ || count == 0) return {};
        std::vector<T> values(count);
        const std::string_view piece = take(count * sizeof(T));
        std::memcpy(static_cast<void*>(values.data()), piece.data(), piece.size());
        return values;
    }
    std::string text() {  ///< As long as it says it is.
        const std::uint64_t size = value<std::uint64_t>();
        return std::string(take(size));
    }
    /// A number of things that are at least so many bytes each; 0 if they can not be there.
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
