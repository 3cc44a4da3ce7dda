#include "bodies/triangle_order.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "bodies/triangle_tree.hpp"
#include "math/spatial_partition.hpp"

namespace plannercheck {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// Ranges up to so many triangles are cut at the best of all places, larger ones at the best of some (measured).
constexpr std::size_t kMostSwept = 128;
constexpr std::size_t kCutBins = 32;

double half_surface(const Box& box) {
  const Vec3 edges = box.high - box.low;
  return edges.x * edges.y + edges.y * edges.z + edges.z * edges.x;
}

// Where a range is cut.
struct Cut {
  double cost = kUnbounded;
  int axis = 0;
  std::size_t place = 0;  // triangles before it
};

class Ordering {
 public:
  explicit Ordering(const std::vector<Box>& bounds) : bounds_(bounds), order_(indices_below(bounds.size())) {}

  TriangleOrder run(std::size_t levels) {
    sort({order_.data(), order_.data() + order_.size()}, levels);
    return {std::move(order_), std::move(children_)};
  }

 private:
  struct Part {
    IndexRange range;
    double surface;
  };

  const std::vector<Box>& bounds_;
  std::vector<std::int32_t> order_;
  std::vector<std::size_t> children_;
  std::array<double, kMostSwept> before_{};

  static std::size_t size_of(IndexRange range) { return static_cast<std::size_t>(range.size()); }
  const Box& box(const std::int32_t* of) const { return bounds_[at(*of)]; }

  // Twice the middle of a triangle's box.
  double middle(std::int32_t triangle, int axis) const {
    const Box& box = bounds_[at(triangle)];
    return box.low[axis] + box.high[axis];
  }

  auto order_along(int axis) const {
    return [this, axis](std::int32_t a, std::int32_t b) {
      const double on_a = middle(a, axis), on_b = middle(b, axis);
      return on_a != on_b ? on_a < on_b : a < b;
    };
  }

  // Triangles that each child of an even node has; the last one may have fewer.
  static std::size_t even_share(std::size_t count) {
    std::size_t share = 1;
    while (share * kTreeWidth < count) share *= kTreeWidth;
    return share;
  }

  // Triangles that a tree of so many levels holds.
  static std::size_t most_in(std::size_t levels) {
    std::size_t most = 1;
    while (levels-- > 0) most *= kTreeWidth;
    return most;
  }

  // The range is of at most most_in(levels) triangles, and so are its parts of the levels below: even shares are powers
  // of the width, of which the least that is enough is taken.
  void sort(IndexRange range, std::size_t levels) {
    if (size_of(range) <= kTreeWidth) return;
    std::vector<Part> parts = cut(range, kTreeWidth);
    const auto is_deep = [&](const Part& part) { return size_of(part.range) > most_in(levels - 1); };
    if (std::any_of(parts.begin(), parts.end(), is_deep)) parts = cut(range, even_share(size_of(range)));
    children_.push_back(parts.size());
    for (const Part& part : parts) children_.push_back(size_of(part.range));
    for (const Part& part : parts) sort(part.range, levels - 1);
  }

  // Into as many parts as a node has children, all but the last one of whole steps.
  std::vector<Part> cut(IndexRange range, std::size_t step) {
    std::vector<Part> parts{part(range)};
    while (parts.size() < kTreeWidth) {
      const auto rank = [&](const Part& p) { return size_of(p.range) > step ? p.surface : -1; };
      const auto widest =
          std::max_element(parts.begin(), parts.end(), [&](const Part& a, const Part& b) { return rank(a) < rank(b); });
      if (rank(*widest) < 0) break;
      const IndexRange all = widest->range;
      std::int32_t* const middle = cut_in_two(all, step);
      *widest = part({all.first, middle});
      parts.insert(widest + 1, part({middle, all.last}));
    }
    return parts;
  }

  Part part(IndexRange range) const {
    Box around;
    for (const std::int32_t* i = range.first; i != range.last; ++i) around.add(box(i));
    return {range, half_surface(around)};
  }

  std::int32_t* cut_in_two(IndexRange range, std::size_t step) {
    const std::size_t count = size_of(range), leaves = (count + step - 1) / step;
    Cut best{kUnbounded, 0, leaves / 2 * step};
    for (int axis = 0; axis < 3; ++axis) {
      const Cut found = count <= kMostSwept ? best_of_all(range, axis, step) : best_of_some(range, axis, step);
      if (found.cost < best.cost) best = found;
    }
    std::int32_t* const place = range.first + best.place;
    std::nth_element(range.first, place, range.last, order_along(best.axis));
    return place;
  }

  static double cost(double surface, std::size_t count, std::size_t step) {
    return surface * static_cast<double>((count + step - 1) / step);
  }

  Cut best_of_all(IndexRange range, int axis, std::size_t step) {
    std::sort(range.first, range.last, order_along(axis));
    const std::size_t count = size_of(range);
    Box around;
    for (std::size_t k = 0; k < count; ++k) {
      before_[k] = half_surface(around);
      around.add(box(range.first + k));
    }
    Cut best;
    around = {};
    for (std::size_t k = count - 1; k > 0; --k) {
      around.add(box(range.first + k));
      if (k % step != 0) continue;
      const double both = cost(before_[k], k, step) + cost(half_surface(around), count - k, step);
      if (both < best.cost) best = {both, axis, k};
    }
    return best;
  }

  // The best of the cuts between bins of equal width, each moved to the next whole step.
  Cut best_of_some(IndexRange range, int axis, std::size_t step) const {
    double low = kUnbounded, high = -kUnbounded;
    for (const std::int32_t* i = range.first; i != range.last; ++i)
      low = smaller(low, middle(*i, axis)), high = larger(high, middle(*i, axis));
    const double bins = static_cast<double>(kCutBins) / (high - low);
    if (!(bins < kUnbounded)) return {};  // all middles are one, nearly
    std::array<Box, kCutBins> around;
    std::array<std::size_t, kCutBins> inside{};
    for (const std::int32_t* i = range.first; i != range.last; ++i) {
      const auto bin = std::min(static_cast<std::size_t>((middle(*i, axis) - low) * bins), kCutBins - 1);
      around[bin].add(box(i)), ++inside[bin];
    }
    std::array<double, kCutBins> after;  // the surface of each bin and those that follow
    Box sum;
    for (std::size_t k = kCutBins; k-- > 0;) sum.add(around[k]), after[k] = half_surface(sum);
    const std::size_t count = size_of(range), last = (count - 1) / step * step;
    Cut best;
    sum = {};
    std::size_t before = 0;
    for (std::size_t k = 0; k + 1 < kCutBins; ++k) {
      sum.add(around[k]), before += inside[k];
      if (before == 0 || before == count) continue;
      const double both = cost(half_surface(sum), before, step) + cost(after[k + 1], count - before, step);
      if (both < best.cost) best = {both, axis, std::clamp((before + step / 2) / step * step, step, last)};
    }
    return best;
  }
};

}  // namespace

TriangleOrder order_triangles(const std::vector<Box>& bounds, std::size_t levels) {
  return Ordering(bounds).run(levels);
}

}  // namespace plannercheck
