// Links' poses in the states of a block, rounded to floats when the block first asks for them.
#pragma once

#include "broad_phase/block_cache.hpp"
#include "broad_phase/state_block.hpp"
#include "robots/pose_columns.hpp"

namespace plannercheck {

class RoundedLinks {
 public:
  explicit RoundedLinks(std::size_t links = 0) : links_(links), rounded_(links) {}

  // `poses`: of a block's links (state_block.hpp); they have to outlive the block.
  void begin(const Lanes* poses) {
    block_ = poses, state_ = nullptr;
    rounded_.begin();
  }
  // `poses`: of one state's links, which every lane gets; they have to outlive it.
  void begin(const PoseColumns* poses) {
    block_ = nullptr, state_ = poses;
    rounded_.begin();
  }

  bool are_of_one_state() const { return block_ == nullptr; }

  const FloatPose& of(std::size_t link) {
    return rounded_.of(link, false, [&](FloatPose& out) {
      if (block_ != nullptr) return round_to_floats(block_, links_, link, out);
      const PoseColumns& pose = state_[link];
      for (std::size_t i = 0; i < out.m.size(); ++i)
        out.m[i] = StateFloats{} + static_cast<float>(pose.at(i / 4, i % 4));
    });
  }

 private:
  std::size_t links_;
  const Lanes* block_ = nullptr;
  const PoseColumns* state_ = nullptr;
  BlockCache<FloatPose> rounded_;
};

}  // namespace plannercheck
