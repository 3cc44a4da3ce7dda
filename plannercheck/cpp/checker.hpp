// Verdicts for sets of configurations: posing, spheres, pair tests.
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
  std::array<long, 5> stages{};             // pairs settled by each Stage
  PairCounters pair;
};

struct CheckerOptions {
  PairOptions pair;
  bool spheres = true;
  bool boxes = true;
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
    std::vector<Pose> poses;               // of the bodies, in the world
    std::vector<Vec3> centres;             // of the bodies, in the world
    std::vector<long> posed_for;           // the state a body was last posed for
    std::vector<CachedPlane> planes;       // per pair
    std::vector<Lanes> links, scratch;
    long state = 0;
  };

  std::size_t body_count() const { return bodies_.size(); }
  std::size_t pair_count() const { return pairs_.size(); }
  std::int32_t link_count() const { return links_; }
  const std::vector<unsigned char>& needed_links() const { return needed_; }

  // The pose of a body: its link's pose times its placement; the same bits wherever it is computed. `links`: the links'
  // poses, row-major 3x4, `stride` apart.
  Pose body_pose(std::size_t body, const double* links, std::size_t stride) const;

  // Index of the first pair that shares a point, in the order of the table, or −1. `links`: row-major 3x4 each.
  std::int32_t first_collision(const double* links, std::size_t stride, Workspace& workspace) const;
  // The same for every pair: colliding[k] for pair k.
  void all_collisions(const double* links, std::size_t stride, Workspace& workspace, bool* colliding) const;
  // What decides one pair, in full.
  PairVerdict explain_pair(std::size_t pair, const double* links, std::size_t stride, Workspace& workspace, PosedBody* guest,
                           PosedBody* host) const;

  // first_collision of n configurations (n, width) through the kernel.
  void check(const Kinematics& kinematics, const double* q, std::size_t n, std::int32_t* first, Workspace& workspace) const;

 private:
  std::vector<MountedBody> bodies_;
  std::vector<std::array<std::int32_t, 2>> pairs_;  // guest, host
  std::int32_t links_;
  std::vector<unsigned char> needed_;
  CheckerOptions options_;

  void pose_for(std::int32_t body, const double* links, std::size_t stride, Workspace& workspace) const;
  bool spheres_apart(std::int32_t a, std::int32_t b, const Workspace& workspace) const;
  bool sphere_misses_box(std::int32_t sphere, std::int32_t box, const Workspace& workspace) const;
  bool collides(std::size_t pair, const double* links, std::size_t stride, Workspace& workspace) const;
};

}  // namespace plannercheck
