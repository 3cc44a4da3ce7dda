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
  const Kinematics* kinematics_ = nullptr;
  PosingOrder order_;
  std::vector<Lanes> homeless_;

  Lanes* at_joint(int joint, Lanes* out);
};

}  // namespace plannercheck
