// Links' poses in the states of a block, rounded to floats when the block first asks for them.
#pragma once

#include "broad_phase/block_cache.hpp"
#include "broad_phase/state_block.hpp"

namespace plannercheck {

class RoundedLinks {
 public:
  explicit RoundedLinks(std::size_t links = 0) : links_(links), rounded_(links) {}

  // `poses`: of a block's links (state_block.hpp); they have to outlive the block.
  void begin(const Lanes* poses) {
    poses_ = poses;
    rounded_.begin();
  }

  const FloatPose& of(std::size_t link) {
    return rounded_.of(link, false, [&](FloatPose& out) { round_to_floats(poses_, links_, link, out); });
  }

 private:
  std::size_t links_;
  const Lanes* poses_ = nullptr;
  BlockCache<FloatPose> rounded_;
};

}  // namespace plannercheck
