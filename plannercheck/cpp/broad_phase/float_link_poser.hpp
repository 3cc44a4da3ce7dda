// Forward kinematics in floats for a block of states at once, with a bound of their error: poses for filters, four
// times as fast as poses in doubles.
//
// In: the table of joints (robots/kinematics.hpp), configurations in lanes. Out: links' poses, and how far poses in
// doubles may be from them. Only joints that turn about or slide along an axis are posed. The steps are the steps of
// robots/kinematics_lanes.hpp, except that a turn about an axis that is no axis of the frame is a turn about z between
// two placements. A workspace: it keeps its memory.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "broad_phase/float_pose_error.hpp"
#include "broad_phase/float_sincos.hpp"
#include "broad_phase/poses.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"
#include "robots/kinematics.hpp"

namespace plannercheck {

class FloatLinkPoser {
 public:
  // needed[link] != 0 marks the links to pose. If the kinematics can't be posed in floats, is_possible() is false.
  void begin(const Kinematics& kinematics, const unsigned char* needed);
  bool is_possible() const { return is_possible_; }

  // q: number c of the configurations of group g at q[g * width() + c]. Returns false, and poses nothing, if an angle
  // or a distance is too large or NaN.
  bool pose(const Lanes* q);

  // The poses of the needed links in the first `count` states of q. A pose is infinite or NaN where a placement or a
  // held slide is beyond floats; a filter then takes the body to be anywhere.
  FloatBlock block(BlockConfigurations q, int count) const {
    return {poses_.data(), errors_.data(), q, count, slides_anywhere_ ? 0 : kinematics_};
  }

 private:
  enum class Motion { kNone, kTurnX, kTurnY, kTurnZ, kSlide };

  // What is posed on `parent`: a place among the poses, the world, or the pose that the step before left.
  struct Step {
    int parent, to;
    PlacementForm form;
    std::array<float, 12> placement;
    Motion motion;
    std::array<float, 3> axis;  // of a slide
    JointValue value;           // of the motion
  };

  std::size_t width_ = 0;
  std::vector<Step> steps_;
  std::vector<std::size_t> read_;       // steps whose values are those of a configuration
  std::vector<FloatSinCos> turns_;      // by step,
  std::vector<StateFloats> slides_;     // or how far it slides
  std::vector<FloatPose> poses_;        // of links, then of joints that are no link's
  std::vector<FloatPoseError> bounds_;  // of these
  FloatPoseError in_hand_;              // that of the last step
  std::vector<std::size_t> links_;      // that are posed
  std::vector<PoseError> errors_;       // by link
  double held_slide_ = 0;               // the largest one
  bool slides_anywhere_ = false;        // whether a joint that is not held does
  bool is_possible_ = false;
  std::uint64_t kinematics_ = 0;

  void add_joint(const Kinematics::Joint& joint, int parent, int to);
  void add(Step step, const Rigid& placement, const double* axis);
  bool read_values(const Lanes* q);
  void bound_errors(double slid);
};

}  // namespace plannercheck
