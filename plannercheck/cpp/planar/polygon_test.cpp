#include "planar/polygon_test.hpp"

#include <array>
#include <bit>

#include "planar/cyclic_places.hpp"
#include "planar/polygon_start.hpp"

namespace plannercheck {
namespace {

// What is known of the triangles: a line separates them, they share a point, or B's is inside A's.
enum class Relation { kApart, kVertex, kCrossing, kInside };

// Corners and lines are counted 0 to 2, as they are stored.
struct Finding {
  Relation relation = Relation::kInside;
  std::size_t a = 0, b = 0;  // kVertex: A corner a. kCrossing: the side from corner a to b enters over line i.
  std::size_t i = 0, j = 0;  // kApart: by lines i and j, with the walk's weights.
};

// The paper's state: T_P is the triangle of three vertices of A, T_Q the intersection of the half-planes of
// three edges of B; the chains that are left lie between them. The first round of either side keeps one of three
// chains, later rounds keep one of two halves. Correctness invariant (the paper's, in a form that also covers A
// inside B): the polygons share a point if and only if the hull of A's remaining vertices meets the
// intersection of the half-planes of B's remaining edges.
class Walk {
 public:
  Walk(const PosedPolygon& body_a, const PosedPolygon& body_b, const PlanarStart& start, int turn, Precision first,
       PlanarCounters& counters)
      : signs_(body_a, body_b, turn, first, counters),
        counters_(counters),
        vertices_(body_a.shape.count, start.body_a),
        lines_(body_b.shape.count, start.body_b) {
    for (std::size_t k = 0; k < 3; ++k) {
      corners_[k] = signs_.point(vertices_.at[k]);
      edges_[k] = edge(lines_.at[k]);
    }
    for (std::size_t k = 0; k < 3; ++k) measure_corner(k);
  }

  bool run() {
    while (true) {
      ++counters_.rounds;
      const Finding found = relation();
      if (found.relation == Relation::kInside) return true;
      if (found.relation == Relation::kApart ? !prune_a(found) : !prune_b(found)) {
        return found.relation != Relation::kApart;
      }
    }
  }

 private:
  PlanarSigns signs_;
  PlanarCounters& counters_;
  CyclicPlaces vertices_, lines_;
  std::array<PointOfA, 3> corners_;
  std::array<LineOfB, 3> edges_;
  Side sides_[3][3];  // of edge i, corner k
  LineWeights weights_;
  std::array<unsigned, 3> beyond_{};  // of corner k: bit i, whether it is beyond edge i

  LineOfB edge(std::size_t k) const { return signs_.line(k, lines_.after(k)); }

  void measure_corner(std::size_t k) {
    unsigned bits = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      sides_[i][k] = signs_.side(edges_[i], corners_[k]);
      bits |= signs_.is_beyond(sides_[i][k], edges_[i], corners_[k]) << i;
    }
    beyond_[k] = bits;
  }
  void measure_edge(std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k) {
      sides_[i][k] = signs_.side(edges_[i], corners_[k]);
      beyond_[k] = (beyond_[k] & ~(1U << i)) | signs_.is_beyond(sides_[i][k], edges_[i], corners_[k]) << i;
    }
  }

  bool beyond(std::size_t i, std::size_t k) const { return (beyond_[k] >> i & 1U) != 0; }

  int mixed(std::size_t i, std::size_t j, std::size_t a, std::size_t b) const {
    return signs_.mixed(edges_[i], edges_[j], corners_[a], corners_[b], sides_[i][a], sides_[i][b], sides_[j][a],
                        sides_[j][b]);
  }

  Finding relation() {
    Finding found;
    const unsigned all = beyond_[0] & beyond_[1] & beyond_[2];
    if (all != 0) {
      found.relation = Relation::kApart;
      found.i = found.j = static_cast<std::size_t>(std::countr_zero(all));
      set_single_weight();
      return found;
    }
    const unsigned within = unsigned(beyond_[0] == 0) | unsigned(beyond_[1] == 0) << 1 | unsigned(beyond_[2] == 0) << 2;
    if (within != 0) {
      found.relation = Relation::kVertex;
      found.a = static_cast<std::size_t>(std::countr_zero(within));
      return found;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (crosses(k, kNext[k], found)) return found;
    }
    // By Helly's theorem, triangles that are apart are separated by two of the lines; otherwise T_Q is inside T_P.
    for (std::size_t i = 0; i < 3; ++i) {
      if (is_wedge_apart(i, kNext[i])) {
        found.relation = Relation::kApart;
        found.i = i;
        found.j = kNext[i];
        set_weights(found.i, found.j);
        return found;
      }
    }
    return found;
  }

  // Whether the side of T_P from corner a to b, both outside T_Q, meets T_Q, and over which line it enters.
  bool crosses(std::size_t a, std::size_t b, Finding& found) const {
    if ((beyond_[a] & beyond_[b]) != 0) return false;
    // mixed <= 0: line i is entered no later than j is left, or than j is entered.
    std::size_t last_in = 3;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!beyond(i, a)) continue;
      for (std::size_t j = 0; j < 3; ++j) {
        if (beyond(j, b) && mixed(i, j, a, b) > 0) return false;
      }
      if (last_in == 3 || mixed(i, last_in, a, b) <= 0) last_in = i;
    }
    found.relation = Relation::kCrossing;
    found.a = a;
    found.b = b;
    found.i = last_in;
    return true;
  }

  // Whether T_P is apart from the wedge of two half-planes.
  bool is_wedge_apart(std::size_t i, std::size_t j) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!beyond(i, k) && !beyond(j, k)) return false;
    }
    for (std::size_t a = 0; a < 3; ++a) {
      if (beyond(i, a)) continue;
      for (std::size_t b = 0; b < 3; ++b) {
        if (!beyond(j, b) && mixed(i, j, a, b) >= 0) return false;
      }
    }
    return true;
  }

  // Weights for which the mixed side of lines i and j is negative at all corners: between the bounds of those within
  // one half-plane.
  void set_weights(std::size_t i, std::size_t j) {
    double steepest_i = -1, steepest_j = -1;
    std::array<double, 2> bound_i{}, bound_j{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double u = sides_[i][k].value, v = sides_[j][k].value;
      const double length = std::fabs(u) + std::fabs(v);
      if (!beyond(i, k) && u / length > steepest_i) {
        steepest_i = u / length;
        bound_i = {-v / length, u / length};
      }
      if (!beyond(j, k) && v / length > steepest_j) {
        steepest_j = v / length;
        bound_j = {v / length, -u / length};
      }
    }
    weights_.first = (bound_i[0] + bound_j[0]) / 2;
    weights_.second = (bound_i[1] + bound_j[1]) / 2;
    weights_.exact.reset();
    for (std::size_t k = 0; k < 3 && !weights_.exact; ++k) {
      if (!surely_beyond(weights_, sides_[i][k], sides_[j][k])) weights_.exact = exact_weights(i, j);
    }
  }

  void set_single_weight() {
    weights_.first = 1;
    weights_.second = 0;
    weights_.exact.reset();
  }

  static bool surely_beyond(const LineWeights& w, const Side& i, const Side& j) {
    if (!(w.first > 0 && w.second > 0)) return false;
    const double first = w.first * i.value, second = w.second * j.value;
    // Three roundings, of a quarter of the bound each.
    const double error = w.first * i.error + w.second * j.error + 0x1p-50 * (std::fabs(first) + std::fabs(second));
    return first + second < -error * planar_detail::kSlack;
  }

  // The mediant of the two bounds, which is strictly between them.
  std::array<Dyadic, 2> exact_weights(std::size_t i, std::size_t j) const {
    std::array<Dyadic, 2> bound_i, bound_j;
    bool has_i = false, has_j = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Dyadic u = signs_.exact_side(edges_[i], corners_[k]), v = signs_.exact_side(edges_[j], corners_[k]);
      if (!beyond(i, k) && (!has_i || (u * bound_i[0] + v * bound_i[1]).sign() > 0)) {
        bound_i = {-v, u};
        has_i = true;
      }
      if (!beyond(j, k) && (!has_j || (u * bound_j[0] + v * bound_j[1]).sign() > 0)) {
        bound_j = {v, -u};
        has_j = true;
      }
    }
    return {bound_i[0] + bound_j[0], bound_i[1] + bound_j[1]};
  }

  // Separation invariant: the mixed side is at least 0 on B and negative on T_P. The part of A where it
  // is at least 0 lies beyond one side of T_P. False if there is no such part: the polygons are apart.
  bool prune_a(const Finding& apart) {
    const Slope slope = signs_.slope(weights_, edges_[apart.i], edges_[apart.j]);
    const std::size_t arc = arc_towards(slope);
    if (arc == kNone || is_pocket_apart(apart, slope, arc)) return false;
    const std::size_t added = vertices_.keep(arc);
    corners_[added] = signs_.point(vertices_.at[added]);
    measure_corner(added);
    return true;
  }

  // Whether an arc that rises above T_P surely stays where the mixed side is negative: it lies within the triangle of
  // its chord and the lines of its first and last edge. This ends most queries of separated polygons after a few
  // rounds; the walk is complete without it.
  bool is_pocket_apart(const Finding& apart, const Slope& slope, std::size_t arc) const {
    const std::size_t from = corner(arc), to = corner(kNext[arc]), stored = vertices_.order[arc];
    const std::size_t ahead = vertices_.after(from), behind = vertices_.before(to);
    const Side level = signs_.value(weights_, sides_[apart.i][stored], sides_[apart.j][stored]);
    const Side climb = signs_.climb(slope, ahead, from);
    ++counters_.vertices;
    const double highest = (climb.value + climb.error) * signs_.meeting(from, ahead, to, behind);
    return highest >= 0 && highest * planar_detail::kSlack < -(level.value + level.error);
  }

  static constexpr std::size_t kNone = 3;

  // Index of the k-th corner.
  std::size_t corner(std::size_t k) const { return vertices_.at[vertices_.order[k]]; }

  // The arc of A, from which corner to the next, that rises above T_P.
  std::size_t arc_towards(const Slope& slope) const {
    std::array<int, 3> step;  // change of the mixed side from each corner to the next
    for (std::size_t k = 0; k < 3; ++k) step[k] = signs_.compare(slope, corner(kNext[k]), corner(k));
    if (step[0] == 0 && step[1] == 0 && step[2] == 0) return arc_off_line();
    for (std::size_t k = 0; k < 3; ++k) {
      // If two corners are level above the third, only the arc between them can rise above both.
      if (step[k] == 0 && step[kPrevious[k]] > 0) return rises_after(slope, k) ? k : kNone;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (step[k] >= 0 || step[kPrevious[k]] <= 0) continue;
      return rises_after(slope, k) ? k : rises_before(slope, k) ? kPrevious[k] : kNone;
    }
    return kNone;
  }

  bool rises_after(const Slope& slope, std::size_t k) const {
    return vertices_.steps(k) > 1 && rises(slope, corner(k), vertices_.after(corner(k)));
  }
  bool rises_before(const Slope& slope, std::size_t k) const {
    return vertices_.steps(kPrevious[k]) > 1 && rises(slope, corner(k), vertices_.before(corner(k)));
  }
  bool rises(const Slope& slope, std::size_t from, std::size_t towards) const {
    ++counters_.vertices;
    return signs_.compare(slope, towards, from) > 0;
  }

  // If all corners are level, the arcs to the middle one lie on that line, so all other vertices are on the third arc.
  std::size_t arc_off_line() const {
    const PlanarPolygon& shape = signs_.body_a();
    const auto x = [&](std::size_t k) { return shape.x(corner(k)); };
    const auto y = [&](std::size_t k) { return shape.y(corner(k)); };
    const bool along_x = x(0) != x(1) || x(0) != x(2);
    const auto position = [&](std::size_t k) { return along_x ? x(k) : y(k); };
    for (std::size_t k = 0; k < 3; ++k) {
      const double here = position(k), before = position(kPrevious[k]), after = position(kNext[k]);
      const bool is_between = (before <= here && here <= after) || (after <= here && here <= before);
      if (is_between) return vertices_.steps(kNext[k]) > 1 ? kNext[k] : kNone;
    }
    return kNone;
  }

  // Intersection invariant: x is a point of T_P in T_Q. If x is beyond the chord that joins two of the edges, only the
  // B's edges between these two matter, as every segment from x to the rest of B crosses the chord. False if
  // x is beyond no chord: it is in B, or sees only edges that were dropped, so the polygons share a point.
  bool prune_b(const Finding& common) {
    for (std::size_t k = 0; k < 3; ++k) {
      const LineOfB &from = edges_[lines_.order[k]], &to = edges_[lines_.order[kNext[k]]];
      if (lines_.steps(k) < 2 || !is_beyond_chord(common, from.to, to.from)) continue;
      const std::size_t added = lines_.keep(k);
      edges_[added] = edge(lines_.at[added]);
      measure_edge(added);
      return true;
    }
    return false;
  }

  bool is_beyond_chord(const Finding& common, std::size_t from, std::size_t to) const {
    const LineOfB chord = signs_.line(from, to);
    const PointOfA& a = corners_[common.a];
    const Side side_a = signs_.side(chord, a);
    if (common.relation == Relation::kVertex) return signs_.is_beyond(side_a, chord, a) != 0;
    const PointOfA& b = corners_[common.b];
    return signs_.mixed(edges_[common.i], chord, a, b, sides_[common.i][common.a], sides_[common.i][common.b], side_a,
                        signs_.side(chord, b)) > 0;
  }
};

}  // namespace

// A polygon without area has no half-planes, so it has to be A. Two such are segments or points.
bool planar_intersect(const PosedPolygon& a, const PosedPolygon& b, Precision first, PlanarCounters& counters) {
  const int turn_b = planar_turn(b.shape, counters);
  if (turn_b != 0) return Walk(a, b, PlanarStart(a, b, first, counters), turn_b, first, counters).run();
  const int turn_a = planar_turn(a.shape, counters);
  if (turn_a != 0) return Walk(b, a, PlanarStart(b, a, first, counters), turn_a, first, counters).run();
  return flat_polygons_meet(a, b, counters);
}

}  // namespace plannercheck
