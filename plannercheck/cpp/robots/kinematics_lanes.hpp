// Forward kinematics of kLanes configurations at once: the kernel of kinematics.hpp, for callers that keep lanes.
#pragma once

#include <vector>

#include "math/simd.hpp"
#include "robots/kinematics.hpp"
#include "robots/posing_order.hpp"

namespace plannercheck {

// Poses only the links that its caller needs. A workspace: it keeps its memory.
class LinkPoser {
 public:
  // needed[link] != 0: for all links. The kinematics has to outlive the calls of `pose`.
  void begin(const Kinematics& kinematics, const unsigned char* needed);

  // q: width() Lanes; out: link_count() * 12 Lanes, row-major 3x4 each, of which only needed links are written.
  void pose(const Lanes* q, Lanes* out);

 private:
  // What is posed on `parent`, a place among the poses, or in the world if that is below 0.
  struct Step {
    int parent, to;
    PlacementForm form;
    const Rigid* placement;
    const Kinematics::Joint* joint;  // that moves it, or null for a link on a joint
    std::size_t values;              // the place of the joint's values
  };

  std::size_t links_ = 0;
  std::vector<Step> steps_;
  std::vector<std::size_t> read_;  // steps whose joints' values are those of a configuration
  std::vector<Lanes> values_;      // of all joints
  std::vector<Lanes> homeless_;    // poses of joints that are no link's: their places follow those of links

  Lanes* pose_at(int place, Lanes* out);
};

}  // namespace plannercheck
