#include "planar/checker_2d.hpp"

#include <algorithm>
#include <utility>

#include "checking/state_blocks.hpp"
#include "math/interruption.hpp"
#include "math/vec.hpp"
#include "planar/kinematics_2d.hpp"

namespace plannercheck {
namespace {

// The rounding of a posed circle's centre and of a distance is below 20u of the coordinates' sizes; this is far more.
// Where squares of lengths underflow, it is below the least room of circles (plannercheck/planar/body_tables.py).
constexpr double kCircleMargin = 1e-12;

}  // namespace

// Scratch data of kLanes states.
struct PlanarChecker::Workspace {
  struct CircleLanes {
    Lanes x, y, radius;
  };

  PlanarCheckerCounters counters;
  std::vector<Lanes> columns;
  std::vector<PlanarLinkLanes> links;
  std::vector<CircleLanes> circles;
};

std::shared_ptr<PlanarChecker::Workspace> PlanarChecker::new_workspace() const {
  auto w = std::make_shared<Workspace>();
  w->columns.resize(width_);
  w->circles.resize(bodies_.size());
  return w;
}

PlanarCheckerCounters PlanarChecker::take_counters(Workspace& w) { return std::exchange(w.counters, {}); }

void PlanarChecker::pose(Workspace& w) const {
  pose_planar_links(links_, w.columns, w.links);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const PlanarGeometryObject& body = bodies_[b];
    if (body.link < 0) continue;
    const PlanarLinkLanes& link = w.links[at(body.link)];
    Workspace::CircleLanes& circle = w.circles[b];
    circle.x = link.x + (link.cos * body.x - link.sin * body.y);
    circle.y = link.y + (link.sin * body.x + link.cos * body.y);
    circle.radius = body.radius + kCircleMargin * (absolute(link.x) + absolute(link.y));
  }
}

// The lanes in which the circles and boxes of a pair meet.
unsigned PlanarChecker::near(const std::array<std::int32_t, 2>& pair, const Workspace& w) const {
  constexpr unsigned kAll = (1U << kLanes) - 1;
  const PlanarGeometryObject &a = bodies_[at(pair[0])], &b = bodies_[at(pair[1])];
  if (!bounds_ || (a.link < 0 && b.link < 0)) return kAll;
  Lanes dx, dy, reach;
  if (a.link >= 0 && b.link >= 0) {
    const Workspace::CircleLanes &one = w.circles[at(pair[0])], &two = w.circles[at(pair[1])];
    dx = one.x - two.x;
    dy = one.y - two.y;
    reach = one.radius + two.radius;
  } else {
    const Workspace::CircleLanes& circle = w.circles[at(a.link >= 0 ? pair[0] : pair[1])];
    const std::array<double, 4>& box = a.link >= 0 ? b.box : a.box;
    const Lanes zero = broadcast(0);
    dx = larger(larger(box[0] - circle.x, circle.x - box[2]), zero);
    dy = larger(larger(box[1] - circle.y, circle.y - box[3]), zero);
    reach = circle.radius;
  }
  const LaneMask apart = dx * dx + dy * dy > reach * reach;
  return kAll & ~bits(apart);
}

PosedPolygon PlanarChecker::posed(std::int32_t index, std::size_t state, const Workspace& w) const {
  const PlanarGeometryObject& body = bodies_[at(index)];
  if (body.link < 0) return {body.shape, body.pose};
  const PlanarLinkLanes& link = w.links[at(body.link)];
  const double c = link.cos[state], s = link.sin[state];
  return {body.shape, {{c, -s, link.x[state], s, c, link.y[state]}}};
}

// Calls found(state, pair) for collisions; with `first_only`, only for the first pair of each state.
template <class Found>
void PlanarChecker::judge(std::size_t count, bool first_only, Workspace& w, Found found) const {
  pose(w);
  PlanarCheckerCounters& counters = w.counters;
  const unsigned all = (1U << count) - 1;
  unsigned open = all;  // states whose verdict is not known
  counters.states += static_cast<long>(count);
  counters.pairs += static_cast<long>(count * pairs_.size());
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    if (open == 0) {
      counters.skipped += static_cast<long>(count * (pairs_.size() - k));
      return;
    }
    const unsigned close = near(pairs_[k], w) & open;
    counters.skipped += static_cast<long>(count) - __builtin_popcount(open);
    counters.bounds += __builtin_popcount(open & ~close);
    for (std::size_t state = 0; state < count; ++state) {
      if ((close >> state & 1U) == 0) continue;
      ++counters.tests;
      const PosedPolygon a = posed(pairs_[k][0], state, w), b = posed(pairs_[k][1], state, w);
      if (!planar_intersect(a, b, first_, counters.pair)) continue;
      found(state, k);
      if (first_only) open &= ~(1U << state);
    }
  }
}

template <class Work>
void PlanarChecker::each_block(const double* q, std::size_t n, Workspace& w, Work work) const {
  for (std::size_t row = 0; row < n; row += kLanes) {
    if (row > 0) poll_interruption();
    const std::size_t count = std::min<std::size_t>(kLanes, n - row);
    load_rows<kLanes>([&](std::size_t k) { return q + (row + k) * width_; }, count, width_, w.columns.data());
    work(row, count);
  }
}

void PlanarChecker::link_poses(const double* q, std::size_t n, double* poses) const {
  const auto workspace = new_workspace();
  Workspace& w = *workspace;
  each_block(q, n, w, [&](std::size_t, std::size_t count) {
    pose(w);
    for (std::size_t state = 0; state < count; ++state) {
      for (const PlanarLinkLanes& link : w.links) {
        const double c = link.cos[state], s = link.sin[state];
        const double matrix[9] = {c, -s, link.x[state], s, c, link.y[state], 0, 0, 1};
        poses = std::copy_n(matrix, 9, poses);
      }
    }
  });
}

void PlanarChecker::first_collisions(const double* q, std::size_t n, std::int32_t* first, Workspace& w) const {
  std::fill_n(first, n, -1);
  each_block(q, n, w, [&](std::size_t row, std::size_t count) {
    judge(count, true, w, [&](std::size_t state, std::size_t k) { first[row + state] = static_cast<std::int32_t>(k); });
  });
}

void PlanarChecker::all_collisions(const double* q, std::size_t n, std::uint8_t* colliding, Workspace& w) const {
  std::fill_n(colliding, n * pairs_.size(), std::uint8_t{0});
  each_block(q, n, w, [&](std::size_t row, std::size_t count) {
    judge(count, false, w, [&](std::size_t state, std::size_t k) { colliding[(row + state) * pairs_.size() + k] = 1; });
  });
}

bool PlanarChecker::motion_is_free(const double* q0, const double* q1, long steps, Workspace& w) const {
  return is_free_coarse_to_fine<kLanes>(q0, q1, steps, width_, w.columns.data(), [&](std::size_t count) {
    bool free = true;
    judge(count, true, w, [&](std::size_t, std::size_t) { free = false; });
    return free;
  });
}

}  // namespace plannercheck
