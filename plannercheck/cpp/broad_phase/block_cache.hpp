// Per body, a value posed for a block of states, computed when the block first asks for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

namespace plannercheck {

template <class Value>
class BlockCache {
 public:
  explicit BlockCache(std::size_t bodies = 0) : values_(new Value[bodies]), block_of_(bodies) {
    static_assert(std::is_trivially_default_constructible_v<Value>);
  }

  // Starts a new block.
  void begin() { ++block_; }

  // pose(value) computes a body's value: once a block, or only once if the body is fixed. Most calls find the value, so
  // only this part is inlined; `pose` had better be a call.
  template <class Pose>
  [[gnu::always_inline]] const Value& of(std::size_t body, bool fixed, Pose pose) {
    Value& value = values_[body];
    std::uint64_t& last = block_of_[body];
    if (last == block_ || (fixed && last != 0)) [[likely]]
      return value;
    pose(value);
    last = block_;
    return value;
  }

  // By body; set only for bodies that were asked for.
  const Value* values() const { return values_.get(); }

 private:
  // Not initialised: few of many obstacles are ever asked for, and the others then take no memory.
  std::unique_ptr<Value[]> values_;
  std::vector<std::uint64_t> block_of_;  // the block for which a body was posed last
  std::uint64_t block_ = 1;
};

}  // namespace plannercheck
