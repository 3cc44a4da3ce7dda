#include "narrow_phase/given_poses.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "math/double4.hpp"
#include "math/interruption.hpp"
#include "narrow_phase/centre_axis.hpp"
#include "narrow_phase/pair_batch.hpp"

namespace plannercheck {
namespace {

// A computed entry of MᵀM − 1 is off by less than 2^-50 if the rotation's entries are below 2, here and wherever else
// it is computed. So are norms of all nine, by less than 2^-48; this is 256 times as much.
constexpr double kRigidDoubt = 0x1p-40;
// A rotation's third row equals the cross product of the others; that of a reflection is its opposite, and differs by
// 2/√3 or more in some entry.
constexpr double kHandedness = 0.5;

// Any number that is not infinite.
constexpr double kFinite = std::numeric_limits<double>::infinity();

bool holds_everywhere(Double4Mask mask) { return double4_bits(mask) == 0b1111U; }

Double4 next_axis(Double4 v) { return shuffled<1, 2, 0, 3>(v, v); }

// Four poses, entry by entry. As `is_surely_rigid`, and by the same bounds.
class FourPoses {
 public:
  // Loads the poses i to i + 3.
  FourPoses(const GivenPoses& given, std::size_t i) {
    const double* const from = given.matrices + i * given.step;
    const std::array<const double*, 4> pose{from, from + given.step, from + 2 * given.step, from + 3 * given.step};
    for (std::size_t row = 0; row < 3; ++row) {
      const Double4 a = load_double4(pose[0] + 4 * row), b = load_double4(pose[1] + 4 * row);
      const Double4 c = load_double4(pose[2] + 4 * row), d = load_double4(pose[3] + 4 * row);
      const Double4 even = shuffled<0, 4, 2, 6>(a, b), odd = shuffled<1, 5, 3, 7>(a, b);
      const Double4 even_2 = shuffled<0, 4, 2, 6>(c, d), odd_2 = shuffled<1, 5, 3, 7>(c, d);
      m_[4 * row] = shuffled<0, 1, 4, 5>(even, even_2), m_[4 * row + 1] = shuffled<0, 1, 4, 5>(odd, odd_2);
      m_[4 * row + 2] = shuffled<2, 3, 6, 7>(even, even_2), m_[4 * row + 3] = shuffled<2, 3, 6, 7>(odd, odd_2);
    }
    for (const double* const matrix : pose) are_affine_ &= load_double4(matrix + 12) == Double4{0, 0, 0, 1};
  }

  bool all_rigid(double tolerance) const {
    const double most = tolerance - kRigidDoubt;
    const Double4 off = square(axes(0, 0) - 1) + square(axes(1, 1) - 1) + square(axes(2, 2) - 1) +
                        2 * (square(axes(0, 1)) + square(axes(0, 2)) + square(axes(1, 2)));
    Double4Mask are = off < Double4{} + (most > 0 ? most * most : 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      are &= absolute_double4(m_[i] * m_[j + 4] - m_[j] * m_[i + 4] - m_[k + 8]) < Double4{} + kHandedness;
    }
    return holds_everywhere(are & (translation() < Double4{} + kFinite) & are_affine_);
  }

  // By the operations of `Pose::apply` and `norm_1`.
  Double4 apply(Vec3 v, std::size_t row) const {
    const Double4* const m = &m_[4 * row];
    return (m[0] * v.x + m[1] * v.y + m[2] * v.z) + m[3];
  }
  Double4 translation() const { return absolute_double4(m_[3]) + absolute_double4(m_[7]) + absolute_double4(m_[11]); }

 private:
  std::array<Double4, 12> m_;
  Double4Mask are_affine_ = Double4Mask{} - 1;

  static Double4 square(Double4 a) { return a * a; }
  // An entry of MᵀM.
  Double4 axes(std::size_t i, std::size_t j) const {
    return m_[i] * m_[j] + m_[i + 4] * m_[j + 4] + m_[i + 8] * m_[j + 8];
  }
};

// Tells far pairs apart four at a time, by the operations of CentreAxis.
class FarPairs {
 public:
  FarPairs(const Polytope& body_a, const Polytope& body_b)
      : centre_a_(body_a.centre),
        centre_b_(body_b.centre),
        origin_radii_(body_a.origin_radius + body_b.origin_radius),
        radii_((body_a.radius + body_b.radius) + (body_a.inflation_radius + body_b.inflation_radius)) {}

  // Bit k: whether pair k is far.
  unsigned bits(const FourPoses& body_a, const FourPoses& body_b) const {
    const Double4 x = between(body_a, body_b, 0), y = between(body_a, body_b, 1), z = between(body_a, body_b, 2);
    const Double4 rounding = CentreAxis::rounding(origin_radii_, body_a.translation(), body_b.translation());
    const Double4 room = CentreAxis::room_of_balls(radii_, rounding);
    return double4_bits(x * x + y * y + z * z > room * room);
  }

 private:
  Vec3 centre_a_, centre_b_;
  double origin_radii_, radii_;

  Double4 between(const FourPoses& body_a, const FourPoses& body_b, std::size_t row) const {
    return body_a.apply(centre_a_, row) - body_b.apply(centre_b_, row);
  }
};

// So many pairs are looked at before those that are not far are tested: their poses stay in the cache until then.
constexpr std::size_t kLookedAt = 1024;

// The pairs of a batch that need a test.
class GivenBatch final : public PairBatch {
 public:
  GivenBatch(const GivenPoses& body_a, const GivenPoses& body_b, bool* shared)
      : body_a_(body_a), body_b_(body_b), shared_(shared) {}

  std::size_t count() const { return count_; }
  void add(std::size_t pair) { pairs_[count_++] = pair; }
  void clear() { count_ = 0; }

  PosedPolytope body_a(std::size_t i) const override { return posed(body_a_, pairs_[i]); }
  PosedPolytope body_b(std::size_t i) const override { return posed(body_b_, pairs_[i]); }
  void take(std::size_t i, const PairVerdict& verdict) override { shared_[pairs_[i]] = verdict.shared; }
  void take_far(std::size_t i, const CentreAxis&) override { shared_[pairs_[i]] = false; }

 private:
  const GivenPoses &body_a_, &body_b_;
  bool* shared_;
  std::array<std::size_t, kLookedAt> pairs_;
  std::size_t count_ = 0;

  static PosedPolytope posed(const GivenPoses& given, std::size_t pair) {
    PosedPolytope out{given.body, {}};
    std::memcpy(out.pose.m.data(), given.matrices + pair * given.step, sizeof out.pose.m);
    return out;
  }
};

// Checks the poses of a batch, and answers for far pairs.
class Lookout {
 public:
  Lookout(const GivenPoses& body_a, const GivenPoses& body_b, double tolerance, const PairOptions& options,
          bool* shared)
      : body_a_(body_a),
        body_b_(body_b),
        tolerance_(tolerance),
        tells_far_(options.centre_axis && options.solver != Solver::kExact),
        far_(*body_a.body, *body_b.body),
        shared_(shared) {}

  // Hands the pairs from `start` on that are not far to the batch; false if a pose is not surely rigid.
  bool look(std::size_t start, std::size_t past, GivenBatch& batch) const {
    std::size_t i = start;
    for (; i + 4 <= past; i += 4) {
      const FourPoses body_a(body_a_, i), body_b(body_b_, i);
      if (!body_a.all_rigid(tolerance_) || !body_b.all_rigid(tolerance_)) [[unlikely]]
        return false;
      const unsigned far = tells_far_ ? far_.bits(body_a, body_b) : 0;
      std::memset(shared_ + i, 0, 4 * sizeof *shared_);
      for (unsigned close = ~far & 0b1111U; close != 0; close &= close - 1)
        batch.add(i + static_cast<std::size_t>(__builtin_ctz(close)));
    }
    for (; i < past; ++i) {
      if (!is_surely_rigid(body_a_.matrices + i * body_a_.step, tolerance_) ||
          !is_surely_rigid(body_b_.matrices + i * body_b_.step, tolerance_))
        return false;
      batch.add(i);
    }
    return true;
  }

 private:
  const GivenPoses &body_a_, &body_b_;
  double tolerance_;
  bool tells_far_;
  FarPairs far_;
  bool* shared_;
};

}  // namespace

// By rows in lanes; the translation is in the fourth.
bool is_surely_rigid(const double* m, double tolerance) {
  const Double4 x = load_double4(m), y = load_double4(m + 4), z = load_double4(m + 8);
  const Double4 first = m[0] * x + m[4] * y + m[8] * z - Double4{1, 0, 0, 0};
  const Double4 second = m[1] * x + m[5] * y + m[9] * z - Double4{0, 1, 0, 0};
  const Double4 third = m[2] * x + m[6] * y + m[10] * z - Double4{0, 0, 1, 0};
  // The three columns of MᵀM − 1 may each have a third of the square. Next to them is Mᵀt.
  const double most = tolerance - kRigidDoubt, part = most > 0 ? most * most / 3 : 0;
  const Double4Mask is_rigid = first * first + second * second + third * third < Double4{part, part, part, kFinite};
  const Double4 turned = next_axis(x * next_axis(y) - y * next_axis(x));
  const Double4Mask is_rotation =
      absolute_double4(turned - z) < Double4{kHandedness, kHandedness, kHandedness, kFinite};
  const Double4Mask is_affine = load_double4(m + 12) == Double4{0, 0, 0, 1};
  return holds_everywhere(is_rigid & is_rotation & is_affine);
}

bool test_given_poses(const GivenPoses& a, const GivenPoses& b, std::size_t n, double tolerance,
                      const PairOptions& options, bool* shared) {
  const bool first_is_b = choose_b(*a.body, *b.body) == 0;
  const GivenPoses &body_a = first_is_b ? b : a, &body_b = first_is_b ? a : b;
  const Lookout lookout(body_a, body_b, tolerance, options, shared);
  GivenBatch batch(body_a, body_b, shared);
  PairCounters counters;
  for (std::size_t start = 0; start < n; start += kLookedAt) {
    poll_interruption();
    batch.clear();
    if (!lookout.look(start, std::min(start + kLookedAt, n), batch)) return false;
    test_pairs(*body_a.body, *body_b.body, batch.count(), options, batch, counters);
  }
  return true;
}

}  // namespace plannercheck
