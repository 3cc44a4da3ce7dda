#include "narrow_phase/pair_frame.hpp"

#include <algorithm>

#include "bodies/box_edges.hpp"

namespace plannercheck {
namespace {

// Error bounds. u = 2^-53, |.| is Euclidean, columns of M are at most 1 + 2e-6 long, r_P = reach of A, w = t_P
// − t_R, c = B's centre, δ = ‖M_RᵀM_R − 1‖. Sums are rounded up, which covers second-order terms.
//
// (a) Relative pose. fl(M_Rᵀ M_P) errs by at most 3u an entry (Cauchy-Schwarz on unit columns), 9u in the Frobenius
//     norm: 9u r_P. fl(M p) errs by 3u |p| an entry: 5.2u r_P. Adding the shift errs by 2u (r_P + |shift|). In the
//     shift, w errs by u|w|, M_Rᵀw by 5.2u|w|, and subtracting c by 2u (|w| + |c|). M_R⁻¹ − M_Rᵀ = (1 − M_RᵀM_R) M_R⁻¹,
//     so the transpose in place of the inverse errs by (1 + 1e-5) δ (r_P + |w|). In all: at most 20u (r_P + |w| + |c|)
//     + 1.01 δ (r_P + |w|).
// (b) Separation by q, |q| <= r_Q (1 + 1e-9). A's direction fl(Mᵀq) errs by 5.2u |q|, which moves the least
//     product by at most 10.4u |q| r_P. A scan may miss that product by 14u |q| r_P (kScanError, |.|_1 <= √3 |.|).
//     Evaluating q·x errs by 5.2u |q| |x|. The supremum of q·x over R is at most 1 + 20u r_Q r_R: polar points err by
//     kPolarError, mixing 8 of them by 16u. Of these, 8u are in the sum of the weights, which are multiplied by the
//     inverse of their rounded sum, and 8u in the products and sums. In all: r_Q times (30u (r_P + |shift|) + 20u r_R)
//     besides (a).
// (c) Containment of x. Mixing 8 vertices errs by 16u (r_P + |shift|), a scan by 14u r_Q |x|, evaluating by 5.2u r_Q
//     |x|, polar points by 4u r_Q |x|, with |x| <= r_P + |shift|. In all: r_Q times 40u (r_P + |shift|) besides (a).
//     Counted more sharply, as tests/error_bounds/pair_frame does, (b) is 33.6u and (c) 37.2u, (a) included.
//
// (d) Dents. A holds P' = {c_P + y : q·y <= 1 − s for its own facets q}, each with its own s (hull_dents.hpp),
//     wherever it is posed, as poses are affine; likewise R holds R'. So the bodies share a point x' that is in both.
//     Let x = c_P + A y be a mixture of A vertices with the relative pose A. Then x' = c_P + t A y is in P' if t
//     q·y <= 1 − s for all q. y is found as mᵀ (x − c_P), where m errs by (a), x and c_P by what (c) allows, and mᵀA is
//     off 1 by kAxisDefect at most: by less than kAxisDefect r + 4 (error of a coordinate) in all, if |y| <= r. x' is a
//     mixture of x and c_P, rounded by 4u more, for which (c) has room.
//
// |shift| <= |w| + |c| up to the rounding above, so one bound serves both. Each game of the coupled walk mixes 16
// points (32u) and moves the result towards another mixture (3u), which may be mixed again: kMixtureError a game.
constexpr double kPairError = 64 * 0x1p-53;     // (a) without δ, plus the larger of (b) and (c): at most 60u
constexpr double kMixtureError = 40 * 0x1p-53;  // of each game whose mixture is mixed again
constexpr double kAxisLength = 1 + 4e-6;        // of a column of M_Rᵀ M_P: both bodies are off rigid by at most 3.6e-6
// M_Rᵀ M_P is within 1.5 kAxisDefect of a rotation, so the cross product of two columns is within 3.1 times that of the
// third column.
constexpr double kEdgeSkew = 5 * kAxisDefect;
constexpr double kDefectRounding = 16 * 0x1p-53;  // of computing δ itself: six dot products of unit columns

}  // namespace

PairFrame::PairFrame(const PosedPolytope& body_a, const PosedPolytope& body_b, bool dents)
    : body_a_(body_a.body), body_b_(body_b.body) {
  const auto& r = body_b.pose.m;
  const auto& p = body_a.pose.m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      m_[3 * i + j] = (r[i] * p[j] + r[i + 4] * p[j + 4]) + r[i + 8] * p[j + 8];
    }
  }
  const Vec3 w = body_a.pose.translation() - body_b.pose.translation();
  const Vec3 centre = body_b.body->centre;
  shift_ = body_b.pose.rotate_back(w) - centre;
  defect_ = rigidity_defect(body_b.pose) + kDefectRounding;
  const double reach = body_a.body->origin_radius + norm_1(w) + norm_1(centre) + body_b.body->radius;
  pose_error_ = reach * pose_error_growth();
  error_ = body_b.body->polar_radius * pose_error_;
  inflation_radius_ = (body_a.body->inflation_radius + body_b.body->inflation_radius) * (1 + 1.01 * defect_);
  mixture_error_ = body_b.body->polar_radius * reach * kMixtureError;
  has_dents_ = dents && have_dents(body_a, body_b);
}

Vec3 PairFrame::past_dents_of_a(Vec3 x) const {
  const Vec3 centre = centre_a(), way = x - centre;
  if (body_a().dents.facets.empty()) return centre + (1 - body_a().dents.others) * way;
  const Vec3 y = -direction_a(way);
  const double error = body_a().polar_radius * (kAxisDefect * body_a().radius + 4 * pose_error_);
  return centre + scale_past_dents(body_a(), y, error) * way;
}

bool PairFrame::is_past_dents_of_b(Vec3 x, double value, long mixtures) const {
  const HullDents& dents = body_b().dents;
  if (!(value < (1 - dents.others) - error(mixtures))) return false;
  return std::all_of(dents.facets.begin(), dents.facets.end(), [&](const DentedFacet& dented) {
    return dot(polar_point(dented.facet), x) < dented.height - error(mixtures);
  });
}

double PairFrame::pose_error_growth() const { return kPairError + 1.01 * defect_; }

Vec3 PairFrame::direction_a(Vec3 q) const {
  return {-(m_[0] * q.x + m_[3] * q.y + m_[6] * q.z), -(m_[1] * q.x + m_[4] * q.y + m_[7] * q.z),
          -(m_[2] * q.x + m_[5] * q.y + m_[8] * q.z)};
}

Vec3 PairFrame::box_point_a() const {
  const Vec3 centre = direction_a(shift_), low = body_a().low, high = body_a().high;
  const auto clamped = [](double c, double least, double most) { return smaller(larger(c, least), most); };
  return map({clamped(centre.x, low.x, high.x), clamped(centre.y, low.y, high.y), clamped(centre.z, low.z, high.z)});
}

// The axes are B's own and the columns of M_Rᵀ M_P, which are A's up to the poses' defects. An axis
// separates the boxes if their projections on it, each given by its centre and half its length, are apart.
bool PairFrame::boxes_apart() const {
  const Polytope &g = body_a(), &h = body_b();
  const Vec3 half_b = 0.5 * (h.high - h.low), half_a = 0.5 * (g.high - g.low);
  const Vec3 d = map(0.5 * (g.low + g.high)) - (0.5 * (h.low + h.high) - h.centre);
  const double room = (inflation_radius_ + 4 * pose_error_) * kAxisLength + kDenormalError;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t row = 3 * i;
    const double half =
        std::fabs(m_[row]) * half_a.x + std::fabs(m_[row + 1]) * half_a.y + std::fabs(m_[row + 2]) * half_a.z;
    if (std::fabs(d[i]) > half + half_b[i] + room) return true;
  }
  const double skew = kAxisDefect * (half_a.x + half_a.y + half_a.z);
  for (std::size_t j = 0; j < 3; ++j) {
    const double half = std::fabs(m_[j]) * half_b.x + std::fabs(m_[j + 3]) * half_b.y + std::fabs(m_[j + 6]) * half_b.z;
    const double along = m_[j] * d.x + m_[j + 3] * d.y + m_[j + 6] * d.z;
    if (std::fabs(along) > half + half_a[j] + skew + room) return true;
  }
  return boxes_apart_at_edges(d, half_a, half_b, room);
}

// The products of B's axes e_i with A's m_j are the numbers of the pose.
bool PairFrame::boxes_apart_at_edges(Vec3 d, Vec3 half_a, Vec3 half_b, double room) const {
  const double limit = kEdgeSkew * (half_a.x + half_a.y + half_a.z) + room;
  const auto numbers = [](Vec3 v) { return std::array<double, 3>{v.x, v.y, v.z}; };
  return any_edges(m_, numbers(d), numbers(half_b), numbers(half_a),
                   [&](double distance, double reach) { return distance > reach + limit; });
}

}  // namespace plannercheck
