#include "motions/motion_screen.hpp"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "math/shuffle.hpp"

namespace plannercheck {
namespace {

// Scenes of up to this many obstacles are tested in lanes faster than by the tree (measured).
constexpr std::size_t kFewObstaclesOnPaths = 1024;

// A path is cut into pieces in which a body goes no further than this from the state that is looked at, m. Shorter
// pieces take more tests, longer ones leave more pairs (measured).
constexpr double kLongestWay = 0.15;
constexpr std::size_t kMostPieces = 8;

// The rounding of centres and distances in floats, whose numbers err by 2^-24 of themselves.
constexpr double kFloatRounding = 0x1p-22;

// One piece of a motion: the state of the grid nearest to its middle, and the longest part of the motion between that
// state and the piece's ends.
struct MotionPiece {
  std::size_t state;
  double part;
};

MotionPiece piece_of(const MotionGrid& grid, std::size_t piece, std::size_t pieces) {
  const auto whole = static_cast<double>(pieces);
  const double start = grid.parameter(0), length = grid.parameter(grid.intervals()) - start;
  const double from = start + length * static_cast<double>(piece) / whole,
               to = start + length * static_cast<double>(piece + 1) / whole;
  const auto state = static_cast<std::size_t>(
      (static_cast<double>(piece) + 0.5) / whole * static_cast<double>(grid.intervals()) + 0.5);
  const double t = grid.parameter(state);
  return {state, larger(t - from, to - t) * (1 + 1e-9) + 0x1p-50};
}

std::size_t pieces_for(double way) {
  std::size_t pieces = 1;
  while (pieces < kMostPieces && way > 2 * kLongestWay * static_cast<double>(pieces)) pieces *= 2;
  return pieces;
}

// Whether two boxes around paths are further apart than this along an axis.
bool are_apart(Floats a, Floats b, float gap) {
  return bits_above(-(a + shuffled<3, 4, 5, 0, 1, 2, 1, 2>(b, b)), Floats{} + gap) != 0;
}

// Whether two points, given by rows, are no further apart than a distance at one of the states. Inlined, since a call
// leaves no numbers in vector registers.
[[gnu::always_inline]] inline bool come_within(const double* a, const double* b, std::size_t intervals,
                                               double distance) {
  const Lanes limit = broadcast(distance * distance);
  unsigned within = 0;
  for (std::size_t i = 0; i <= intervals; i += kStep) {
    const Lanes x = load_lanes(a + i) - load_lanes(b + i),
                y = load_lanes(a + kGridRow + i) - load_lanes(b + kGridRow + i),
                z = load_lanes(a + 2 * kGridRow + i) - load_lanes(b + 2 * kGridRow + i);
    within |= ~bits_above((x * x + y * y) + z * z, limit) & ((1U << kStep) - 1);
  }
  return within != 0;
}

}  // namespace

MotionScreen::MotionScreen(const MotionModel& model, const std::vector<std::int32_t>& movers,
                           const std::vector<std::int32_t>& still)
    : tree_({}) {
  std::vector<std::size_t> place(model.bodies.size());
  for (std::size_t m = 0; m < movers.size(); ++m) place[at(movers[m])] = m;
  for (std::size_t s = 0; s < still.size(); ++s) place[at(still[s])] = s;
  const std::size_t eights = (still.size() + kFloats - 1) / kFloats;
  std::vector<Mover> all(movers.size());
  for (std::size_t p = 0; p < model.pairs.size(); ++p) {
    const CertifiedPair& pair = model.pairs[p];
    const auto index = static_cast<std::int32_t>(p);
    if (!model.bodies[at(pair.b)].body->traits().is_bounded) {
      unbounded_pairs_.push_back(index);
      continue;
    }
    if (model.bodies[at(pair.b)].link >= 0) {
      moving_pairs_.push_back(index);
      continue;
    }
    Mover& mover = all[place[at(pair.a)]];
    const std::size_t b = place[at(pair.b)];
    mover.body = pair.a, mover.chain = pair.chain_a;
    mover.pair.resize(eights * kFloats, -1), mover.paired.resize(eights);
    mover.pair[b] = index;
    mover.paired[b / kFloats] |= 1U << b % kFloats;
  }
  std::vector<std::size_t> ball_of;
  balls_ = link_bounds(model, movers, ball_of);
  group_movers(model, std::move(all), ball_of);
  group_pairs(model, ball_of);
  bound_obstacles(model, still);
}

MotionScreen::ChainRange MotionScreen::chains(const MotionModel& model, std::vector<std::int32_t> of_bodies) {
  const std::size_t first = chains_.size();
  for (const std::int32_t chain : longest_chains(model.chains, std::move(of_bodies))) chains_.push_back(chain);
  return {first, chains_.size()};
}

void MotionScreen::group_movers(const MotionModel& model, std::vector<Mover> movers,
                                const std::vector<std::size_t>& ball_of) {
  std::vector<LinkMovers> groups(balls_.size());
  std::vector<std::vector<std::int32_t>> seen_from_world(balls_.size());  // chains of bodies in pairs of any kind
  for (const CertifiedPair& pair : model.pairs) {
    if (pair.frame >= 0) continue;
    seen_from_world[ball_of[at(pair.a)]].push_back(pair.chain_a);
    if (model.bodies[at(pair.b)].link >= 0) seen_from_world[ball_of[at(pair.b)]].push_back(pair.chain_b);
  }
  for (Mover& mover : movers) {
    if (mover.pair.empty()) continue;
    LinkMovers& group = groups[ball_of[at(mover.body)]];
    group.paired.resize(mover.paired.size());
    for (std::size_t k = 0; k < mover.paired.size(); ++k) group.paired[k] |= mover.paired[k];
    group.movers.push_back(std::move(mover));
  }
  for (std::size_t ball = 0; ball < groups.size(); ++ball) {
    LinkMovers& group = groups[ball];
    if (group.movers.empty()) continue;
    group.ball = ball, group.chains = chains(model, std::move(seen_from_world[ball]));
    movers_by_link_.push_back(std::move(group));
  }
}

void MotionScreen::group_pairs(const MotionModel& model, const std::vector<std::size_t>& ball_of) {
  const auto pair = [&](std::size_t place) -> const CertifiedPair& { return model.pairs[at(moving_pairs_[place])]; };
  const auto key = [&](const CertifiedPair& p) {
    return std::tuple(p.frame >= 0, ball_of[at(p.a)], ball_of[at(p.b)], p.frame);
  };
  std::stable_sort(moving_pairs_.begin(), moving_pairs_.end(),
                   [&](std::int32_t p, std::int32_t q) { return key(model.pairs[at(p)]) < key(model.pairs[at(q)]); });
  for (std::size_t first = 0, past = 0; first < moving_pairs_.size(); first = past) {
    const auto [is_seen_from_link, a, b, frame] = key(pair(first));
    std::vector<std::int32_t> of_a, of_b;
    for (past = first; past < moving_pairs_.size() && key(pair(past)) == key(pair(first)); ++past) {
      of_a.push_back(pair(past).chain_a), of_b.push_back(pair(past).chain_b);
    }
    const ChainRange chains_a = chains(model, of_a), chains_b = chains(model, of_b);
    moving_groups_.push_back({a, b, frame, chains_a, chains_b, balls_[a].radius + balls_[b].radius, first, past});
    from_world_ += is_seen_from_link ? 0 : 1;
  }
}

void MotionScreen::bound_obstacles(const MotionModel& model, const std::vector<std::int32_t>& still) {
  eights_.resize((still.size() + kFloats - 1) / kFloats);
  std::vector<Box> boxes;
  for (std::size_t s = 0; s < still.size(); ++s) {
    const GeometryObject& object = model.bodies[at(still[s])];
    boxes.push_back(box_around_hull(object).grown(object.body->inflation_radius));
    for (std::size_t k = 0; k < 3; ++k) {
      eights_[s / kFloats].side[k][s % kFloats] = rounded_down(boxes.back().low[k]);
      eights_[s / kFloats].side[k + 3][s % kFloats] = -rounded_up(boxes.back().high[k]);
    }
  }
  if (still.size() > kFewObstaclesOnPaths) tree_ = ObstacleTree(boxes);
}

void MotionScreen::find_by_paths(const MotionFilters& filters, std::vector<std::int32_t>& found) const {
  found = unbounded_pairs_;
  found.insert(found.end(), moving_pairs_.begin(), moving_pairs_.end());
  for (const LinkMovers& group : movers_by_link_) {
    for (const Mover& mover : group.movers) {
      const Floats box = filters.box_around_path(mover.body, mover.chain);
      for (std::size_t first = 0; first < eights_.size(); first += kFloats) {
        take(mover, first, near_boxes(first, box, mover.paired), found);
      }
    }
  }
}

void MotionScreen::find_by_speeds(const MotionGrid& grid, const MotionFilters& filters, const ChainBounds& bounds,
                                  double beyond, Workspace& w, std::vector<std::int32_t>& found) const {
  const double room = filters.slack() + beyond;
  pose_balls(grid, w);
  if (from_world_ > 0) bound_paths(filters, bounds, beyond, w);
  find_among_links(grid, filters, bounds, beyond, w, found);
  found.insert(found.end(), unbounded_pairs_.begin(), unbounded_pairs_.end());
  if (eights_.size() * kFloats <= kFewObstaclesOnPaths) return find_near_links(filters, bounds, beyond, w, found);
  for (const LinkMovers& group : movers_by_link_) {
    find_in_tree(grid, group, speed(bounds, group.chains), room + shift_from_obstacles(bounds, group.chains), w);
    if (w.found.empty()) continue;
    for (const Mover& mover : group.movers) {
      const Floats box = filters.box_around_path(mover.body, mover.chain);
      for (const std::int32_t obstacle : w.found) {
        const std::size_t k = at(obstacle) / kFloats;
        take(mover, k, meeting(eights_[k], box) & mover.paired[k] & 1U << at(obstacle) % kFloats, found);
      }
    }
  }
}

void MotionScreen::pose_balls(const MotionGrid& grid, Workspace& w) const {
  constexpr std::size_t kOfBall = 3 * kGridRow / kStep;
  w.rows.resize(balls_.size() * kOfBall);
  for (std::size_t k = 0; k < balls_.size(); ++k) {
    grid.pose_point(balls_[k].link, balls_[k].centre, reinterpret_cast<double*>(&w.rows[k * kOfBall]));
  }
}

const double* MotionScreen::rows(const Workspace& w, std::size_t ball) {
  return reinterpret_cast<const double*>(w.rows.data()) + ball * 3 * kGridRow;
}

double MotionScreen::speed(const ChainBounds& bounds, ChainRange range) const {
  double most = 0;
  for (std::size_t k = range.first; k < range.past; ++k) most = larger(most, bounds.speed(chains_[k]));
  return most;
}

double MotionScreen::shift(const ChainBounds& bounds, ChainRange range) const {
  double most = 0;
  for (std::size_t k = range.first; k < range.past; ++k) most = larger(most, bounds.shift(chains_[k]));
  return most;
}

double MotionScreen::curvature(const ChainBounds& bounds, ChainRange range) const {
  double most = 0;
  for (std::size_t k = range.first; k < range.past; ++k) most = larger(most, bounds.curvature(chains_[k]));
  return most;
}

// The shift by a tube, the obstacles' half of the distance included.
double MotionScreen::shift_from_obstacles(const ChainBounds& bounds, ChainRange range) const {
  return shift(bounds, range) + bounds.shift(-1);
}

// A group of one body takes the box of `find_by_paths`, without room.
Floats MotionScreen::box_around_path(const MotionFilters& filters, const ChainBounds& bounds, double beyond,
                                     const Workspace& w, const LinkMovers& group) const {
  double radius = balls_[group.ball].radius + (group.movers.size() == 1 ? 0 : beyond);
  if (bounds.has_tube()) radius += shift_from_obstacles(bounds, group.chains);
  return filters.box_around_path(rows(w, group.ball), radius, curvature(bounds, group.chains));
}

void MotionScreen::bound_paths(const MotionFilters& filters, const ChainBounds& bounds, double beyond,
                               Workspace& w) const {
  w.paths.resize(balls_.size(), Floats{} + std::numeric_limits<float>::infinity());
  for (const LinkMovers& group : movers_by_link_) {
    w.paths[group.ball] = box_around_path(filters, bounds, beyond, w, group);
  }
}

void MotionScreen::find_near_links(const MotionFilters& filters, const ChainBounds& bounds, double beyond,
                                   const Workspace& w, std::vector<std::int32_t>& found) const {
  for (const LinkMovers& group : movers_by_link_) {
    const bool is_one = group.movers.size() == 1;
    const Floats box = from_world_ > 0 ? w.paths[group.ball] : box_around_path(filters, bounds, beyond, w, group);
    for (std::size_t first = 0; first < eights_.size(); first += kFloats) {
      const std::uint64_t near = near_boxes(first, box, group.paired);
      if (near == 0) continue;
      for (const Mover& mover : group.movers) {
        const std::uint64_t own =
            is_one ? near : near & near_boxes(first, filters.box_around_path(mover.body, mover.chain), mover.paired);
        take(mover, first, own, found);
      }
    }
  }
}

// Which of eight eights of boxes a box may meet; looked at in one go, as which obstacles are near is hard to predict.
std::uint64_t MotionScreen::near_boxes(std::size_t first, Floats box, const std::vector<unsigned>& paired) const {
  const std::size_t past = std::min(first + kFloats, eights_.size());
  std::uint64_t near = 0;
  for (std::size_t k = past; k-- > first;) near = near << kFloats | (meeting(eights_[k], box) & paired[k]);
  return near;
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
  return ~bits_above(beyond, Floats{}) & ((1U << kFloats) - 1);
}

// Writes the groups of pairs that boxes around paths leave open, of those that are seen from the world as the boxes
// are. A verdict rests on how far bodies leave their chords as seen from the pair's frame.
std::size_t MotionScreen::find_meeting_paths(double beyond, Workspace& w) const {
  const float least_gap = rounded_up(beyond);
  std::size_t meeting = 0;
  for (std::size_t k = 0; k < from_world_; ++k) {
    w.near[meeting] = k;
    meeting += are_apart(w.paths[moving_groups_[k].a], w.paths[moving_groups_[k].b], least_gap) ? 0 : 1;
  }
  for (std::size_t k = from_world_; k < moving_groups_.size(); ++k) w.near[meeting++] = k;
  return meeting;
}

// Writes the groups whose balls may come near each other: all of them are looked at, or those that are written there.
// Seen from a pair's frame, the two centres approach each other at most at the sum of both speeds, for at most half the
// time between two states of the grid.
template <bool are_all>
std::size_t MotionScreen::find_near_balls(const MotionGrid& grid, const ChainBounds& bounds, double room,
                                          std::size_t groups, Workspace& w) const {
  // No unpredictable branch: each place is written, and overwritten unless it is near.
  const bool has_tube = bounds.has_tube();
  std::size_t* const taken = w.near.data();
  std::size_t near = 0;
  for (std::size_t m = 0; m < groups; ++m) {
    const std::size_t k = are_all ? m : taken[m];
    const MovingGroup& group = moving_groups_[k];
    double way = (speed(bounds, group.chains_a) + speed(bounds, group.chains_b)) * (grid.step() / 2);
    if (has_tube) way += shift(bounds, group.chains_a) + shift(bounds, group.chains_b);
    taken[near] = k;
    near += come_within(rows(w, group.a), rows(w, group.b), grid.intervals(), group.radii + way + room) ? 1 : 0;
  }
  return near;
}

void MotionScreen::find_among_links(const MotionGrid& grid, const MotionFilters& filters, const ChainBounds& bounds,
                                    double beyond, Workspace& w, std::vector<std::int32_t>& found) const {
  const double room = filters.slack() + beyond;
  const std::size_t groups = moving_groups_.size();
  w.near.resize(groups), w.directions.resize(groups);
  const std::size_t near = from_world_ == 0
                               ? find_near_balls<true>(grid, bounds, room, groups, w)
                               : find_near_balls<false>(grid, bounds, room, find_meeting_paths(beyond, w), w);
  found.clear();
  for (std::size_t k = 0; k < near; ++k) {
    const MovingGroup& group = moving_groups_[w.near[k]];
    const bool is_one = group.past_pairs == group.first_pair + 1;
    if (!is_one && boxes_stay_apart(group, grid, filters, bounds, beyond, w.directions[w.near[k]])) continue;
    for (std::size_t p = group.first_pair; p < group.past_pairs; ++p) found.push_back(moving_pairs_[p]);
  }
}

// One direction settles all pairs of two links at once: the last one, or one that is taken from the boxes.
bool MotionScreen::boxes_stay_apart(const MovingGroup& group, const MotionGrid& grid, const MotionFilters& filters,
                                    const ChainBounds& bounds, double beyond, Vec3& direction) const {
  const LinkBound &a = balls_[group.a], &b = balls_[group.b];
  Deviation both{curvature(bounds, group.chains_a) + curvature(bounds, group.chains_b)};
  if (bounds.has_tube()) both.shift = shift(bounds, group.chains_a) + shift(bounds, group.chains_b);
  const double limit =
      filters.chord_deviation(both) + a.inflation_radius + b.inflation_radius + filters.slack() + beyond;
  if (norm_1(direction) > 0 && filters.are_apart(a.box, b.box, group.frame, direction, limit)) return true;
  const std::size_t middle = (grid.intervals() + 1) / 2;
  const Vec3 other = filters.between(a.box, b.box, group.frame, middle);
  if (!filters.are_apart(a.box, b.box, group.frame, other, limit)) return false;
  direction = other;
  return true;
}

// Writes the obstacles that a ball may come near, piece by piece of its way.
void MotionScreen::find_in_tree(const MotionGrid& grid, const LinkMovers& group, double way, double room,
                                Workspace& w) const {
  const std::size_t pieces = pieces_for(way * (grid.parameter(grid.intervals()) - grid.parameter(0)));
  w.found.clear();
  for (std::size_t k = 0; k < pieces; ++k) {
    const MotionPiece piece = piece_of(grid, k, pieces);
    const double* const row = rows(w, group.ball) + piece.state;
    const Vec3 centre{row[0], row[kGridRow], row[2 * kGridRow]};
    const double distance = balls_[group.ball].radius + way * piece.part + room + norm_1(centre) * kFloatRounding;
    const float radius = static_cast<float>(distance * (1 + kFloatRounding)) + 1e-37F;
    tree_.collect(
        {static_cast<float>(centre.x), static_cast<float>(centre.y), static_cast<float>(centre.z), far_beyond(radius)},
        w.found);
  }
  if (pieces == 1) return;
  std::sort(w.found.begin(), w.found.end());
  w.found.erase(std::unique(w.found.begin(), w.found.end()), w.found.end());
}

}  // namespace plannercheck
