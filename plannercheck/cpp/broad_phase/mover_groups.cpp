#include "broad_phase/mover_groups.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "broad_phase/state_block.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kMostMovers = 8;  // larger ones never paid off with any of the shipped robots
// Costs of testing a body against an obstacle and of making a group's box, in tests of that box (by instructions).
constexpr double kBodyCost = 1.5, kGroupCost = 3;

// The box around all movers of a group, by state.
typedef std::vector<Box> Extent;

void add(const BoundingBall& ball, const double* m, Box& box) {
  const double x = ball.centre[0], y = ball.centre[1], z = ball.centre[2], r = ball.radius;
  const Vec3 c{m[0] * x + m[1] * y + m[2] * z + m[3], m[4] * x + m[5] * y + m[6] * z + m[7],
               m[8] * x + m[9] * y + m[10] * z + m[11]};
  box.add(Box{c, c}.grown(r));
}

void add(const std::vector<BoundingBall>& movers, std::size_t mover, const SampledPoses& sampled, Extent& extent) {
  const std::size_t size = sampled.states == 0 ? 0 : sampled.poses.size() / sampled.states;
  for (std::size_t s = 0; s < sampled.states; ++s)
    add(movers[mover], &sampled.poses[s * size + 16 * at(movers[mover].link)], extent[s]);
}

bool meet(const Box& a, const Box& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
         a.low.z <= b.high.z && b.low.z <= a.high.z;
}

// The share of blocks in which a group meets something in some state.
template <class MeetsIn>
double met(std::size_t states, MeetsIn meets_in) {
  std::size_t blocks = 0, found = 0;
  for (std::size_t first = 0; first < states; first += kBlockStates, ++blocks) {
    const std::size_t last = std::min(first + kBlockStates, states);
    std::size_t s = first;
    while (s < last && !meets_in(s)) ++s;
    if (s < last) ++found;
  }
  return blocks == 0 ? 1 : static_cast<double>(found) / static_cast<double>(blocks);
}

std::vector<std::int32_t> obstacles_of(std::size_t first, std::size_t last, std::size_t obstacles,
                                       const std::vector<std::int32_t>& pair_of) {
  std::vector<std::int32_t> out;
  for (std::size_t o = 0; o < obstacles; ++o) {
    bool paired = false;
    for (std::size_t m = first; m < last; ++m) paired |= pair_of[m * obstacles + o] >= 0;
    if (paired) out.push_back(static_cast<std::int32_t>(o));
  }
  return out;
}

// The pairs of two groups whose boxes save tests, by groups, after all others.
std::vector<PairsOfGroups> pairs_among(std::vector<MoverGroup>& groups, const std::vector<BoundingBall>& movers,
                                       const std::vector<MovingPair>& pairs, const SampledPoses& sampled) {
  std::vector<Extent> extents;
  std::vector<std::size_t> group_of;  // by mover
  for (const MoverGroup& group : groups) {
    Extent& extent = extents.emplace_back(sampled.states);
    for (std::size_t m = group.first; m < group.last; ++m) {
      add(movers, m, sampled, extent);
      group_of.push_back(extents.size() - 1);
    }
  }
  std::map<std::array<std::size_t, 2>, std::vector<MovingPair>> by_groups;
  for (const MovingPair& pair : pairs) {
    const auto [a, b] = std::minmax(group_of[at(pair.a)], group_of[at(pair.b)]);
    by_groups[{a, b}].push_back(pair);
  }
  std::vector<PairsOfGroups> out{{0, 0, {}}};
  for (auto& [of, some] : by_groups) {
    const std::size_t a = of[0], b = of[1];  // a lambda can't name parts of a pair in Clang 14
    const double alone = kBodyCost * static_cast<double>(some.size());
    const double share = met(sampled.states, [&](std::size_t s) { return meet(extents[a][s], extents[b][s]); });
    if (a == b || 2 * kGroupCost + alone * share >= alone) {
      out[0].pairs.insert(out[0].pairs.end(), some.begin(), some.end());
    } else {
      groups[a].has_partners = groups[b].has_partners = true;
      out.push_back({a, b, std::move(some)});
    }
  }
  return out;
}

}  // namespace

// The cheapest way to cut the row of movers into groups, by the last group of each prefix of the row.
MoverGroups mover_groups(const std::vector<BoundingBall>& movers, const std::vector<Box>& boxes,
                         const std::vector<std::int32_t>& pair_of, const std::vector<MovingPair>& moving_pairs,
                         const SampledPoses& sampled) {
  const std::size_t n = movers.size();
  std::vector<double> cost(n + 1, Box::kFarthest);  // of the first i movers
  std::vector<std::size_t> begin(n + 1, 0);         // of their last group
  cost[0] = 0;
  for (std::size_t first = 0; first < n; ++first) {
    Extent extent(sampled.states);
    for (std::size_t last = first + 1; last <= std::min(first + kMostMovers, n); ++last) {
      add(movers, last - 1, sampled, extent);
      const auto count = static_cast<double>(last - first);
      double total = cost[first] + kGroupCost;
      for (const std::int32_t o : obstacles_of(first, last, boxes.size(), pair_of)) {
        total +=
            1 + kBodyCost * count * met(sampled.states, [&](std::size_t s) { return meet(extent[s], boxes[at(o)]); });
      }
      if (total < cost[last]) cost[last] = total, begin[last] = first;
    }
  }
  std::vector<MoverGroup> out;
  for (std::size_t last = n; last > 0; last = begin[last]) {
    MoverGroup group{begin[last], last, obstacles_of(begin[last], last, boxes.size(), pair_of), {}, 0};
    std::vector<Box> of_obstacles;
    for (const std::int32_t o : group.obstacles) of_obstacles.push_back(boxes[at(o)]);
    group.boxes = side_by_side<StateFloats>(of_obstacles);
    const auto row = [&](std::size_t mover) {
      return pair_of.begin() + static_cast<std::ptrdiff_t>(mover * boxes.size());
    };
    const auto is_pair = [](std::int32_t pair) { return pair >= 0; };
    group.pairs = static_cast<std::size_t>(std::count_if(row(group.first), row(group.last), is_pair));
    out.push_back(std::move(group));
  }
  std::reverse(out.begin(), out.end());
  std::vector<PairsOfGroups> among_movers = pairs_among(out, movers, moving_pairs, sampled);
  return {std::move(out), std::move(among_movers)};
}

}  // namespace plannercheck
