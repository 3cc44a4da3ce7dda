// Verdicts for sets of configurations of a planar robot: bounding circles posed in lanes, then exact pair tests.
//
// In: a chain of links, convex polygons on links or in the world, pairs of them, configurations. Out: for each
// configuration whether some pair shares a point, and which. Immutable; threads may share it. The poses are the same
// bits on every instruction set. Free of lanes, whose number differs between instruction sets.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "planar/polygon_test.hpp"

namespace plannercheck {

enum class PlanarJoint { kFixed, kRevolute, kFree };

// A link's frame: at `x`, `y` on its parent's (on the world's if there is none), turned by `angle` and by its joint.
struct PlanarLink {
  std::int32_t parent = -1;  // an earlier link, or the world
  PlanarJoint joint = PlanarJoint::kFixed;
  std::int32_t column = 0;  // in the configuration: of an angle, or of x, y, angle for a free joint
  double x = 0, y = 0, angle = 0;
};

struct PlanarGeometryObject {
  PlanarPolygon shape;     // not owned
  std::int32_t link = -1;  // -1: in the world
  PlanarPose pose;         // in the world, if the body is on no link
  double x = 0, y = 0;     // a circle around it in its frame; its radius has room for rounding
  double radius = 0;
  std::array<double, 4> box{};  // if on no link: least x, y, largest x, y in the world; with room
};

struct PlanarCheckerCounters {
  long states = 0, pairs = 0;
  long bounds = 0;   // pairs whose circles and boxes do not meet
  long tests = 0;    // pairs given to the algorithm
  long skipped = 0;  // pairs of states whose verdict was already known
  PlanarCounters pair;
};

inline PlanarCheckerCounters& operator+=(PlanarCheckerCounters& sum, const PlanarCheckerCounters& more) {
  sum.states += more.states, sum.pairs += more.pairs, sum.bounds += more.bounds;
  sum.tests += more.tests, sum.skipped += more.skipped;
  sum.pair += more.pair;
  return sum;
}

class PlanarChecker {
 public:
  PlanarChecker(std::vector<PlanarLink> links, std::int32_t width, std::vector<PlanarGeometryObject> bodies,
                std::vector<std::array<std::int32_t, 2>> pairs, bool bounds, Precision first)
      : links_(std::move(links)),
        width_(static_cast<std::size_t>(width)),
        bodies_(std::move(bodies)),
        pairs_(std::move(pairs)),
        bounds_(bounds),
        first_(first) {}

  // The poses and counts of one thread.
  struct Workspace;
  std::shared_ptr<Workspace> new_workspace() const;
  // The counts since the last call.
  static PlanarCheckerCounters take_counters(Workspace& workspace);

  std::size_t width() const { return width_; }
  std::size_t link_count() const { return links_.size(); }
  std::size_t pair_count() const { return pairs_.size(); }

  // Poses of all links (n, links, 3, 3) at n configurations (n, width).
  void link_poses(const double* q, std::size_t n, double* poses) const;
  // The index of the first pair that shares a point, or -1.
  void first_collisions(const double* q, std::size_t n, std::int32_t* first, Workspace& workspace) const;
  // colliding[i * pair_count() + k] for configuration i and pair k.
  void all_collisions(const double* q, std::size_t n, std::uint8_t* colliding, Workspace& workspace) const;
  // Whether the states (1 - t) q0 + t q1 at t = 0, 1/steps, ..., 1 are all free; coarse to fine.
  bool motion_is_free(const double* q0, const double* q1, long steps, Workspace& workspace) const;

 private:
  std::vector<PlanarLink> links_;
  std::size_t width_;
  std::vector<PlanarGeometryObject> bodies_;
  std::vector<std::array<std::int32_t, 2>> pairs_;
  bool bounds_;
  Precision first_;

  void pose(Workspace& workspace) const;
  unsigned near(const std::array<std::int32_t, 2>& pair, const Workspace& workspace) const;
  PosedPolygon posed(std::int32_t body, std::size_t state, const Workspace& workspace) const;
  // Loads n configurations in blocks and calls work(row, how many) for each.
  template <class Work>
  void each_block(const double* q, std::size_t n, Workspace& workspace, Work work) const;
  template <class Found>
  void judge(std::size_t count, bool first_only, Workspace& workspace, Found found) const;
};

}  // namespace plannercheck
