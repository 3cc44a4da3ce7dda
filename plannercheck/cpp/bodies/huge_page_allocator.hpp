// Memory for large arrays that are read at random, on large pages where the system has them: a miss of the address
// table costs as much as one of the cache.
#pragma once

#include <cstddef>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace plannercheck {

// An allocator that compares equal for all arrays, so that they may move into each other.
template <class T>
struct HugePageAllocator {
  using value_type = T;

  static constexpr std::size_t kPage = std::size_t{1} << 21;  // bytes: 2 MiB on x86-64 and aarch64
  static constexpr std::size_t kLeast = 2 * kPage;            // bytes: smaller arrays would waste much of a page

  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    void* const at = ::operator new(bytes, alignment(bytes));
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    if (bytes >= kLeast) madvise(at, bytes, MADV_HUGEPAGE);  // only advice: it may fail without harm
#endif
    return static_cast<T*>(at);
  }

  void deallocate(T* at, std::size_t count) { ::operator delete(at, alignment(count * sizeof(T))); }

  template <class U>
  bool operator==(const HugePageAllocator<U>&) const {
    return true;
  }

 private:
  static std::align_val_t alignment(std::size_t bytes) {
    return std::align_val_t{bytes >= kLeast ? kPage : alignof(T)};
  }
};

}  // namespace plannercheck
