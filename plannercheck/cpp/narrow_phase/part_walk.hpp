// Which parts of a set may be near a posed body: down the set's tree, by the boxes of both.
//
// In: a body and a set at their poses, and a margin in m of the world. Out: the leaves, and in them the parts, whose
// boxes may be within the margin of the body's box. Six axes are tried, the set's and the body's, for eight boxes at
// once, in floats with room for all rounding; then the last directions along which a part was beyond the body: before a
// surface of millions of points, one of these directions often separates all boxes that are near the body's box.
// Infinities and NaN count as near.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "bodies/part_set.hpp"
#include "math/simd.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// Children of a node that may be near, and the gaps of all boxes along the axes, in the tree's units; negative where
// boxes are near.
struct NearParts {
  unsigned bits;
  Floats gap;

  // A child with the least gap.
  unsigned deepest() const {
    return static_cast<unsigned>(__builtin_ctz(plannercheck::bits(gap == Floats{} - largest(-gap)) | 1U << kChildren)) %
           kChildren;
  }
};

// Maps between the frames of a body and of a set. Their poses are rigid up to 3.6e-6 and the transpose serves as the
// inverse, so `error` has room for both.
class RigidTurn {
 public:
  RigidTurn(const Pose& body, const Pose& set);

  Vec3 to_set(Vec3 p) const {
    return {((m_[0] * p.x + m_[1] * p.y) + m_[2] * p.z) + in_set_.x,
            ((m_[3] * p.x + m_[4] * p.y) + m_[5] * p.z) + in_set_.y,
            ((m_[6] * p.x + m_[7] * p.y) + m_[8] * p.z) + in_set_.z};
  }
  Vec3 to_body(Vec3 p) const {
    return {((m_[0] * p.x + m_[3] * p.y) + m_[6] * p.z) + in_body_.x,
            ((m_[1] * p.x + m_[4] * p.y) + m_[7] * p.z) + in_body_.y,
            ((m_[2] * p.x + m_[5] * p.y) + m_[8] * p.z) + in_body_.z};
  }
  double entry(std::size_t in_set, std::size_t in_body) const { return m_[3 * in_set + in_body]; }
  Vec3 in_body() const { return in_body_; }  // the set's origin
  // The error of a mapped point whose |.|_1 is at most `reach` before.
  double error(double reach) const;

 private:
  std::array<double, 9> m_;  // from the body to the set
  Vec3 in_set_, in_body_;    // each frame's origin in the other one
  double distance_;
};

class PartWalk {
 public:
  // `inner`: a ball inside the body, if its own inner shapes are not to be asked for.
  PartWalk(const PosedPolytope& body, const PosedPolytope& set, double margin, const InnerBall* inner = nullptr);

  // Calls visit(leaf, bits of parts that may be near), the deepest leaves first, until it returns true; whether it did.
  template <class Visit>
  bool any_leaf(Visit visit) {
    std::array<Waiting, kMostWaiting> waiting;  // not initialised
    std::size_t count = 0;
    Waiting next{static_cast<std::int32_t>(set_.levels().size()), 0};
    for (;;) {
      if (next.level == 0) {
        const unsigned bits = near_in_leaf(next.index);
        if (bits != 0 && visit(next.index, bits)) return true;
      } else {
        if (counters_ != nullptr) keep_direction();
        const NearParts found = near_children(set_.levels()[at(next.level - 1)][next.index]);
        const std::int32_t below = next.level - 1;
        const std::size_t first = next.index * kChildren;
        if (found.bits != 0) {
          unsigned left = found.bits;
          const unsigned deepest = found.deepest();
          left &= ~(1U << deepest);
          for (; left != 0; left &= left - 1) {
            waiting[count++] = {below, first + static_cast<std::size_t>(__builtin_ctz(left))};
          }
          next = {below, first + deepest};
          continue;
        }
      }
      if (count == 0) return false;
      next = waiting[--count];
    }
  }

  // From the next node on, leaves out boxes beyond the body along this direction of its frame, in place of the oldest
  // such direction.
  void leave_out_beyond(Vec3 way, PairCounters& counters) { way_ = way, counters_ = &counters; }

  NearParts near(const PartNode& node) const;
  // The same children; gaps are set only if a child may be near.
  NearParts near_children(const PartNode& node) const;
  // The parts of a leaf, one bit each.
  unsigned near_in_leaf(std::size_t leaf) const;
  // Balls of a leaf that surely share a point with a ball inside the body.
  unsigned surely_shared(std::size_t leaf) const;
  // Whether a box, given by its corners' sides in the set's frame, surely shares a point with a ball inside the body.
  bool surely_shares(const PartShape& part) const;

 private:
  static constexpr std::size_t kMostWaiting = 12 * kChildren;
  static constexpr std::size_t kMostBeyond = 4;  // two and six take as long (measured)

  // A child of a node; level 0: a leaf.
  struct Waiting {
    std::int32_t level;
    std::size_t index;
  };

  // A direction of the body's frame, in the tree's axes and units: a box's middle is `along` · centre + `shift` from
  // the middle of the body's extent, and it is apart if that is beyond `size` · half + `extent`.
  struct Along {
    std::array<float, 3> along, size;
    float shift, extent;
  };

  const PartSet& set_;
  const Polytope* body_ = nullptr;
  const InnerBall* inner_ = nullptr;
  RigidTurn turn_;
  double margin_, room_;                // in m of the body's frame: of what is near, and of what errs in doubles
  std::array<float, 3> centre_, half_;  // of the body's box in the tree's units
  Vec3 box_centre_, box_half_;
  std::array<Along, 3> axes_;              // of the body's box
  std::array<Along, kMostBeyond> beyond_;  // of these the body's extent ends at its middle, and begins nowhere
  std::size_t beyond_count_ = 0, oldest_ = 0;
  Vec3 way_;                          // the next direction
  PairCounters* counters_ = nullptr;  // if there is one

  void frame_tree();
  void keep_direction();
  Along along(Vec3 to, double way, double half) const;
  Floats own_gaps(const PartNode& node) const;
  NearParts with_directions(const PartNode& node, Floats own) const;
  std::span<const InnerBall> inner_balls() const;
};

}  // namespace plannercheck
