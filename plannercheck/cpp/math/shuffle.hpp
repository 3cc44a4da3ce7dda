// In: two vectors of one type, and places; places of the second vector continue the count of the first. Out: the vector
// of the numbers at the places.
//
// Clang, and GCC from version 12, have one builtin for it. For GCC 11 the numbers are put together one by one.
#pragma once

#include <type_traits>

namespace plannercheck {

template <int... places, class Vector>
inline auto shuffled(Vector first, Vector second) {
#if __has_builtin(__builtin_shufflevector)
  return __builtin_shufflevector(first, second, places...);
#else
  using Number = std::remove_reference_t<decltype(first[0])>;
  constexpr int count = sizeof(Vector) / sizeof(Number);
  typedef Number Out __attribute__((vector_size(sizeof...(places) * sizeof(Number))));
  return Out{(places < count ? first : second)[places % count]...};
#endif
}

}  // namespace plannercheck
