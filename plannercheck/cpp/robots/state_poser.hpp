// Forward kinematics of a single configuration.
//
// In: the table of kinematics.hpp, one configuration. Out: poses of the needed links, by columns. Idea: lanes over
// states would be empty but for one. So lanes run over joints for sines and cosines, and over a matrix's rows for
// products of poses: placements and turns then mix whole columns. The operations on each number are those of
// kinematics_lanes.hpp, in their order: the poses have the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/simd.hpp"
#include "robots/kinematics.hpp"
#include "robots/pose_columns.hpp"
#include "robots/posing_order.hpp"

namespace plannercheck {

// Poses only the links that its caller needs. A workspace: it keeps its memory.
class StatePoser {
 public:
  // needed[link] != 0: for all links. The kinematics has to outlive the calls of `pose`.
  void begin(const Kinematics& kinematics, const unsigned char* needed);

  // q: width() numbers. Returns link_count() poses, of which only needed ones are written; valid until the next call.
  const PoseColumns* pose(const double* q);
  // A joint that carries a needed link, as it was posed last.
  const PoseColumns& of_joint(int joint) const { return poses_[at(places_[at(joint)])]; }

 private:
  // What is posed on `parent`, a place among the poses, or in the world if that is below 0.
  struct Step {
    int parent, to;
    PlacementForm form;
    Rigid placement;
    const Kinematics::Joint* joint;  // that moves it, or null for a link on a joint
    int turn;                        // the place of its angle, or −1
  };

  std::vector<Step> steps_;
  int turns_ = 0;
  // Eight lanes, on AVX-512, would slow down what follows them by more than they save (measured).
  static constexpr int kAngleLanes = kLanes < kDouble4Lanes ? kLanes : kDouble4Lanes;
  typedef double AngleLanes __attribute__((vector_size(kAngleLanes * 8)));

  // The angles of as many joints as there are lanes: a number of the configuration times a factor, plus an offset.
  struct Angles {
    std::array<std::int32_t, kAngleLanes> column{};
    AngleLanes multiplier{}, offset{};
  };

  std::vector<Angles> angles_;
  std::vector<AngleLanes> cos_, sin_;
  std::vector<PoseColumns> poses_;    // of links, then of joints that are no link's
  std::vector<std::int32_t> places_;  // of the joints among them, below 0 for those that carry no needed link

  int add_angle(const JointValue& value);
  void add(int parent, int to, const Rigid& placement, PlacementForm form, const Kinematics::Joint* joint);
  void take_turns(const double* q);
  [[gnu::always_inline]] void move_by(const Step& step, const double* q, PoseColumns& pose) const;
};

}  // namespace plannercheck
