#pragma once
/// The inputs of a relighting session, and values that are computed from them once.

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "shading/scene/shaded_scene.h"
#include "shading/transfer/sparse_vectors.h"

namespace haarfield {

/// A light as coefficients, which replaces the environment.
struct GivenLight {
    DenseCoefficients smooth;              ///< The environment minus its sources.
    std::vector<DirectionalLight> lights;  ///< The lights of the sources.
};

/// The inputs that change independently of each other.
enum class SessionInput : std::uint8_t {
    environment,
    rotation,
    shown_light,
    lamps,
    emitters,
    materials,
    instances,
    eye,
    exact_distances,  ///< Distances within which objects are rasterized; with Occlusion::automatic they
                      ///< change with the environment.
};

/// By SessionInput: the number of changes so far.
using InputVersions = std::array<std::uint64_t, 9>;

/// Everything that the radiance of a session depends on.
struct SessionInputs {
    ShadedScene scene;  ///< Its environment is that of the last commit.
    Environment environment;
    Rotation rotation;                      ///< Of the environment.
    std::optional<GivenLight> shown_light;  ///< Replaces the environment in frames.
    RenderSettings settings;                ///< Only the occlusion changes.
    InputVersions versions{};

    /// Returns the number of changes of an input.
    std::uint64_t version(SessionInput input) const { return versions[std::size_t(input)]; }

    /// Replaces an input unless the value is equal. Values of types without == are always replaced.
    template <class T>
    void set(SessionInput input, T& place, T value) {
        if constexpr (requires { place == value; })
            if (place == value) return;
        place = std::move(value);
        changed(input);
    }
    /// Counts a change of an input.
    void changed(SessionInput input) { ++versions[std::size_t(input)]; }
};

/// A value, and the versions of the inputs that it was computed from.
template <class T, SessionInput... from>
class Memo {
public:
    /// Returns the value; null if there is none, or an input has changed since.
    T* find(const SessionInputs& now) { return is_current(now) ? &*value_ : nullptr; }
    /// See above.
    const T* find(const SessionInputs& now) const { return is_current(now) ? &*value_ : nullptr; }

    /// Returns the value even if inputs have changed since; null if there is none.
    T* last() { return value_ ? &*value_ : nullptr; }
    /// See above.
    const T* last() const { return value_ ? &*value_ : nullptr; }

    /// Stores a value that was computed from the current inputs.
    T& store(T value, const SessionInputs& now) {
        value_ = std::move(value);
        versions_ = {now.version(from)...};
        return *value_;
    }

    /// Frees the memory of a value that is not current.
    void drop_outdated(const SessionInputs& now) {
        if (!is_current(now)) value_.reset();
    }

private:
    bool is_current(const SessionInputs& now) const {
        return value_ && versions_ == std::array{now.version(from)...};
    }

    std::optional<T> value_;
    std::array<std::uint64_t, sizeof...(from)> versions_{};
};

}  // namespace haarfield
