// Whether this is a build with the address sanitizer, in which tests take about ten times as long.
// It finds faults of memory in one turn of a loop as well as in ten: the other build takes them
// all.
#pragma once

namespace tetrec {

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
inline constexpr bool kIsSanitized = true;
#else
inline constexpr bool kIsSanitized = false;
#endif
#elif defined(__SANITIZE_ADDRESS__)
inline constexpr bool kIsSanitized = true;
#else
inline constexpr bool kIsSanitized = false;
#endif

}  // namespace tetrec
