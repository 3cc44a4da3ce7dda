#include "narrow_phase/given_poses.hpp"

#include <cstring>
#include <limits>

#include "math/double4.hpp"
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

// A side of a batch: its poses are checked as they are read, a single one only once.
class CheckedPoses {
 public:
  CheckedPoses(const GivenPoses& given, double tolerance)
      : given_(given), tolerance_(tolerance), only_{given.body, {}} {
    if (given_.step == 0) only_ = read(0);
  }

  bool all_rigid() const { return all_rigid_; }
  PosedPolytope at(std::size_t i) { return given_.step == 0 ? only_ : read(i); }

 private:
  GivenPoses given_;
  double tolerance_;
  PosedPolytope only_;
  bool all_rigid_ = true;

  // The identity in place of what is not surely rigid, which the tests do not expect.
  PosedPolytope read(std::size_t i) {
    const double* const matrix = given_.matrices + i * given_.step;
    PosedPolytope out{given_.body, {}};
    std::memcpy(out.pose.m.data(), matrix, sizeof out.pose.m);
    if (!is_surely_rigid(matrix, tolerance_)) [[unlikely]] {
      all_rigid_ = false;
      out.pose = Pose{};
    }
    return out;
  }
};

class GivenBatch final : public PairBatch {
 public:
  GivenBatch(CheckedPoses& guest, CheckedPoses& host, bool* shared) : guest_(guest), host_(host), shared_(shared) {}

  PosedPolytope guest(std::size_t i) const override { return guest_.at(i); }
  PosedPolytope host(std::size_t i) const override { return host_.at(i); }
  void take(std::size_t i, const PairVerdict& verdict) override { shared_[i] = verdict.shared; }
  void take_far(std::size_t i, const CentreAxis&) override { shared_[i] = false; }

 private:
  CheckedPoses &guest_, &host_;
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
  const bool a_hosts = choose_host(*a.body, *b.body) == 0;
  CheckedPoses guest(a_hosts ? b : a, tolerance), host(a_hosts ? a : b, tolerance);
  GivenBatch batch(guest, host, shared);
  PairCounters counters;
  test_pairs(*(a_hosts ? b : a).body, *(a_hosts ? a : b).body, n, options, batch, counters);
  return guest.all_rigid() && host.all_rigid();
}

}  // namespace plannercheck
