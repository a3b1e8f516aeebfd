#pragma once
/// The sanitizers of this build, by g++ or clang++.

namespace haarfield {

/// True: the build has AddressSanitizer.
inline constexpr bool is_address_sanitized =
#if defined(__SANITIZE_ADDRESS__)
    true;
#elif defined(__has_feature)
    __has_feature(address_sanitizer);
#else
    false;
#endif

/// True: the build has ThreadSanitizer.
inline constexpr bool is_thread_sanitized =
#if defined(__SANITIZE_THREAD__)
    true;
#elif defined(__has_feature)
    __has_feature(thread_sanitizer);
#else
    false;
#endif

/// True: the sanitizer reserves so much address space that this cannot be limited.
inline constexpr bool has_shadow_memory = is_address_sanitized || is_thread_sanitized;

}  // namespace haarfield
