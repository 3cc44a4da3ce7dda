// The projection of the origin on the span of one to four corners, in doubles, in double-double or exactly.
//
// In: differences of vertices. Out: whether it lies strictly inside of their hull and, if so, its weights. Only
// positive weights are needed, so the work ends with the first weight that is not positive.
#pragma once

#include <array>
#include <cstddef>

#include "math/double_double.hpp"
#include "math/dyadic.hpp"

namespace plannercheck {

inline bool positive(double x) { return x > 0; }
inline bool positive(const Dyadic& x) { return x.sign() > 0; }
inline void set_to_one(double& x) { x = 1; }
inline void set_to_one(Dyadic& x) { x = 1.0; }
inline void set_to_one(DoubleDouble& x) { x = {1, 0}; }

// The rest, `weight` and `towards`, is meaningless where `run` returns false.
template <class Number, class Vector>
class SimplexProjection {
 public:
  std::array<Number, 4> weight{};  // in the order of the corners, of any sum
  Vector towards{};                // along the projection, of any length; 0, or not set, if there are four corners
  Number height{};                 // of three corners: the product of `towards` with each, up to its sign

  bool run(const std::array<const Vector*, 4>& p, std::size_t count) {
    return count == 1   ? point(*p[0])
           : count == 2 ? segment(*p[0], *p[1])
           : count == 3 ? triangle(*p[0], *p[1], *p[2])
                        : tetrahedron(*p[0], *p[1], *p[2], *p[3]);
  }

 private:
  bool point(const Vector& a) {
    set_to_one(weight[0]);
    towards = a;
    return true;
  }

  bool segment(const Vector& a, const Vector& b) {
    const Vector e = b - a;
    const Number along = -dot(a, e);
    if (!positive(along)) return false;
    const Number rest = dot(b, e);
    if (!positive(rest)) return false;
    towards = rest * a + along * b;
    weight = {rest, along};
    return true;
  }

  bool triangle(const Vector& a, const Vector& b, const Vector& c) {
    const Vector n = cross(b - a, c - a);
    if (!take(0, dot(n, cross(b, c))) || !take(1, dot(n, cross(c, a))) || !take(2, dot(n, cross(a, b)))) return false;
    height = dot(n, a);
    towards = positive(-height) ? -n : n;
    return true;
  }

  // Four volumes of one sign.
  bool tetrahedron(const Vector& a, const Vector& b, const Vector& c, const Vector& d) {
    const Vector cd = cross(c, d), ab = cross(a, b);
    weight = {dot(b, cd), -dot(a, cd), dot(d, ab), -dot(c, ab)};
    if (positive(-weight[0])) {
      for (Number& w : weight) w = -w;
    }
    return positive(weight[0]) && positive(weight[1]) && positive(weight[2]) && positive(weight[3]);
  }

  bool take(std::size_t corner, Number found) {
    weight[corner] = found;
    return positive(found);
  }
};

}  // namespace plannercheck
