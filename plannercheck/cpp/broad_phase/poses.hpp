// The two sources of poses for filters: a block of states, in lanes, and one state.
//
// Both have a link's pose in floats, in lanes over states or over pairs, and the pose's error besides rounding. Poses
// in doubles are rounded before they become a block.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "broad_phase/block_cache.hpp"
#include "broad_phase/block_configurations.hpp"
#include "broad_phase/float_pose_error.hpp"
#include "broad_phase/state_block.hpp"
#include "robots/pose_columns.hpp"

namespace plannercheck {

struct FloatBlock {
  typedef StateFloats Numbers;  // a state in each lane

  const FloatPose* poses;    // by link; those without a body may be missing
  const PoseError* errors;   // by link
  BlockConfigurations q;     // where they are known
  int count;                 // of states: the first lanes
  std::uint64_t always = 0;  // if not 0: all blocks with this number have these errors, at any poses

  unsigned all() const { return (1U << count) - 1; }
  const FloatPose& pose(std::size_t link) const { return poses[link]; }
  PoseError error(std::size_t link) const { return errors[link]; }
};

// Poses of a block in doubles, rounded.
class RoundedPoses {
 public:
  explicit RoundedPoses(std::size_t links = 0) : poses_(links), none_(links) {}

  // `poses`: of the next block (state_block.hpp); they have to outlive it.
  void begin(const Lanes* poses) {
    from_ = poses;
    poses_.begin();
  }
  void round(std::size_t link) {
    poses_.of(link, false, [&](FloatPose& out) { round_to_floats(from_, none_.size(), link, out); });
  }
  FloatBlock block(BlockConfigurations q, int count) const { return {poses_.values(), none_.data(), q, count}; }

 private:
  const Lanes* from_ = nullptr;
  BlockCache<FloatPose> poses_;
  std::vector<PoseError> none_;  // by link
};

class SingleState {
 public:
  typedef Floats Numbers;  // the same in all lanes

  explicit SingleState(std::size_t links = 0) : rounded_(links) {}

  // `columns`: by link, in doubles; `q`: the configuration. Both have to outlive the state.
  void begin(const PoseColumns* columns, const double* q) {
    columns_ = columns, q_ = q;
    rounded_.begin();
  }

  static constexpr int count = 1;
  static unsigned all() { return 1; }
  const PoseColumns* columns() const { return columns_; }
  double number(std::size_t column) const { return q_[column]; }
  const FloatStatePose& pose(std::size_t link) {
    return rounded_.of(link, false, [&](FloatStatePose& out) {
      const PoseColumns& pose = columns_[link];
      for (std::size_t i = 0; i < out.m.size(); ++i) out.m[i] = Floats{} + static_cast<float>(pose.at(i / 4, i % 4));
    });
  }
  static PoseError error(std::size_t) { return {}; }

 private:
  const PoseColumns* columns_ = nullptr;
  const double* q_ = nullptr;
  BlockCache<FloatStatePose> rounded_;
};

}  // namespace plannercheck
