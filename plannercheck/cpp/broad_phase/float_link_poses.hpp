// Links' poses in floats in the states of a block: rounded from doubles when the block first asks for them, or given,
// and how far they may be off besides rounding.
#pragma once

#include "broad_phase/block_cache.hpp"
#include "broad_phase/float_pose_error.hpp"
#include "broad_phase/state_block.hpp"
#include "robots/pose_columns.hpp"

namespace plannercheck {

class FloatLinkPoses {
 public:
  explicit FloatLinkPoses(std::size_t links = 0) : links_(links), rounded_(links), of_state_(links) {}

  // `poses`: of a block's links (state_block.hpp); they have to outlive the block.
  void begin(const Lanes* poses) {
    block_ = poses, state_ = nullptr, given_ = nullptr;
    rounded_.begin();
  }
  // `poses`: of one state's links; they have to outlive it.
  void begin(const PoseColumns* poses) {
    block_ = nullptr, state_ = poses, given_ = nullptr;
    of_state_.begin();
  }
  // `poses`, `errors`: of a block's links; they have to outlive the block.
  void begin(const FloatPose* poses, const PoseError* errors) {
    block_ = nullptr, state_ = nullptr, given_ = poses;
    errors_ = errors;
  }

  bool are_of_one_state() const { return state_ != nullptr; }

  const FloatPose& of(std::size_t link) {
    if (given_ != nullptr) return given_[link];
    return rounded_.of(link, false, [&](FloatPose& out) { round_to_floats(block_, links_, link, out); });
  }

  // Of one state.
  const FloatStatePose& of_state(std::size_t link) {
    return of_state_.of(link, false, [&](FloatStatePose& out) {
      const PoseColumns& pose = state_[link];
      for (std::size_t i = 0; i < out.m.size(); ++i) out.m[i] = Floats{} + static_cast<float>(pose.at(i / 4, i % 4));
    });
  }

  PoseError error(std::size_t link) const { return given_ != nullptr ? errors_[link] : PoseError{}; }

 private:
  std::size_t links_;
  const Lanes* block_ = nullptr;
  const PoseColumns* state_ = nullptr;
  const FloatPose* given_ = nullptr;
  const PoseError* errors_ = nullptr;
  BlockCache<FloatPose> rounded_;
  BlockCache<FloatStatePose> of_state_;
};

}  // namespace plannercheck
