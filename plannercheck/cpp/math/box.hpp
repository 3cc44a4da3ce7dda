// Boxes along the axes of a frame.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

// It holds nothing before something is added.
struct Box {
  static constexpr double kFarthest = std::numeric_limits<double>::infinity();
  Vec3 low{kFarthest, kFarthest, kFarthest}, high{-kFarthest, -kFarthest, -kFarthest};

  void add(const Box& other) { low = smaller(low, other.low), high = larger(high, other.high); }
  void add(const Vec3& p) { low = smaller(low, p), high = larger(high, p); }

  // By so much on all sides.
  Box grown(double by) const { return {low - Vec3{by, by, by}, high + Vec3{by, by, by}}; }
  // Largest |x|, |y|, |z|.
  Vec3 reach() const { return larger(absolute(low), absolute(high)); }

  std::vector<Vec3> corners() const {
    std::vector<Vec3> out;
    for (const double x : {low.x, high.x}) {
      for (const double y : {low.y, high.y}) out.insert(out.end(), {{x, y, low.z}, {x, y, high.z}});
    }
    return out;
  }
};

inline Box box_around(std::span<const Vec3> points) {
  Box box;
  for (const Vec3& p : points) box.add(p);
  return box;
}

}  // namespace plannercheck
