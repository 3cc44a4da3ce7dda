// A short array of 64-bit digits, little endian: in place up to kInlineLimbs, on the heap beyond; uninitialised.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace plannercheck {

// 1024 bits: room for squared heights over triangles, which have degree 6 in posed coordinates of some 150 bits each at
// everyday scales; weights have degree 4. Copies only touch the digits in use.
inline constexpr std::size_t kInlineLimbs = 16;

class Limbs {
 public:
  Limbs() = default;
  Limbs(const Limbs& other) {
    reserve(other.size_);
    std::copy_n(other.data(), size_, data());
  }
  Limbs(Limbs&& other) noexcept : size_(other.size_), heap_(std::move(other.heap_)) {
    if (!heap_) std::copy_n(other.in_place_, size_, in_place_);
    other.size_ = 0;
  }
  Limbs& operator=(Limbs&& other) noexcept {
    if (this == &other) return *this;
    size_ = other.size_;
    heap_ = std::move(other.heap_);
    if (!heap_) std::copy_n(other.in_place_, size_, in_place_);
    other.size_ = 0;
    return *this;
  }
  Limbs& operator=(const Limbs& other) { return *this = Limbs(other); }
  ~Limbs() = default;

  // Makes room for new contents.
  void reserve(std::size_t size) {
    size_ = size;
    if (size > kInlineLimbs) {
      heap_ = std::make_unique_for_overwrite<std::uint64_t[]>(size);
    } else {
      heap_.reset();
    }
  }

  std::size_t size() const { return size_; }
  std::uint64_t* data() { return heap_ ? heap_.get() : in_place_; }
  const std::uint64_t* data() const { return heap_ ? heap_.get() : in_place_; }
  std::uint64_t& operator[](std::size_t i) { return data()[i]; }
  std::uint64_t operator[](std::size_t i) const { return data()[i]; }
  std::uint64_t back() const { return data()[size_ - 1]; }

  // Drops zero digits at both ends; returns how many at the low end.
  std::size_t trim() {
    std::uint64_t* const d = data();
    while (size_ > 0 && d[size_ - 1] == 0) --size_;
    std::size_t zeros = 0;
    while (zeros < size_ && d[zeros] == 0) ++zeros;
    if (zeros > 0) std::copy(d + zeros, d + size_, d);
    size_ -= zeros;
    return zeros;
  }

 private:
  std::size_t size_ = 0;
  std::unique_ptr<std::uint64_t[]> heap_;
  std::uint64_t in_place_[kInlineLimbs];  // NOLINT: left as it is
};

}  // namespace plannercheck
