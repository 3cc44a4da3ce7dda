#include "planar.hpp"

#include <array>

namespace plannercheck {
namespace {

// What is known about the triangles: a line apart, a common point, or that the host's triangle is within the guest's.
enum class Relation { kApart, kVertex, kCrossing, kInside };

struct Finding {
  Relation relation = Relation::kInside;
  std::size_t a = 0, b = 0;  // kVertex: guest corner a. kCrossing: where corners a to b come in over line i.
  std::size_t i = 0, j = 0;  // kApart: over lines i and j, with these weights.
  LineWeights weights;
};

// The paper's state: T_P is the triangle of the guest's vertices first, middle and last of the chain that is left, T_Q
// the intersection of the half-planes of the host's edges first, middle and last of what is left. In every round either
// chain loses half. Kept up (the paper's correctness invariant, in a form that also covers a guest inside the host):
// the polygons share a point if and only if the hull of the guest's chain meets the intersection of the half-planes of
// the host's remaining edges.
class Walk {
 public:
  Walk(const PosedPolygon& guest, const PosedPolygon& host, int turn, Precision first, PlanarCounters& counters)
      : signs_(guest, host, turn, first, counters),
        counters_(counters),
        host_count_(host.shape.count),
        guest_last_(guest.shape.count - 1),
        host_last_(host.shape.count - 1) {}

  bool run() {
    corners_[0] = signs_.point(0);
    corners_[2] = signs_.point(guest_last_);
    edges_[0] = edge(0);
    edges_[2] = edge(host_last_);
    take_middle_corner();
    take_middle_edge();
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) measure(i, k);
    }
    while (true) {
      ++counters_.rounds;
      const Finding found = relation();
      if (found.relation == Relation::kInside) return true;
      if (found.relation == Relation::kApart) {
        if (guest_last_ - guest_first_ < 3 || !prune_guest(found)) return false;
      } else if (host_last_ - host_first_ < 3 || !prune_host(found)) {
        return true;
      }
    }
  }

 private:
  PlanarSigns signs_;
  PlanarCounters& counters_;
  std::size_t host_count_;
  std::size_t guest_first_ = 0, guest_last_, host_first_ = 0, host_last_;
  std::array<GuestPoint, 3> corners_;
  std::array<HostLine, 3> edges_;
  Side sides_[3][3];  // of edge i, corner k
  int sign_[3][3];

  HostLine edge(std::size_t k) const { return signs_.line(k, k + 1 == host_count_ ? 0 : k + 1); }

  void take_middle_corner() { corners_[1] = signs_.point(guest_first_ + (guest_last_ - guest_first_) / 2); }
  void take_middle_edge() { edges_[1] = edge(host_first_ + (host_last_ - host_first_) / 2); }

  void measure(std::size_t i, std::size_t k) {
    sides_[i][k] = signs_.side(edges_[i], corners_[k]);
    sign_[i][k] = signs_.sign(sides_[i][k], edges_[i], corners_[k]);
  }

  bool beyond(std::size_t i, std::size_t k) const { return sign_[i][k] < 0; }

  int mixed(std::size_t i, std::size_t j, std::size_t a, std::size_t b) const {
    return signs_.mixed(edges_[i], edges_[j], corners_[a], corners_[b]);
  }

  Finding relation() const {
    Finding found;
    for (std::size_t i = 0; i < 3; ++i) {
      if (beyond(i, 0) && beyond(i, 1) && beyond(i, 2)) {
        found.relation = Relation::kApart;
        found.i = found.j = i;
        return found;
      }
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (!beyond(0, k) && !beyond(1, k) && !beyond(2, k)) {
        found.relation = Relation::kVertex;
        found.a = k;
        return found;
      }
    }
    static constexpr std::size_t kPairs[3][2] = {{0, 1}, {1, 2}, {0, 2}};
    for (const auto& [a, b] : kPairs) {
      if (crosses(a, b, found)) return found;
    }
    // By Helly's theorem triangles apart are so over two of the lines; else T_Q is inside T_P.
    for (const auto& [i, j] : kPairs) {
      if (is_wedge_apart(i, j)) {
        found.relation = Relation::kApart;
        found.i = i;
        found.j = j;
        found.weights = weights(i, j);
        return found;
      }
    }
    return found;
  }

  // Whether the side of T_P from corner a to b, neither of which is in T_Q, meets T_Q, and over which line it comes in.
  bool crosses(std::size_t a, std::size_t b, Finding& found) const {
    std::array<std::size_t, 3> in, out;
    std::size_t in_count = 0, out_count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      if (beyond(i, a) && beyond(i, b)) return false;
      if (beyond(i, a)) in[in_count++] = i;
      if (beyond(i, b)) out[out_count++] = i;
    }
    // mixed <= 0: line i is crossed inwards no later than j outwards.
    for (std::size_t x = 0; x < in_count; ++x) {
      for (std::size_t y = 0; y < out_count; ++y) {
        if (mixed(in[x], out[y], a, b) > 0) return false;
      }
    }
    std::size_t last_in = in[0];
    for (std::size_t x = 1; x < in_count; ++x) {
      if (mixed(in[x], last_in, a, b) <= 0) last_in = in[x];
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
      for (std::size_t b = 0; b < 3; ++b) {
        if (!beyond(i, a) && !beyond(j, b) && mixed(i, j, a, b) >= 0) return false;
      }
    }
    return true;
  }

  // Weights with which the mixed side of lines i and j is negative at all corners: between the bounds that the corners
  // within one half-plane set.
  LineWeights weights(std::size_t i, std::size_t j) const {
    LineWeights found{0, 0, {}};
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
    found.first = (bound_i[0] + bound_j[0]) / 2;
    found.second = (bound_i[1] + bound_j[1]) / 2;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!surely_beyond(found, sides_[i][k], sides_[j][k])) found.exact = exact_weights(i, j);
    }
    return found;
  }

  static bool surely_beyond(const LineWeights& w, const Side& i, const Side& j) {
    if (!(w.first > 0 && w.second > 0)) return false;
    const double first = w.first * i.value, second = w.second * j.value;
    // Three roundings, of a quarter of the bound each.
    const double error = w.first * i.error + w.second * j.error + 0x1p-50 * (std::fabs(first) + std::fabs(second));
    return first + second < -error * (1 + 0x1p-48);
  }

  // The mediant of the two bounds, which is strictly between them.
  std::array<Dyadic, 2> exact_weights(std::size_t i, std::size_t j) const {
    std::array<Dyadic, 2> bound_i{Dyadic(1), Dyadic(0)}, bound_j{Dyadic(0), Dyadic(1)};
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

  // Separation invariant: the host is where the mixed side is at least 0, T_P where it is negative. What the guest has
  // of the former is beyond one side of T_P. False if there is nothing, so that the polygons are apart.
  bool prune_guest(const Finding& apart) {
    const int arc = arc_towards(apart);
    if (arc < 0) return false;
    const std::size_t middle = corners_[1].index;
    if (arc == 0) {
      guest_last_ = middle;
      move_corner(1, 2);
    } else {
      guest_first_ = middle;
      move_corner(1, 0);
    }
    take_middle_corner();
    for (std::size_t i = 0; i < 3; ++i) measure(i, 1);
    return true;
  }

  // Which arc of the guest's chain rises above T_P: 0 from the first to the middle corner, 1 from there to the last, -1
  // none. (The chain's ends are neighbours in what is left of the guest.)
  int arc_towards(const Finding& apart) const {
    const auto compare = [&](const GuestPoint& a, const GuestPoint& b) {
      return signs_.compare(apart.weights, edges_[apart.i], edges_[apart.j], a, b);
    };
    const auto rises = [&](std::size_t from, std::size_t towards) {
      return compare(signs_.point(towards), corners_[from]) > 0;
    };
    const std::size_t middle = corners_[1].index;
    const auto first_rises = [&] { return rises(0, guest_first_ + 1) ? 0 : -1; };
    const auto last_rises = [&] { return rises(2, guest_last_ - 1) ? 1 : -1; };
    const int fall = compare(corners_[0], corners_[1]), climb = compare(corners_[2], corners_[1]);
    if (fall == 0 && climb == 0) return arc_off_line();
    // Two corners level above the third: only the arc between them can rise above both.
    if (fall == 0) return climb > 0 ? last_rises() : first_rises();
    if (climb == 0) return fall > 0 ? first_rises() : rises(1, middle + 1) ? 1 : -1;
    if (fall < 0 && climb < 0) return rises(1, middle - 1) ? 0 : rises(1, middle + 1) ? 1 : -1;
    if (fall < 0) return last_rises();
    if (climb < 0) return first_rises();
    const int ends = compare(corners_[0], corners_[2]);
    return ends > 0 ? first_rises() : ends < 0 ? last_rises() : -1;
  }

  // All corners are level: the arcs to the one between the others lie on that line, whatever else there is is not.
  int arc_off_line() const {
    const PlanarPolygon& shape = signs_.guest();
    const auto x = [&](std::size_t k) { return shape.x(corners_[k].index); };
    const auto y = [&](std::size_t k) { return shape.y(corners_[k].index); };
    const bool along_x = x(0) != x(1) || x(0) != x(2);
    const auto position = [&](std::size_t k) { return along_x ? x(k) : y(k); };
    const auto is_between = [&](std::size_t k, std::size_t a, std::size_t b) {
      return (position(a) < position(k)) == (position(k) < position(b));
    };
    return is_between(1, 0, 2) ? -1 : is_between(2, 0, 1) ? 0 : 1;
  }

  void move_corner(std::size_t from, std::size_t to) {
    corners_[to] = corners_[from];
    for (std::size_t i = 0; i < 3; ++i) {
      sides_[i][to] = sides_[i][from];
      sign_[i][to] = sign_[i][from];
    }
  }

  // Intersection invariant: a point x of T_P in T_Q is given. Beyond the chord that joins two of the edges, the host's
  // edges between these two are all that matter: who reaches the host beyond the others from x passes through it. False
  // if x is beyond neither chord: then it is in the host, or sees only edges that were dropped, so they share a point.
  bool prune_host(const Finding& common) {
    const std::size_t middle = edges_[1].from;
    if (is_beyond_chord(common, host_first_ + 1, middle)) {
      host_last_ = middle;
      move_edge(1, 2);
    } else if (is_beyond_chord(common, edges_[1].to, host_last_)) {
      host_first_ = middle;
      move_edge(1, 0);
    } else {
      return false;
    }
    take_middle_edge();
    for (std::size_t k = 0; k < 3; ++k) measure(1, k);
    return true;
  }

  bool is_beyond_chord(const Finding& common, std::size_t from, std::size_t to) const {
    if (from == to) return false;
    const HostLine chord = signs_.line(from, to);
    const GuestPoint& a = corners_[common.a];
    if (common.relation == Relation::kVertex) return signs_.sign(signs_.side(chord, a), chord, a) < 0;
    return signs_.mixed(edges_[common.i], chord, a, corners_[common.b]) > 0;
  }

  void move_edge(std::size_t from, std::size_t to) {
    edges_[to] = edges_[from];
    for (std::size_t k = 0; k < 3; ++k) {
      sides_[to][k] = sides_[from][k];
      sign_[to][k] = sign_[from][k];
    }
  }
};

}  // namespace

// A polygon without area has no half-planes, so it is the guest; two of those are segments or points.
bool planar_intersect(const PosedPolygon& a, const PosedPolygon& b, Precision first, PlanarCounters& counters) {
  const int turn_b = planar_turn(b.shape, counters);
  if (turn_b != 0) return Walk(a, b, turn_b, first, counters).run();
  const int turn_a = planar_turn(a.shape, counters);
  if (turn_a != 0) return Walk(b, a, turn_a, first, counters).run();
  return flat_polygons_meet(a, b, counters);
}

}  // namespace plannercheck
