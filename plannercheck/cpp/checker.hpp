// Verdicts for sets of configurations: posing and bounds in lanes, one configuration a lane; then pair tests.
//
// In: posed links (from the kinematics kernel or given), bodies on links, pairs of bodies. Out: for each configuration
// whether some pair shares a point, and which. Immutable: each thread brings a workspace, which holds what is learnt.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "kinematics.hpp"
#include "pair_test.hpp"

namespace plannercheck {

struct MountedBody {
  std::shared_ptr<const Body> body;
  std::int32_t link = -1;  // −1: fixed to the world
  Pose placement;          // on the link, or in the world
};

struct CheckerCounters {
  long states = 0, pairs = 0, spheres = 0, boxes = 0;  // pairs considered, and settled by bounds
  std::array<long, kStages> stages{};                  // pairs settled by each Stage
  PairCounters pair;
};

struct CheckerOptions {
  PairOptions pair;
  bool spheres = true;
  bool boxes = true;
};

// kLanes configurations at once: vectors and poses with one configuration a lane.
struct LaneVec3 {
  Lanes x, y, z;
};

struct LanePose {
  std::array<Lanes, 12> m;  // rows of the 3x4 matrix
};

class CheckerCore {
 public:
  CheckerCore(std::vector<MountedBody> bodies, std::vector<std::array<std::int32_t, 2>> pairs, std::int32_t links,
              CheckerOptions options);

  class Workspace {
   public:
    explicit Workspace(const CheckerCore& checker);
    CheckerCounters counters;

   private:
    friend class CheckerCore;
    std::vector<LanePose> poses;      // of the bodies, in the world
    std::vector<LaneVec3> centres;    // of the bodies, in the world
    std::vector<Lanes> slack, grown;  // rounding of posing a body; its radius enlarged by that
    std::vector<CachedPlane> planes;  // per pair
    std::vector<Lanes> columns, links, scratch;
  };

  std::size_t body_count() const { return bodies_.size(); }
  std::size_t pair_count() const { return pairs_.size(); }
  std::int32_t link_count() const { return links_; }

  // The pose of a body: its link's pose times its placement, the same bits as in every verdict. `links`: the links'
  // poses, row-major 4x4.
  Pose body_pose(std::size_t body, const double* links) const;

  // For each of n configurations (n, width): the index of the first pair that shares a point, in the order of the
  // table, or −1.
  void first_collisions(const Kinematics& kinematics, const double* q, std::size_t n, std::int32_t* first,
                        Workspace& workspace) const;
  // The same for links that are posed already: n times link_count() matrices, row-major 4x4.
  void first_collisions(const double* links, std::size_t n, std::int32_t* first, Workspace& workspace) const;
  // The same for every pair: colliding[i * pair_count() + k] for configuration i and pair k.
  void all_collisions(const double* links, std::size_t n, std::uint8_t* colliding, Workspace& workspace) const;

  // Whether the states (1 − t) q0 + t q1 at t = 0, 1/steps, …, 1 are all free; coarse to fine, so that a collision is
  // met early.
  bool motion_is_free(const Kinematics& kinematics, const double* q0, const double* q1, long steps,
                      Workspace& workspace) const;

 private:
  std::vector<MountedBody> bodies_;
  std::vector<std::array<std::int32_t, 2>> pairs_;  // guest, host
  std::int32_t links_;
  std::vector<unsigned char> needed_;  // links that some body of a pair hangs on
  std::vector<std::int32_t> moving_;   // bodies of pairs that hang on a link
  CheckerOptions options_;

  void reserve_lanes(const Kinematics& kinematics, Workspace& workspace) const;
  void load_links(const double* links, std::size_t n, Workspace& workspace) const;
  void pose_bodies(Workspace& workspace) const;
  void bound_body(std::size_t body, Workspace& workspace) const;
  // Lanes of `open` that no bound settles.
  unsigned near(std::size_t pair, unsigned open, Workspace& workspace) const;
  unsigned spheres_meet(std::size_t a, std::size_t b, const Workspace& workspace) const;
  unsigned sphere_meets_box(std::size_t sphere, std::size_t box, const Workspace& workspace) const;
  // Lanes of `open` in which the pair shares a point.
  unsigned collides(std::size_t pair, unsigned open, Workspace& workspace) const;
  // The first colliding pair of each lane of `open`.
  std::array<std::int32_t, kLanes> judge(unsigned open, Workspace& workspace) const;
};

}  // namespace plannercheck
