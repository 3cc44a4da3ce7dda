#include "motions/motion_screen.hpp"

#include <algorithm>
#include <limits>

namespace plannercheck {
namespace {

// Scenes of up to this many obstacles are tested in lanes faster than by the tree (measured).
constexpr std::size_t kFewObstaclesOnPaths = 1024;

// A path is cut into pieces in which a body goes no further than this from the state that is looked at, m. Shorter
// pieces take more tests, longer ones leave more pairs (measured).
constexpr double kLongestWay = 0.15;
constexpr std::size_t kMostPieces = 8;

// Of centres and distances in floats: their numbers err by 2^-24 of themselves.
constexpr double kFloatRounding = 0x1p-22;

// One piece of a motion: the state of the grid nearest to its middle, and the longest part of the motion between that
// state and the piece's ends.
struct MotionPiece {
  std::size_t state;
  double part;
};

MotionPiece piece_of(const MotionGrid& grid, std::size_t piece, std::size_t pieces) {
  const auto whole = static_cast<double>(pieces);
  const double from = static_cast<double>(piece) / whole, to = static_cast<double>(piece + 1) / whole;
  const auto state = static_cast<std::size_t>((from + to) / 2 * static_cast<double>(grid.intervals()) + 0.5);
  const double t = grid.parameter(state);
  return {state, larger(t - from, to - t) * (1 + 1e-9) + 0x1p-50};
}

std::size_t pieces_for(double way) {
  std::size_t pieces = 1;
  while (pieces < kMostPieces && way > 2 * kLongestWay * static_cast<double>(pieces)) pieces *= 2;
  return pieces;
}

}  // namespace

MotionScreen::MotionScreen(const MotionModel& model, const std::vector<std::int32_t>& movers,
                           const std::vector<std::int32_t>& still)
    : moving_(movers), tree_({}) {
  std::vector<std::size_t> place(model.bodies.size());
  for (std::size_t m = 0; m < movers.size(); ++m) place[at(movers[m])] = m;
  for (std::size_t s = 0; s < still.size(); ++s) place[at(still[s])] = s;
  const std::size_t eights = (still.size() + kFloats - 1) / kFloats;
  const auto radius = [&](std::int32_t body) { return sphere_radius(*model.bodies[at(body)].body); };
  std::vector<Mover> all(movers.size());
  for (std::size_t p = 0; p < model.pairs.size(); ++p) {
    const CertifiedPair& pair = model.pairs[p];
    const std::size_t a = place[at(pair.a)], b = place[at(pair.b)];
    if (model.bodies[at(pair.b)].body->half_space) {
      unbounded_pairs_.push_back(static_cast<std::int32_t>(p));
      continue;
    }
    if (model.bodies[at(pair.b)].link >= 0) {
      const double radii = radius(pair.a) + radius(pair.b);
      moving_pairs_.push_back({a, b, pair.chain_a, pair.chain_b, radii, static_cast<std::int32_t>(p)});
      continue;
    }
    Mover& mover = all[a];
    mover.body = pair.a, mover.chain = pair.chain_a, mover.radius = radius(pair.a);
    mover.pair.resize(eights * kFloats, -1), mover.paired.resize(eights);
    mover.pair[b] = static_cast<std::int32_t>(p);
    mover.paired[b / kFloats] |= 1U << b % kFloats;
  }
  for (Mover& mover : all) {
    if (!mover.pair.empty()) movers_.push_back(std::move(mover));
  }
  bound_obstacles(model, still);
}

void MotionScreen::bound_obstacles(const MotionModel& model, const std::vector<std::int32_t>& still) {
  const double infinity = std::numeric_limits<double>::infinity();
  eights_.resize((still.size() + kFloats - 1) / kFloats);
  std::vector<WorldBox> boxes;
  for (std::size_t s = 0; s < still.size(); ++s) {
    const GeometryObject& object = model.bodies[at(still[s])];
    WorldBox box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (const Vec3& v : object.body->inner.points) {
      const Vec3 p = object.placement.apply(v);
      box.low = {smaller(box.low.x, p.x), smaller(box.low.y, p.y), smaller(box.low.z, p.z)};
      box.high = {larger(box.high.x, p.x), larger(box.high.y, p.y), larger(box.high.z, p.z)};
    }
    const double inflated = object.body->inflation_radius;
    boxes.push_back({box.low - Vec3{inflated, inflated, inflated}, box.high + Vec3{inflated, inflated, inflated}});
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<int>(k);
      eights_[s / kFloats].side[k][s % kFloats] = rounded_down(boxes.back().low[axis]);
      eights_[s / kFloats].side[k + 3][s % kFloats] = -rounded_up(boxes.back().high[axis]);
    }
  }
  if (still.size() > kFewObstaclesOnPaths) tree_ = ObstacleTree(boxes);
}

void MotionScreen::find_by_paths(const MotionFilters& filters, std::vector<std::int32_t>& found) const {
  found = unbounded_pairs_;
  for (const MovingPair& pair : moving_pairs_) found.push_back(pair.pair);
  find_near_paths(filters, found);
}

// What eight eights leave is looked at in one go: which obstacles are near is hard to predict.
void MotionScreen::find_near_paths(const MotionFilters& filters, std::vector<std::int32_t>& found) const {
  for (const Mover& mover : movers_) {
    const Floats box = filters.box_around_path(mover.body, mover.chain);
    for (std::size_t first = 0; first < eights_.size(); first += kFloats) {
      const std::size_t past = std::min(first + kFloats, eights_.size());
      std::uint64_t near = 0;
      for (std::size_t k = past; k-- > first;) near = near << kFloats | (meeting(eights_[k], box) & mover.paired[k]);
      take(mover, first, near, found);
    }
  }
}

void MotionScreen::find_by_speeds(const MotionGrid& grid, const MotionFilters& filters, const ChainBounds& bounds,
                                  double beyond, Workspace& w, std::vector<std::int32_t>& found) const {
  const double room = filters.slack() + beyond;
  find_among_movers(grid, bounds, room, w, found);
  found.insert(found.end(), unbounded_pairs_.begin(), unbounded_pairs_.end());
  if (eights_.size() * kFloats <= kFewObstaclesOnPaths) return find_near_paths(filters, found);
  for (const Mover& mover : movers_) {
    w.found.clear();
    find_in_tree(grid, mover, bounds.speed(mover.chain), room, w.found);
    if (w.found.empty()) continue;
    const Floats box = filters.box_around_path(mover.body, mover.chain);
    for (const std::int32_t obstacle : w.found) {
      const std::size_t k = at(obstacle) / kFloats;
      take(mover, k, meeting(eights_[k], box) & mover.paired[k] & 1U << at(obstacle) % kFloats, found);
    }
  }
}

void MotionScreen::take(const Mover& mover, std::size_t eight, std::uint64_t near, std::vector<std::int32_t>& found) {
  for (; near != 0; near &= near - 1) {
    found.push_back(mover.pair[eight * kFloats + static_cast<std::size_t>(__builtin_ctzll(near))]);
  }
}

// Which boxes another one may meet: none beyond any of its sides.
unsigned MotionScreen::meeting(const Eight& boxes, Floats box) {
  Floats beyond = boxes.side[0] - box[0];
#pragma GCC unroll 5
  for (std::size_t k = 1; k < 6; ++k) beyond = larger(beyond, boxes.side[k] - box[k]);
  return ~float_bits(beyond > Floats{}) & ((1U << kFloats) - 1);
}

// Seen from a pair's frame, the two centres approach each other at most at the sum of both speeds.
void MotionScreen::find_among_movers(const MotionGrid& grid, const ChainBounds& bounds, double room, Workspace& w,
                                     std::vector<std::int32_t>& found) const {
  const MotionPiece piece = piece_of(grid, 0, 1);
  w.centres.resize(moving_.size());
  for (std::size_t m = 0; m < moving_.size(); ++m) w.centres[m] = grid.centre_at(moving_[m], piece.state);
  // Without a branch that can't be foreseen: each pair is written, and overwritten unless it is near.
  found.resize(moving_pairs_.size());
  std::size_t near = 0;
  for (const MovingPair& pair : moving_pairs_) {
    const Vec3 d = w.centres[pair.a] - w.centres[pair.b];
    const double way = (bounds.speed(pair.chain_a) + bounds.speed(pair.chain_b)) * piece.part;
    const double distance = pair.radii + way + room;
    found[near] = pair.pair;
    near += dot(d, d) > distance * distance ? 0 : 1;
  }
  found.resize(near);
}

// Writes the obstacles that a body's sphere may come near, piece by piece of its way.
void MotionScreen::find_in_tree(const MotionGrid& grid, const Mover& mover, double way, double room,
                                std::vector<std::int32_t>& found) const {
  const std::size_t pieces = pieces_for(way);
  for (std::size_t k = 0; k < pieces; ++k) {
    const MotionPiece piece = piece_of(grid, k, pieces);
    const Vec3 centre = grid.centre_at(mover.body, piece.state);
    const double distance = mover.radius + way * piece.part + room + norm_1(centre) * kFloatRounding;
    const float radius = static_cast<float>(distance * (1 + kFloatRounding)) + 1e-37F;
    tree_.collect(
        {static_cast<float>(centre.x), static_cast<float>(centre.y), static_cast<float>(centre.z), far_beyond(radius)},
        found);
  }
  if (pieces == 1) return;
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
}

}  // namespace plannercheck
