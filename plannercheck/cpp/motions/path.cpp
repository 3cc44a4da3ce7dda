#include "motions/path.hpp"

#include <algorithm>
#include <array>

#include "math/simd.hpp"

namespace plannercheck {
namespace {

using Quaternion = std::array<double, 4>;  // x, y, z, w

Quaternion normalised(const double* q) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}

Quaternion about_z(double cosine, double sine) {
  const double half = std::atan2(sine, cosine) / 2;
  return {0, 0, std::sin(half), std::cos(half)};
}

Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

Quaternion conjugate(const Quaternion& q) { return {-q[0], -q[1], -q[2], q[3]}; }

Vec3 rotated(const Quaternion& q, Vec3 v) {
  const Vec3 axis{q[0], q[1], q[2]}, c = 2.0 * cross(axis, v);
  return v + q[3] * c + cross(axis, c);
}

// The rotation vector of a unit quaternion, the short way.
Vec3 log_of(Quaternion q) {
  if (q[3] < 0) q = {-q[0], -q[1], -q[2], -q[3]};
  const Vec3 v{q[0], q[1], q[2]};
  const double sine = norm(v);
  return sine > 0 ? (2 * std::atan2(sine, q[3]) / sine) * v : Vec3{};
}

Quaternion exp_of(Vec3 turn, double t) {
  const double angle = norm(turn), half = t * angle / 2;
  const Vec3 v = angle > 0 ? (std::sin(half) / angle) * turn : Vec3{};
  return {v.x, v.y, v.z, std::cos(half)};
}

// Below this angle the closed forms below cancel; their series, to the terms written, err by less than 1e-15.
constexpr double kSmallAngle = 0.25;

double one_minus_cos(double a) {  // (1 − cos a) / a²
  const double half = std::sin(a / 2);
  return a > 0 ? 2 * half * half / (a * a) : 0.5;
}

double arc_minus_sin(double a) {  // (a − sin a) / a³
  const double s = a * a;
  if (a >= kSmallAngle) return (a - std::sin(a)) / (s * a);
  return 1.0 / 6 - s * (1.0 / 120 - s * (1.0 / 5040 - s * (1.0 / 362880 - s / 39916800)));
}

double inverse_term(double a) {  // (1 − a/2 · cot(a/2)) / a²
  const double s = a * a;
  if (a >= kSmallAngle) return (1 - a / 2 * std::cos(a / 2) / std::sin(a / 2)) / s;
  return 1.0 / 12 + s * (1.0 / 720 + s * (1.0 / 30240 + s * (1.0 / 1209600 + s / 47900160)));
}

// The displacement of the origin under the twist (turn, slide) at parameter t.
Vec3 carried(Vec3 turn, double angle, Vec3 slide, double t) {
  const Vec3 c = cross(turn, slide);
  return t * (slide + (one_minus_cos(t * angle) * t) * c + (arc_minus_sin(t * angle) * t * t) * cross(turn, c));
}

// The slide for which the twist with this turn carries the origin to `shift` at t = 1.
Vec3 slide_to(Vec3 shift, Vec3 turn, double angle) {
  const Vec3 c = cross(turn, shift);
  return shift - 0.5 * c + inverse_term(angle) * cross(turn, c);
}

// Position and orientation of a planar or floating joint.
struct Placed {
  Vec3 position;
  Quaternion turn;
};

Placed placed(PartKind kind, const double* q) {
  if (kind == PartKind::kPlanar) return {{q[0], q[1], 0}, about_z(q[2], q[3])};
  return {{q[0], q[1], q[2]}, normalised(q + 3)};
}

double off_unit_length(const double* q, std::size_t n) {
  double square = 0;
  for (std::size_t i = 0; i < n; ++i) square += q[i] * q[i];
  return std::fabs(std::sqrt(square) - 1);
}

double excess_length(const PathPart& part, const double* q) {
  const std::size_t skipped = part.kind == PartKind::kPlanar ? 2 : part.kind == PartKind::kFree ? 3 : 0;
  return off_unit_length(q + skipped, part.width() - skipped);
}

constexpr double kHalfUnit = 0x1p-53;

}  // namespace

Path::Path(std::size_t width, std::vector<PathPart> parts)
    : q0_(width), q1_(width), sizes_(width), on_curve_(width), parts_(std::move(parts)), twists_(parts_.size()) {
  std::vector<bool> covered(width, false);
  for (const PathPart& part : parts_) {
    for (std::size_t k = 0; k < part.width(); ++k) covered[at_column(part.column) + k] = true;
  }
  for (std::size_t c = 0; c < width; ++c) {
    if (!covered[c]) linear_.push_back(static_cast<std::int32_t>(c));
  }
}

void Path::set(const Segment& motion, bool thin_tubes) {
  const std::size_t width = q0_.size();
  std::copy_n(motion.start, width, q0_.begin());
  std::copy_n(motion.end, width, q1_.begin());
  degree_ = motion.degree;
  off_unit_ = 0;
  if (is_curve()) {
    control_.assign(motion.start, motion.start + (degree_ + 1) * width);
    look_at(0, 1);
  }
  double largest = 0;
  for (std::size_t c = 0; c < width; ++c) {
    const double low = is_curve() ? on_curve_[c].low : q0_[c], high = is_curve() ? on_curve_[c].high : q1_[c];
    sizes_[c] = larger(std::fabs(low), std::fabs(high));
    largest = larger(largest, sizes_[c]);
  }
  largest_ = largest;
  tube_.clear();
  off_curve_ = 0;
  if (motion.tube != nullptr) set_tube(motion.tube, thin_tubes);
  for (std::size_t part = 0; part < parts_.size(); ++part) set_part(part);
}

// A tube as thin as rounding is covered as rounding is, at no cost.
void Path::set_tube(const double* tube, bool thin_tubes) {
  constexpr double kThin = 0x1p-40;
  const std::size_t width = q0_.size();
  room_ = tube[width];
  const double widest = *std::max_element(tube, tube + width);
  if (widest <= (thin_tubes ? kThin : 0) && room_ == 0) {
    off_curve_ = widest;
  } else {
    tube_.assign(tube, tube + width);
  }
  for (std::size_t c = 0; c < width; ++c) sizes_[c] += tube[c];
}

// Cutting errs by three roundings a level, and by two more where the place is rounded. Differences err by as many of
// the control points that are cut out, and second differences by two more of first ones.
void Path::look_at(double from, double to) {
  const std::size_t width = q0_.size(), n = degree_;
  const auto degree = static_cast<double>(n);
  const double length = to - from, rate = degree / length, change = rate * (degree - 1) / length;
  double levels = 0;
  if (length < 1) {
    cut_ = control_;
    cut_up_to(to);
    cut_from(from / to);
    levels = 8 * degree;
  }
  const double* const b = length < 1 ? cut_.data() : control_.data();
  for (std::size_t c = 0; c < width; ++c) on_curve_[c] = {b[c], b[c], 0, 0};
  for (std::size_t k = 1; k <= n; ++k) {
    for (std::size_t c = 0; c < width; ++c) {
      CurveBound& on = on_curve_[c];
      const double here = b[k * width + c], before = b[(k - 1) * width + c];
      on.low = smaller(on.low, here), on.high = larger(on.high, here);
      on.rate = larger(on.rate, std::fabs(here - before));
      if (k > 1) on.change = larger(on.change, std::fabs((here - before) - (before - b[(k - 2) * width + c])));
    }
  }
  for (std::size_t c = 0; c < width; ++c) {
    CurveBound& on = on_curve_[c];
    const double cut = length < 1 ? levels * kHalfUnit * sizes_[c] : 0, first = on.rate + 2 * cut;
    on = {on.low - cut, on.high + cut, rate * first, change * (on.change + 4 * cut + 4 * kHalfUnit * first)};
  }
}

// The first points of each level are those up to a place, the last ones those from there on.
void Path::cut_up_to(double place) {
  const std::size_t width = q0_.size();
  for (std::size_t level = 1; level <= degree_ && place < 1; ++level) {
    for (std::size_t k = cut_.size(); k-- > level * width;) cut_[k] = (1 - place) * cut_[k - width] + place * cut_[k];
  }
}

void Path::cut_from(double place) {
  const std::size_t width = q0_.size();
  for (std::size_t level = 1; level <= degree_ && place > 0; ++level) {
    for (std::size_t k = 0; k < cut_.size() - level * width; ++k) {
      cut_[k] = (1 - place) * cut_[k] + place * cut_[k + width];
    }
  }
}

void Path::set_part(std::size_t part) {
  const PathPart& p = parts_[part];
  const double *a = &q0_[at_column(p.column)], *b = &q1_[at_column(p.column)];
  off_unit_ = larger(off_unit_, larger(excess_length(p, a), excess_length(p, b)));
  Twist twist;
  if (p.kind == PartKind::kCircle) {
    twist.turn.z = std::atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
  } else if (p.kind == PartKind::kBall) {
    twist.turn = log_of(product(conjugate(normalised(a)), normalised(b)));
  } else {
    const Placed from = placed(p.kind, a), to = placed(p.kind, b);
    twist.turn = log_of(product(conjugate(from.turn), to.turn));
    twist.slide = slide_to(rotated(conjugate(from.turn), to.position - from.position), twist.turn, norm(twist.turn));
  }
  twist.angle = norm(twist.turn);
  twists_[part] = twist;
}

Rate Path::bound(std::int32_t column) const {
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    if (parts_[part].column != column) continue;
    const Twist& twist = twists_[part];
    const double slide = norm(twist.slide);
    double extent = 0;
    if (parts_[part].kind >= PartKind::kPlanar) {
      extent = norm(placed(parts_[part].kind, &q0_[at_column(column)]).position) + slide;
    }
    return {twist.angle, slide, extent};
  }
  return {};
}

void Path::at(const double* t, std::size_t n, std::size_t stride, double* q) const {
  if (is_curve()) {
    curve_at(t, n, stride, q);
  } else {
    for (const std::int32_t column : linear_) {
      const double a = q0_[at_column(column)], b = q1_[at_column(column)];
      double* out = q + at_column(column) * stride;
      for (std::size_t i = 0; i < n; ++i) out[i] = (1 - t[i]) * a + t[i] * b;
    }
  }
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    for (std::size_t i = 0; i < n; ++i) part_at(part, t[i], q + at_column(parts_[part].column) * stride + i, stride);
  }
}

// Σ w[k] b[k] with the weights of Bernstein, (n over k) t^k (1 − t)^(n − k), each of which errs by less than 2n + 2
// roundings of itself. As they add up to 1, a number errs by less than 3n + 4 of the largest control point. Both ends
// are exact.
void Path::curve_at(const double* t, std::size_t n, std::size_t stride, double* q) const {
  constexpr auto kAtOnce = static_cast<std::size_t>(kLanes);
  const std::size_t width = q0_.size();
  std::array<Lanes, kMostDegree + 1> weights;
  for (std::size_t first = 0; first < n; first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, n - first);
    std::array<double, kAtOnce> some{};
    std::copy_n(t + first, count, some.begin());
    const Lanes s = load_lanes(some.data()), rest = 1 - s;
    Lanes power = broadcast(1);
    double choices = 1;
    for (std::size_t k = 0; k <= degree_; ++k, power = power * s) {
      weights[k] = choices * power;
      choices = choices * static_cast<double>(degree_ - k) / static_cast<double>(k + 1);  // exact
    }
    power = broadcast(1);
    for (std::size_t k = degree_ + 1; k-- > 0; power = power * rest) weights[k] = weights[k] * power;
    for (const std::int32_t column : linear_) {
      const double* const b = &control_[at_column(column)];
      Lanes sum{};
      for (std::size_t k = 0; k <= degree_; ++k) sum = sum + weights[k] * b[k * width];
      store_lanes(some.data(), sum);
      std::copy_n(some.begin(), count, q + at_column(column) * stride + first);
    }
  }
}

void Path::part_at(std::size_t part, double t, double* q, std::size_t stride) const {
  const PathPart& p = parts_[part];
  const Twist& twist = twists_[part];
  const double* a = &q0_[at_column(p.column)];
  const auto put = [&](std::size_t first, std::initializer_list<double> values) {
    for (const double value : values) q[first++ * stride] = value;
  };
  if (p.kind == PartKind::kCircle) {
    const double angle = std::atan2(a[1], a[0]) + t * twist.turn.z;
    return put(0, {std::cos(angle), std::sin(angle)});
  }
  if (p.kind == PartKind::kBall) {
    const Quaternion r = product(normalised(a), exp_of(twist.turn, t));
    return put(0, {r[0], r[1], r[2], r[3]});
  }
  const Placed from = placed(p.kind, a);
  const Vec3 x = from.position + rotated(from.turn, carried(twist.turn, twist.angle, twist.slide, t));
  const Quaternion r = product(from.turn, exp_of(twist.turn, t));
  if (p.kind == PartKind::kPlanar) return put(0, {x.x, x.y, r[3] * r[3] - r[2] * r[2], 2 * r[3] * r[2]});
  put(0, {x.x, x.y, x.z, r[0], r[1], r[2], r[3]});
}

}  // namespace plannercheck
