// coal as fast as a careful user gets it: a loop over posed states without Python, built by compiled_coal_loop.py.
//
// In: convex shapes and meshes, pairs of bodies, poses of the moving bodies in many states (coal's transforms are made
// beforehand, so that kinematics cost nothing). Out: which groups of states are free; a group ends at its first
// collision. Or of every pair in every state, whether it collides. Meshes are trees of boxes around triangles. The
// idea: boxes along the world's axes first, tested over all partners of a body at once; boxes in the bodies' frames
// where asked for; then coal's narrow phase without contacts, which stops as soon as it has a separating plane, each
// pair with a solver of its own and, where asked for, the guess that its last call left. The pair that collided last is
// asked first: successive states of a motion mostly collide alike.
#include <coal/BV/OBB.h>
#include <coal/collision.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "coal_shapes.hpp"

namespace {

using coal::Transform3s;
using coal::Vec3s;

// World boxes grow by this part of their size and distance from the origin, far above the rounding of a pose.
constexpr double kBoxSlack = 1e-12;

// How the loop asks, in the order of coal_loop.py's `Variant`.
struct Settings {
  int gjk;    // coal::GJKVariant
  int guess;  // coal::GJKInitialGuess
  int boxes;  // 0 none, 1 along the world's axes, 2 in the bodies' frames as well
};

struct Pair {
  int p, r;
  coal::ComputeCollision collide;
  Vec3s guess{1, 0, 0};
  coal::support_func_guess_t support_guess = coal::support_func_guess_t::Zero();
};

// Boxes along the world's axes as one array a coordinate.
struct Boxes {
  std::vector<double> centre[3], half[3];

  void resize(std::size_t n) {
    for (int k = 0; k < 3; ++k) {
      centre[k].resize(n);
      half[k].resize(n);
    }
  }
  void set(std::size_t at, const Vec3s& middle, const Vec3s& extent) {
    for (int k = 0; k < 3; ++k) {
      centre[k][at] = middle[k];
      half[k][at] = extent[k] + kBoxSlack * (std::abs(middle[k]) + extent[k]);
    }
  }
};

// A body that moves, with those of its partners that stand still.
struct Mover {
  int body;
  std::vector<int> pairs;  // pair of each partner
  Boxes partners;
};

struct States {
  std::vector<Transform3s> poses;  // (states, movers)
  std::size_t count;
};

}  // namespace

class CoalLoop {
 public:
  std::string error;

  void add_shape(int kind, const double* numbers, const double* points, int n, const int* triangles, int m) {
    shapes_.push_back(coal_shape(kind, numbers, points, n, triangles, m));
    shapes_.back()->computeLocalAABB();
  }

  // Bodies by shape, where those that stand still are, and the pairs; a pair of two movers, or a mover and another.
  void set_bodies(int bodies, const int* shape_of, const std::uint8_t* moves, const double* poses) {
    for (int b = 0; b < bodies; ++b) {
      shape_of_.push_back(shapes_[shape_of[b]].get());
      mover_of_.push_back(moves[b] ? static_cast<int>(movers_.size()) : -1);
      if (moves[b]) movers_.push_back(Mover{b, {}, {}});
      placed_.push_back(transform(poses + 16 * b));
    }
    boxes_.resize(movers_.size());
  }

  void set_pairs(int count, const int* pairs) {
    pairs_.reserve(count);
    for (int k = 0; k < count; ++k) {
      int p = pairs[2 * k], r = pairs[2 * k + 1];
      if (mover_of_[p] < 0) std::swap(p, r);
      pairs_.push_back(Pair{p, r, coal::ComputeCollision(shape_of_[p], shape_of_[r])});
      if (mover_of_[r] < 0)
        movers_[mover_of_[p]].pairs.push_back(k);
      else
        both_move_.push_back(k);
    }
    for (Mover& mover : movers_) {
      mover.partners.resize(mover.pairs.size());
      for (std::size_t i = 0; i < mover.pairs.size(); ++i) {
        const int body = pairs_[mover.pairs[i]].r;
        const auto [middle, extent] = world_box(body, placed_[body]);
        mover.partners.set(i, middle, extent);
      }
      most_ = std::max(most_, mover.pairs.size());
    }
    near_.resize(most_);
  }

  // States with the poses (count, movers, 4, 4) of all bodies that move.
  States* posed(const double* poses, std::size_t count) const {
    auto states = std::make_unique<States>();
    states->count = count;
    states->poses.reserve(count * movers_.size());
    for (std::size_t k = 0; k < count * movers_.size(); ++k) states->poses.push_back(transform(poses + 16 * k));
    return states.release();
  }

  // Whether each group of states, which ends before `ends[g]`, is free.
  void check(const States& states, const std::int64_t* ends, std::int64_t groups, const Settings& settings,
             std::uint8_t* free) {
    set_up(settings);
    std::int64_t state = 0;
    for (std::int64_t g = 0; g < groups; ++g) {
      bool hit = false;
      for (; state < ends[g] && !hit; ++state) hit = collides(states.poses.data() + state * movers_.size());
      state = ends[g];
      free[g] = !hit;
    }
  }

  // Whether each pair collides in each state: (states, pairs).
  void check_pairs(const States& states, const Settings& settings, std::uint8_t* hit) {
    set_up(settings);
    for (std::size_t state = 0; state < states.count; ++state) {
      const Transform3s* poses = states.poses.data() + state * movers_.size();
      set_boxes(poses);
      for (std::size_t k = 0; k < pairs_.size(); ++k)
        *hit++ = (!boxes_asked_ || world_boxes_meet(static_cast<int>(k))) && pair_collides(static_cast<int>(k), poses);
    }
  }

 private:
  void set_up(const Settings& settings) {
    request_.enable_contact = false;
    request_.distance_upper_bound = 0;  // a separating plane is enough
    request_.gjk_variant = static_cast<coal::GJKVariant>(settings.gjk);
    request_.gjk_initial_guess = static_cast<coal::GJKInitialGuess>(settings.guess);
    cached_ = settings.guess == coal::CachedGuess;
    boxes_asked_ = settings.boxes;
    last_ = -1;
  }

  // Of a (4, 4) matrix in rows.
  static Transform3s transform(const double* pose) {
    coal::Matrix3s rotation;
    rotation << pose[0], pose[1], pose[2], pose[4], pose[5], pose[6], pose[8], pose[9], pose[10];
    return {rotation, Vec3s(pose[3], pose[7], pose[11])};
  }

  std::pair<Vec3s, Vec3s> world_box(int body, const Transform3s& pose) const {
    const coal::AABB& box = shape_of_[body]->aabb_local;
    const Vec3s extent = pose.getRotation().cwiseAbs() * ((box.max_ - box.min_) / 2);
    return {pose.transform(box.center()), extent};
  }

  bool collides(const Transform3s* poses) {
    if (last_ >= 0 && pair_collides(last_, poses)) return true;
    if (!boxes_asked_) return collides_without_boxes(poses);
    set_boxes(poses);
    for (const int k : both_move_)
      if (k != last_ && moving_boxes_meet(mover_of_[pairs_[k].p], mover_of_[pairs_[k].r]) && found(k, poses))
        return true;
    for (std::size_t m = 0; m < movers_.size(); ++m)
      if (hits_what_stands(m, poses)) return true;
    return false;
  }

  void set_boxes(const Transform3s* poses) {
    for (std::size_t m = 0; m < movers_.size(); ++m) {
      const auto [middle, extent] = world_box(movers_[m].body, poses[m]);
      boxes_.set(m, middle, extent);
    }
  }

  bool world_boxes_meet(int k) const {
    const Pair& pair = pairs_[k];
    if (mover_of_[pair.r] >= 0) return moving_boxes_meet(mover_of_[pair.p], mover_of_[pair.r]);
    return true;  // boxes of what stands still are beside those of its partners
  }

  bool collides_without_boxes(const Transform3s* poses) {
    for (std::size_t k = 0; k < pairs_.size(); ++k)
      if (static_cast<int>(k) != last_ && found(static_cast<int>(k), poses)) return true;
    return false;
  }

  bool moving_boxes_meet(int a, int b) const {
    for (int k = 0; k < 3; ++k)
      if (std::abs(boxes_.centre[k][a] - boxes_.centre[k][b]) > boxes_.half[k][a] + boxes_.half[k][b]) return false;
    return true;
  }

  bool hits_what_stands(std::size_t m, const Transform3s* poses) {
    const Mover& mover = movers_[m];
    const double cx = boxes_.centre[0][m], cy = boxes_.centre[1][m], cz = boxes_.centre[2][m];
    const double hx = boxes_.half[0][m], hy = boxes_.half[1][m], hz = boxes_.half[2][m];
    const double *px = mover.partners.centre[0].data(), *qx = mover.partners.half[0].data();
    const double *py = mover.partners.centre[1].data(), *qy = mover.partners.half[1].data();
    const double *pz = mover.partners.centre[2].data(), *qz = mover.partners.half[2].data();
    const std::size_t n = mover.pairs.size();
    std::int64_t* near = near_.data();  // as wide as a double, so that compilers use lanes
    std::int64_t any = 0;
    for (std::size_t i = 0; i < n; ++i) {
      near[i] = (std::abs(cx - px[i]) <= hx + qx[i]) & (std::abs(cy - py[i]) <= hy + qy[i]) &
                (std::abs(cz - pz[i]) <= hz + qz[i]);
      any |= near[i];
    }
    if (!any) return false;
    for (std::size_t i = 0; i < n; ++i)
      if (near[i] && mover.pairs[i] != last_ && found(mover.pairs[i], poses)) return true;
    return false;
  }

  bool found(int k, const Transform3s* poses) {
    if (!pair_collides(k, poses)) return false;
    last_ = k;
    return true;
  }

  bool pair_collides(int k, const Transform3s* poses) {
    Pair& pair = pairs_[k];
    const Transform3s& p = poses[mover_of_[pair.p]];
    const Transform3s& r = mover_of_[pair.r] < 0 ? placed_[pair.r] : poses[mover_of_[pair.r]];
    if (boxes_asked_ > 1 && boxes_apart(shape_of_[pair.p]->aabb_local, p, shape_of_[pair.r]->aabb_local, r))
      return false;
    if (cached_) {
      request_.cached_gjk_guess = pair.guess;
      request_.cached_support_func_guess = pair.support_guess;
    }
    result_.clear();
    const bool hit = pair.collide(p, r, request_, result_) > 0;
    if (cached_) {
      pair.guess = result_.cached_gjk_guess;
      pair.support_guess = result_.cached_support_func_guess;
    }
    return hit;
  }

  static bool boxes_apart(const coal::AABB& a, const Transform3s& p, const coal::AABB& b, const Transform3s& r) {
    const coal::Matrix3s turn = p.getRotation().transpose() * r.getRotation();
    const Vec3s way = p.getRotation().transpose() * (r.transform(b.center()) - p.transform(a.center()));
    return coal::obbDisjoint(turn, way, (a.max_ - a.min_) / 2, (b.max_ - b.min_) / 2);
  }

  std::vector<std::unique_ptr<coal::CollisionGeometry>> shapes_;
  std::vector<const coal::CollisionGeometry*> shape_of_;
  std::vector<Transform3s> placed_;  // by body
  std::vector<int> mover_of_;        // by body; -1 stands still
  std::vector<Mover> movers_;
  std::vector<Pair> pairs_;
  std::vector<int> both_move_;
  Boxes boxes_;  // of the movers in the present state
  std::vector<std::int64_t> near_;
  std::size_t most_ = 0;
  int last_ = -1;
  coal::CollisionRequest request_;
  coal::CollisionResult result_;
  bool cached_ = false;
  int boxes_asked_ = 0;
};

// The face for ctypes: 0 is success, and coal_loop_error says what failed.
template <typename Step>
static int attempt(CoalLoop* loop, const Step& step) {
  try {
    step();
    return 0;
  } catch (const std::exception& problem) {
    loop->error = problem.what();
    return 1;
  }
}

extern "C" {
CoalLoop* coal_loop_new() { return new CoalLoop; }
void coal_loop_delete(CoalLoop* loop) { delete loop; }
const char* coal_loop_error(const CoalLoop* loop) { return loop->error.c_str(); }

int coal_loop_add_shape(CoalLoop* loop, int kind, const double* numbers, const double* points, int n,
                        const int* triangles, int m) {
  return attempt(loop, [&] { loop->add_shape(kind, numbers, points, n, triangles, m); });
}
int coal_loop_set(CoalLoop* loop, int bodies, const int* shape_of, const std::uint8_t* moves, const double* poses,
                  int count, const int* pairs) {
  return attempt(loop, [&] {
    loop->set_bodies(bodies, shape_of, moves, poses);
    loop->set_pairs(count, pairs);
  });
}
void* coal_loop_pose(const CoalLoop* loop, const double* poses, std::int64_t count) {
  return loop->posed(poses, static_cast<std::size_t>(count));
}
void coal_loop_unpose(void* states) { delete static_cast<States*>(states); }
int coal_loop_check(CoalLoop* loop, const void* states, const std::int64_t* ends, std::int64_t groups, int gjk,
                    int guess, int boxes, std::uint8_t* free) {
  return attempt(
      loop, [&] { loop->check(*static_cast<const States*>(states), ends, groups, Settings{gjk, guess, boxes}, free); });
}
int coal_loop_check_pairs(CoalLoop* loop, const void* states, int gjk, int guess, int boxes, std::uint8_t* hit) {
  return attempt(loop,
                 [&] { loop->check_pairs(*static_cast<const States*>(states), Settings{gjk, guess, boxes}, hit); });
}
}
