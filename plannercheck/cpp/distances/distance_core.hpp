// The distances of pairs of bodies for sets of configurations: of all that are nearer than a limit, or of the nearest.
//
// In: bodies on links, pairs, a limit; then configurations, or posed links. Out: a row for each pair that is asked for,
// with its points, normal and gradient. Idea: bodies that are inflated by half of the limit meet where a pair is near,
// so the filters of verdicts leave these pairs, and each of them is measured. Immutable: each thread brings a
// workspace. A row depends on nothing but its configuration, and the earlier row that is given for it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bodies/lazy_value.hpp"
#include "broad_phase/sampled_poses.hpp"
#include "checking/checker.hpp"
#include "distances/nearest_spread.hpp"
#include "distances/point_rates.hpp"

namespace plannercheck {

struct PoseColumns;

struct DistanceRow {
  std::int64_t state = 0;
  std::int32_t pair = -1;
  double distance = 0, lower = 0;  // m; negative where the bodies overlap
  Vec3 on_a, on_b, normal;         // in the world; the normal from b to a
  double spread = 0;               // see nearest_spread.hpp, m; infinite where nothing is proved
  bool unique = false;             // whether the spread is that of one pair of points, up to rounding
  VertexPairs corners;             // of two hulls, where the descent of another configuration may begin
};

struct DistanceTable {
  std::vector<DistanceRow> rows;
  std::vector<double> gradients;  // the tangent's width for each row
};

// Parts of a table as one: its rows in the order of the states, and of each the nearest first.
DistanceTable in_order(const std::vector<DistanceTable>& parts, std::size_t tangent);

// The bodies without the part of each inflation radius that is padding, m.
std::vector<GeometryObject> without_padding(std::vector<GeometryObject> bodies, std::span<const double> paddings);

// Rows of a table of configurations near those that are asked about, by state: `bounds` has one number more than there
// are states, `corners` a row of kCornerNumbers: the count, the vertices of A, those of B.
inline constexpr std::size_t kCornerNumbers = 9;
struct EarlierRows {
  std::span<const std::int32_t> bounds;
  const std::int32_t *pairs = nullptr, *corners = nullptr;
};

// Configurations (n, width of the kinematics), or posed links: n times as many matrices as there are links, row-major
// 4x4. The first one is number `first` of all.
struct GivenStates {
  const Kinematics* kinematics;  // null: links
  const double* numbers;
  std::size_t first, count;
  EarlierRows earlier = {};
};

// Two convex parts of a pair, or two hulls, that are nearest: their vertices in the world, none of a half-space; their
// distance; and how open its direction is, see normal_turn.
struct NearestPlace {
  std::vector<Vec3> vertices_a, vertices_b;
  PairDistance found;
  double turn;
};

class DistanceCore {
 public:
  // `limit`: m, positive; infinite for all pairs.
  DistanceCore(std::vector<GeometryObject> bodies, std::vector<std::array<std::int32_t, 2>> pairs, std::int32_t links,
               double limit, const Tuning& tuning, std::shared_ptr<const SampledPoses> sampled);

  struct Workspace;
  std::shared_ptr<Workspace> new_workspace() const;
  static CheckerCounters take_counters(Workspace& workspace);

  // Appends a row for each pair that is nearer than the limit, in any order. `tangent`: null for no gradients, as for
  // posed links.
  void measure(const GivenStates& states, const Tangent* tangent, DistanceTable& out, Workspace& workspace) const;
  // Appends a row for each of the `count` nearest pairs of each state, whatever the limit. `rounds`: 0 for distances;
  // else lower bounds, by so many steps of the descent.
  void nearest(const GivenStates& states, const Tangent* tangent, std::size_t count, int rounds, DistanceTable& out,
               Workspace& workspace) const;

  // All places where a pair that is apart is nearest, up to kAsNear of its smaller body's size.
  std::vector<NearestPlace> nearest_places(const GivenStates& state, std::int32_t pair, Workspace& workspace) const;
  // The gradients of the distance for other nearest points of a pair, given by points of A: a row each, appended.
  void gradients_at(const GivenStates& state, const Tangent& tangent, std::int32_t pair, Vec3 normal,
                    const double* points, std::size_t count, std::vector<double>& out, Workspace& workspace) const;

 private:
  struct PosedPair {
    PosedPolytope a, b;
    std::array<std::int32_t, 2> bodies;

    bool are_convex() const;
    bool are_hulls() const;
  };

  std::vector<GeometryObject> bodies_;
  std::vector<std::array<std::int32_t, 2>> pairs_;
  std::int32_t links_;
  double limit_;
  std::vector<unsigned char> needed_;        // links that carry a body of some pair
  std::vector<std::int32_t> all_pairs_;      // their rows
  std::vector<LazyValue<HullEdges>> edges_;  // per body
  std::unique_ptr<const CheckerCore> near_;  // of inflated bodies; null without a limit

  void prepare(const GivenStates& states, const Tangent* tangent, Workspace& workspace) const;
  const PoseColumns* posed_links(const GivenStates& states, std::size_t row, Workspace& workspace) const;
  PosedPolytope posed(std::int32_t body, const PoseColumns* links) const;
  PosedPair posed_pair(std::int32_t pair, const PoseColumns* links) const;
  void add_row(std::size_t state, std::int32_t pair, const PairDistance& found, double spread,
               const VertexPairs& corners, const GivenStates& states, const Tangent* tangent, DistanceTable& out,
               Workspace& workspace) const;
  void order_by_gaps(const PoseColumns* links, Workspace& workspace) const;
  // The distance of two hulls, from the corners of their earlier row on if there is one; `corners` become those where
  // the descent ended.
  PairDistance between_hulls(const GivenStates& states, std::size_t row, std::int32_t pair, const PosedPair& posed,
                             double limit, VertexPairs& corners, PairCounters& counters) const;
  // Corners of an earlier row that are vertices of both bodies.
  static void take_earlier(const GivenStates& states, std::size_t row, std::int32_t pair, const PosedPair& posed,
                           VertexPairs& corners);
  // The distance of a pair; of two bodies that are not both convex, the parts that are nearest are added.
  PairDistance with_parts(const PosedPair& pair, double limit, NearestParts& nearest, PairCounters& counters) const;
  double spread(const PosedPair& pair, const PairDistance& found, const NearestParts& nearest,
                PairCounters& counters) const;
  const HullEdges& edges(std::int32_t body) const;
};

}  // namespace plannercheck
