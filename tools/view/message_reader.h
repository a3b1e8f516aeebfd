#pragma once
/// A reader of the keys of messages.

#include "fields/base/range.h"
#include "fields/base/rotation.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <set>

namespace haarfield {

/// Reads the keys of a message. If a key is missing, its value remains unchanged. After the first error, all
/// further reads do nothing.
class MessageReader {
public:
    explicit MessageReader(const nlohmann::json& object, std::string name = "")
        : object_(object), name_(std::move(name)) {}

    bool has(const char* key) const { return object_.contains(key); }

    void take(const char* key, float& value, const Range& range) {
        if (const nlohmann::json* found = find(key)) value = static_cast<float>(number(*found, key, range));
    }

    void take(const char* key, std::uint32_t& value) {
        const nlohmann::json* found = find(key);
        if (!found) return;
        if (found->is_number_unsigned() && found->get<std::uint64_t>() <= 0xffffffffu)
            value = found->get<std::uint32_t>();
        else
            refuse(key, "a whole number from 0 to 4294967295");
    }

    void take(const char* key, std::string& value, std::size_t longest = 200) {
        const nlohmann::json* found = find(key);
        if (!found) return;
        if (found->is_string() && !found->get_ref<const std::string&>().empty() &&
            found->get_ref<const std::string&>().size() <= longest)
            value = found->get<std::string>();
        else
            refuse(key, fmt::format("a text of 1 to {} bytes", longest));
    }

    /// Reads a vector or a colour.
    template <class Vector>
    void take_three(const char* key, Vector& value, const Range& range) {
        std::array<double, 3> numbers{};
        if (take_list(key, numbers, range))
            for (int i = 0; i < 3; ++i) value[i] = static_cast<float>(numbers[std::size_t(i)]);
    }

    void take(const char* key, Rotation& value) {
        std::array<double, 4> q{};
        if (!take_list(key, q, {-1e3, 1e3})) return;
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (!(length > 1e-6)) return refuse(key, "a quaternion x, y, z, w that is not 0");
        const double x = q[0] / length, y = q[1] / length, z = q[2] / length, w = q[3] / length;
        Rotation given;
        given.row = {Vec3d(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
                     Vec3d(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
                     Vec3d(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y))};
        value = as_degrees(given);  // a saved scene then has bit-identical values
    }

    /// Reads an object whose keys are read by `use`.
    template <class Use>
    void take_part(const char* key, const Use& use) {
        const nlohmann::json* found = find(key);
        if (!found) return;
        if (!found->is_object()) return refuse(key, "an object");
        MessageReader part(*found, name_ + key + ".");
        use(part);
        part.finish();
        if (!error_) error_ = part.error_;
    }

    void require(const char* key) {
        if (!error_ && !has(key)) error_ = Error{"", fmt::format("{}{} is missing", name_, key)};
    }

    void refuse(const char* key, const std::string& wanted) {
        // The message omits values that are long or unusual.
        if (!error_) error_ = Error{"", fmt::format("{}{} is invalid; expected {}", name_, key, wanted)};
    }

    /// Rejects keys that were not read.
    void finish() {
        for (const auto& [key, value] : object_.items())
            if (!error_ && !known_.contains(key))
                error_ = Error{"", fmt::format("unknown key: {}{}", name_, key.substr(0, 40))};
    }

    const std::optional<Error>& error() const { return error_; }

    const nlohmann::json* find(const char* key) {
        known_.insert(key);
        const auto found = object_.find(key);
        return error_ || found == object_.end() ? nullptr : &*found;
    }

private:
    double number(const nlohmann::json& value, const char* key, const Range& range) {
        if (value.is_number() && range.contains(value.get<double>())) return value.get<double>();
        refuse(key, "a number in " + range.text());
        return range.lowest;
    }

    template <std::size_t n>
    bool take_list(const char* key, std::array<double, n>& numbers, const Range& range) {
        const nlohmann::json* found = find(key);
        if (!found) return false;
        if (!found->is_array() || found->size() != n) {
            refuse(key, fmt::format("{} numbers in {}", n, range.text()));
            return false;
        }
        for (std::size_t i = 0; i < n; ++i) numbers[i] = number((*found)[i], key, range);
        return !error_;
    }

    const nlohmann::json& object_;
    std::string name_;
    std::set<std::string, std::less<>> known_;
    std::optional<Error> error_;
};

}  // namespace haarfield
