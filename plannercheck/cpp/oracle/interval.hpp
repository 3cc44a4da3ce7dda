// Intervals of doubles, as a filter before whole numbers.
//
// In: doubles. Out: two doubles between which the exact result lies. Every operation rounds upwards, so the lower end
// is kept negated; results that are doubles stay single points, and a zero is then certain. Needs `RoundedUpwards`
// around all of it, and sources compiled with -frounding-math.
#pragma once

#include <algorithm>
#include <cfenv>

namespace plannercheck::oracle {

// Results stay far from overflow up to degree 7 in numbers of this size, m.
inline constexpr double kLargestInIntervals = 1e40;

class RoundedUpwards {
 public:
  RoundedUpwards() : before_(std::fegetround()) { std::fesetround(FE_UPWARD); }
  ~RoundedUpwards() { std::fesetround(before_); }
  RoundedUpwards(const RoundedUpwards&) = delete;
  RoundedUpwards& operator=(const RoundedUpwards&) = delete;

 private:
  int before_;
};

struct Interval {
  double negated_low = 0, high = 0;

  Interval() = default;
  explicit Interval(double value) : negated_low(-value), high(value) {}
  Interval(double minus_low, double up) : negated_low(minus_low), high(up) {}

  double low() const { return -negated_low; }
};

inline Interval operator+(const Interval& a, const Interval& b) {
  return {a.negated_low + b.negated_low, a.high + b.high};
}
inline Interval operator-(const Interval& a, const Interval& b) {
  return {a.negated_low + b.high, a.high + b.negated_low};
}
inline Interval operator-(const Interval& a) { return {a.high, a.negated_low}; }
inline Interval operator*(const Interval& a, const Interval& b) {
  const double a_low = a.low(), b_low = b.low(), negated_high = -a.high;
  return {std::max({a.negated_low * b_low, a.negated_low * b.high, negated_high * b_low, negated_high * b.high}),
          std::max({a_low * b_low, a_low * b.high, a.high * b_low, a.high * b.high})};
}

struct IntervalVector {
  Interval x, y, z;
};

inline IntervalVector operator-(const IntervalVector& a, const IntervalVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Interval dot(const IntervalVector& a, const IntervalVector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline IntervalVector cross(const IntervalVector& a, const IntervalVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace plannercheck::oracle
