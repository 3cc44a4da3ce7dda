// Whether two bodies, or the sets that two bodies sweep between two poses, are further apart than a limit.
//
// In: both bodies posed once, or at both ends of an interval, and the frame in which directions are kept. Out: a
// direction along which the bodies are more than the limit apart at all these poses; or that they are not. Idea:
// Gilbert, Johnson and Keerthi's descent on the hull of the bodies' differences at all poses, seen from the frame. It
// ends as soon as a lower or an upper bound is on one side of the limit. "Apart" relies only on the lower bound: the
// least product of the direction with a difference, from an extreme vertex of each body.
#pragma once

#include <array>

#include "motions/motion_report.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// Rotation of the frame in the world, row-major; the identity if the frame is the world.
struct FrameTurn {
  std::array<double, 9> m{1, 0, 0, 0, 1, 0, 0, 0, 1};

  Vec3 to_world(Vec3 v) const {
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
            m[6] * v.x + m[7] * v.y + m[8] * v.z};
  }
  Vec3 from_world(Vec3 v) const {
    return {m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
            m[2] * v.x + m[5] * v.y + m[8] * v.z};
  }
};

// Both bodies and their frame at one parameter.
struct PosedPair {
  Pose a, b;
  FrameTurn frame;
};

// The descent on the vertices of the bodies (without their inflation radii) at `count` poses, one at least, from an
// initial direction.
SweptAnswer<Vec3> swept_distance(const Polytope& a, const Polytope& b, const PosedPair* poses, int count, double limit,
                                 Vec3 hint, PairCounters& counters);

// The gap of the vertices, at one pose, along a direction of the frame.
double gap_along(const Polytope& a, const Polytope& b, const PosedPair& pose, Vec3 direction, PairCounters& counters);

}  // namespace plannercheck
