// One pair of posed bodies, A in B's frame, the certificates and their proven error bounds. A has vertices, B its
// polar.
//
// The polar describes B's hull R = {x : q·x <= 1 for all polar points q}, in B's frame relative to its centre. A's hull
// P has the vertices M p + t under the relative pose. In this frame a game decides: v = min over x in P of max over q
// in conv(polar) of q·x. If v > 1, the plane q·x = 1 separates the bodies; if v <= 1, they share the point x (Theorem
// "Polarity of polyhedra"; both polars are implicit in the game). Inflated bodies share a point if the distance of
// their hulls is at most the sum of both inflation radii, in m of the world.
#pragma once

#include <array>

#include "bodies/polytope.hpp"
#include "math/vec.hpp"
#include "narrow_phase/support.hpp"

namespace plannercheck {

struct PosedPolytope {
  const Polytope* body;
  Pose pose;
};

// Whether both bodies equal their hulls, but for dents of known depth.
inline bool equal_their_hulls(const PosedPolytope& a, const PosedPolytope& b) {
  return a.body->dents.are_known() && b.body->dents.are_known();
}
// Whether both bodies equal their hulls but for dents, and one has dents.
inline bool have_dents(const PosedPolytope& a, const PosedPolytope& b) {
  return larger(a.body->dents.deepest, b.body->dents.deepest) > 0 && equal_their_hulls(a, b);
}
// Poses stretch lengths by less than this.
inline constexpr double kDentStretch = 1 + 1e-5;
// How far points of the bodies' hulls may be from the bodies, in m.
inline double reach_of_dents(const Polytope& a, const Polytope& b) {
  return (a.dents.deepest * a.radius + b.dents.deepest * b.radius) * kDentStretch;
}

enum class Answer { kSeparated, kShared, kUndecided };

// How the answer was found.
enum class Stage { kCachedPlane, kBoxFace, kCentreAxis, kSolver, kNearest, kDoubleDouble, kExact };
inline constexpr std::size_t kStages = 7;

// In B's frame relative to its centre: a plane q·x = 1 beyond which P lies, or a point x of both bodies.
struct Certificate {
  Answer answer = Answer::kUndecided;
  Stage stage = Stage::kSolver;
  Vec3 q, x;
  long mixtures = 0;  // number of games from which q and x were mixed; see PairFrame::separates
};

inline Certificate separated_by(Vec3 q, Stage stage) {
  Certificate out;
  out.answer = Answer::kSeparated;
  out.stage = stage;
  out.q = q;
  return out;
}

struct PairCounters {
  QueryCounters queries;
  long queries_a = 0, queries_b = 0, games = 0, rounds = 0;
};

inline PairCounters& operator+=(PairCounters& sum, const PairCounters& more) {
  sum.queries.blocks += more.queries.blocks, sum.queries.exact += more.queries.exact;
  sum.queries_a += more.queries_a, sum.queries_b += more.queries_b;
  sum.games += more.games, sum.rounds += more.rounds;
  return sum;
}

// By how much the columns of M_Rᵀ M_P may be off orthonormal: the product of two, or of one with itself. Both bodies
// are off rigid by 3.6e-6.
inline constexpr double kAxisDefect = 8e-6;

class PairFrame {
 public:
  // Keeps no poses. `dents`: whether those of bodies count.
  PairFrame(const PosedPolytope& body_a, const PosedPolytope& body_b, bool dents = false);

  const Polytope& body_a() const { return *body_a_; }
  const Polytope& body_b() const { return *body_b_; }

  Vec3 point_a(Vec3 in_a) const { return map(in_a); }
  Vec3 vertex_a(std::int32_t v) const { return map(body_a().inner.points[static_cast<std::size_t>(v)]); }
  Vec3 centre_a() const { return map(body_a().centre); }
  Vec3 polar_point(std::int32_t k) const { return body_b().polar.points[static_cast<std::size_t>(k)]; }

  // Map A points into this frame: the rows of M_Rᵀ M_P, and the shift that is added.
  const std::array<double, 9>& rotation() const { return m_; }
  Vec3 shift() const { return shift_; }
  // An upper bound of ‖M_RᵀM_R − 1‖.
  double defect() const { return defect_; }

  // The error of a coordinate of A in this frame, with room for a few operations on it; and its growth for each m that
  // A extends further from its frame's origin.
  double pose_error() const { return pose_error_; }
  double pose_error_growth() const;

  // The point of A's box nearest to B's centre, up to rounding: a likely shared point of bodies that
  // overlap. Rounding never takes it out of the box.
  Vec3 box_point_a() const;

  // The direction, in A's frame, whose extreme vertex has the least q·x.
  Vec3 direction_a(Vec3 q) const;

  // Whether a plane along two edges of the bodies' boxes separates both boxes, whatever the rounding: a face plane of
  // one box, or one along an edge of each.
  bool boxes_apart() const;

  // Whether q proves the bodies apart. `value`: the least q·x over A's vertices, by `extreme`. Over R, q·x is
  // at most 1 up to rounding, since q is a mixture of at most 8 polar points, or of 16 points in each of `mixtures`
  // games. The distance along q is (value − 1) / |q|.
  bool separates(Vec3 q, double value, long mixtures = 0) const {
    return value > 1 + error(mixtures) + (inflation_radius_ > 0 ? inflation_radius_ * norm(q) * (1 + 8 * 0x1p-53) : 0);
  }
  // Whether R contains x, such a mixture of A vertices. `value`: the largest q·x over polar points, by `extreme`.
  bool contains(double value, long mixtures = 0) const { return value < 1 - error(mixtures); }

  // Whether a point of both hulls decides only if it is past the dents of both bodies.
  bool has_dents() const { return has_dents_; }
  // The point of A's hull nearest to x, towards A's centre, that is past A's dents.
  Vec3 past_dents_of_a(Vec3 x) const;
  // Whether such a point is past B's dents.
  bool is_past_dents_of_b(Vec3 x, double value, long mixtures) const;

 private:
  const Polytope *body_a_, *body_b_;
  std::array<double, 9> m_;
  Vec3 shift_;  // M_Rᵀ (t_P − t_R) − centre
  double defect_;
  double pose_error_;  // of a coordinate in this frame, with room for a few operations on it
  double error_, mixture_error_;
  bool has_dents_;
  double inflation_radius_;  // of both bodies, rounded up and stretched by how far the pose may be off rigid

  bool boxes_apart_at_edges(Vec3 between, Vec3 half_a, Vec3 half_b, double room) const;

  double error(long mixtures) const { return error_ + static_cast<double>(mixtures) * mixture_error_; }

  Vec3 map(Vec3 v) const {
    return {(m_[0] * v.x + m_[1] * v.y) + (m_[2] * v.z + shift_.x),
            (m_[3] * v.x + m_[4] * v.y) + (m_[5] * v.z + shift_.y),
            (m_[6] * v.x + m_[7] * v.y) + (m_[8] * v.z + shift_.z)};
  }
};

}  // namespace plannercheck
