// The sanitizer that a test is built with.
#pragma once

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define GLOWWORM_ADDRESS_SANITIZER
#elif __has_feature(thread_sanitizer)
#define GLOWWORM_THREAD_SANITIZER
#endif
#endif

namespace glowworm {

#if defined(GLOWWORM_ADDRESS_SANITIZER) || defined(__SANITIZE_ADDRESS__)
inline constexpr bool kAddressSanitizer = true;
#else
inline constexpr bool kAddressSanitizer = false;
#endif

#if defined(GLOWWORM_THREAD_SANITIZER) || defined(__SANITIZE_THREAD__)
inline constexpr bool kThreadSanitizer = true;
#else
inline constexpr bool kThreadSanitizer = false;
#endif

}  // namespace glowworm
