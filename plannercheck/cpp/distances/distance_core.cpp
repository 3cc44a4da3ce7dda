#include "distances/distance_core.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/interruption.hpp"
#include "narrow_phase/distance.hpp"
#include "robots/state_poser.hpp"

namespace plannercheck {
namespace {

// Bodies inflated by this part of the limit meet wherever they are no further apart than the limit, whatever rounding.
constexpr double kHalfAndMore = 0.5 * (1 + 1e-9);

constexpr std::size_t kPoseNumbersGiven = 16;

// Nearest points that are all within this part of the bodies' sizes count as one.
constexpr double kOnePoint = 1e-8;

// Parts count as nearest if they are further apart by less than this part of the smaller body's size, as poses are
// rounded.
constexpr double kAsNear = 1e-12;

std::vector<Vec3> posed_vertices(const PosedPolytope& posed) {
  std::vector<Vec3> out;
  if (!posed.body->traits().is_bounded) return out;
  for (const Vec3& vertex : posed.body->inner.points) out.push_back(posed.pose.apply(vertex));
  return out;
}

std::vector<GeometryObject> inflated(std::vector<GeometryObject> objects, double by) {
  for (GeometryObject& object : objects) {
    auto body = std::make_shared<Polytope>(*object.body);
    body->inflation_radius += by;
    object.body = std::move(body);
  }
  return objects;
}

}  // namespace

DistanceTable in_order(const std::vector<DistanceTable>& parts, std::size_t tangent) {
  struct Place {
    const DistanceRow* row;
    const double* gradient;
  };
  std::vector<Place> places;
  for (const DistanceTable& part : parts) {
    for (std::size_t k = 0; k < part.rows.size(); ++k) {
      places.push_back({&part.rows[k], part.gradients.data() + k * tangent});
    }
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    if (a.row->state != b.row->state) return a.row->state < b.row->state;
    if (a.row->distance != b.row->distance) return a.row->distance < b.row->distance;
    return a.row->pair < b.row->pair;
  });
  DistanceTable out;
  out.rows.reserve(places.size()), out.gradients.reserve(places.size() * tangent);
  for (const Place& place : places) {
    out.rows.push_back(*place.row);
    out.gradients.insert(out.gradients.end(), place.gradient, place.gradient + tangent);
  }
  return out;
}

std::vector<GeometryObject> without_padding(std::vector<GeometryObject> bodies, std::span<const double> paddings) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!(paddings[i] > 0)) continue;
    auto body = std::make_shared<Polytope>(*bodies[i].body);
    body->inflation_radius = larger(body->inflation_radius - paddings[i], 0);
    bodies[i].body = std::move(body);
  }
  return bodies;
}

struct DistanceCore::Workspace {
  std::shared_ptr<CheckerCore::Workspace> near;
  StatePoser poser;
  std::uint64_t kinematics = 0;        // for which the poser and the joints are prepared
  std::vector<CarryingJoints> joints;  // per pair
  std::vector<double> gaps;            // per pair: of the balls around its bodies
  std::vector<std::int32_t> order;     // of the pairs, by these
  std::vector<PoseColumns> links;      // of a state whose links are given
  PairCounters counters;
};

DistanceCore::DistanceCore(std::vector<GeometryObject> bodies, std::vector<std::array<std::int32_t, 2>> pairs,
                           std::int32_t links, double limit, const Tuning& tuning,
                           std::shared_ptr<const SampledPoses> sampled)
    : bodies_(std::move(bodies)),
      pairs_(std::move(pairs)),
      links_(links),
      limit_(limit),
      needed_(at(links), 0),
      all_pairs_(indices_below(pairs_.size())),
      edges_(bodies_.size()) {
  for (const auto& pair : pairs_) {
    for (const std::int32_t body : pair) {
      if (bodies_[at(body)].link >= 0) needed_[at(bodies_[at(body)].link)] = 1;
    }
  }
  if (std::isfinite(limit_)) {
    near_ = std::make_unique<const CheckerCore>(inflated(bodies_, limit_ * kHalfAndMore), pairs_, links_, tuning,
                                                std::move(sampled), std::vector<PairsInCells>{});
  }
}

std::shared_ptr<DistanceCore::Workspace> DistanceCore::new_workspace() const {
  auto w = std::make_shared<Workspace>();
  if (near_) w->near = near_->new_workspace();
  return w;
}

CheckerCounters DistanceCore::take_counters(Workspace& w) {
  CheckerCounters out = w.near ? CheckerCore::take_counters(*w.near) : CheckerCounters{};
  out.pair += std::exchange(w.counters, {});
  return out;
}

void DistanceCore::prepare(const GivenStates& states, const Tangent* tangent, Workspace& w) const {
  if (states.kinematics == nullptr) {
    w.links.resize(at(links_));
    return;
  }
  if (w.kinematics != states.kinematics->id()) {
    w.poser.begin(*states.kinematics, needed_.data());
    w.joints.clear();
    w.kinematics = states.kinematics->id();
  }
  if (tangent == nullptr || !w.joints.empty()) return;
  for (const auto& [a, b] : pairs_) {
    w.joints.push_back(carrying_joints(*states.kinematics, bodies_[at(a)].link, bodies_[at(b)].link));
  }
}

// ----- what is asked

void DistanceCore::measure(const GivenStates& states, const Tangent* tangent, DistanceTable& out, Workspace& w) const {
  prepare(states, tangent, w);
  const auto measured = [&](std::size_t row, const std::vector<std::int32_t>& pairs) {
    if (pairs.empty()) return;
    const PoseColumns* const links = posed_links(states, row, w);
    for (const std::int32_t pair : pairs) {
      NearestParts nearest;
      const PosedPair posed = posed_pair(pair, links);
      VertexPairs corners;
      const PairDistance found = posed.are_hulls()
                                     ? between_hulls(states, row, pair, posed, limit_, corners, w.counters)
                                     : with_parts(posed, limit_, nearest, w.counters);
      if (found.upper > limit_) continue;
      add_row(row, pair, found, spread(posed, found, nearest, w.counters), corners, states, tangent, out, w);
    }
  };
  if (near_ && states.kinematics != nullptr) {
    near_->near_pairs(*states.kinematics, states.numbers, states.count, measured, *w.near);
  } else if (near_) {
    near_->near_pairs(states.numbers, states.count, measured, *w.near);
  } else {
    for (std::size_t row = 0; row < states.count; ++row) {
      poll_interruption();
      measured(row, all_pairs_);
    }
  }
}

void DistanceCore::nearest(const GivenStates& states, const Tangent* tangent, std::size_t count, int rounds,
                           DistanceTable& out, Workspace& w) const {
  struct Candidate {
    PairDistance found;
    std::int32_t pair;
    VertexPairs corners;
  };
  const auto is_nearer = [](const Candidate& a, const Candidate& b) {
    const double of_a = a.found.measured(), of_b = b.found.measured();
    return of_a < of_b || (of_a == of_b && a.pair < b.pair);
  };
  prepare(states, tangent, w);
  std::vector<Candidate> best;
  for (std::size_t row = 0; row < states.count; ++row) {
    poll_interruption();
    const PoseColumns* const links = posed_links(states, row, w);
    order_by_gaps(links, w);
    best.clear();
    for (const std::int32_t pair : w.order) {
      const double limit = best.size() < count ? kNoLimit : best.back().found.measured();
      if (best.size() == count && w.gaps[at(pair)] > limit) break;
      const PosedPair posed = posed_pair(pair, links);
      PairDistance found;
      VertexPairs corners;
      if (rounds > 0) {
        found.lower = found.upper = distance_bound(posed.a, posed.b, rounds, w.counters);
      } else {
        found = posed.are_hulls() ? between_hulls(states, row, pair, posed, limit, corners, w.counters)
                                  : pair_distance(posed.a, posed.b, limit, w.counters);
      }
      const Candidate candidate{found, pair, corners};
      if (found.lower > limit || (best.size() == count && !is_nearer(candidate, best.back()))) continue;
      if (best.size() == count) best.pop_back();
      best.insert(std::upper_bound(best.begin(), best.end(), candidate, is_nearer), candidate);
    }
    for (const auto& [found, pair, corners] : best) {
      NearestParts nearest;
      const PosedPair posed = posed_pair(pair, links);
      if (rounds == 0 && !posed.are_convex()) with_parts(posed, found.upper, nearest, w.counters);
      const double apart = rounds == 0 ? spread(posed, found, nearest, w.counters) : kNoLimit;
      add_row(row, pair, found, apart, corners, states, tangent, out, w);
    }
  }
}

std::vector<NearestPlace> DistanceCore::nearest_places(const GivenStates& state, std::int32_t pair,
                                                       Workspace& w) const {
  prepare(state, nullptr, w);
  const PoseColumns* const links = posed_links(state, 0, w);
  const auto [a, b] = pairs_[at(pair)];
  const PosedPolytope body_a = posed(a, links), body_b = posed(b, links);
  const double room = kAsNear * smaller(extent(*body_a.body), extent(*body_b.body));
  std::vector<NearestPlace> out;
  double least = kNoLimit;
  const auto show = [&](const PosedPolytope& part_a, const PosedPolytope& part_b, const PairDistance& found) {
    if (found.lower > least + room) return;
    least = smaller(least, found.upper);
    out.push_back(
        {posed_vertices(part_a), posed_vertices(part_b), found, normal_turn(part_a, part_b, found, w.counters)});
  };
  const PartVisitor visit{show, room};
  pair_distance(body_a, body_b, kNoLimit, w.counters, &visit);
  std::erase_if(out, [&](const NearestPlace& place) { return place.found.lower > least + room; });
  if (body_a.body->traits().is_bounded) return out;
  for (NearestPlace& place : out) {
    std::swap(place.vertices_a, place.vertices_b), std::swap(place.found.on_body_a, place.found.on_body_b);
    place.found.direction = -place.found.direction;
  }
  return out;
}

void DistanceCore::gradients_at(const GivenStates& state, const Tangent& tangent, std::int32_t pair, Vec3 normal,
                                const double* points, std::size_t count, std::vector<double>& out, Workspace& w) const {
  prepare(state, &tangent, w);
  posed_links(state, 0, w);
  out.assign(count * tangent.width, 0.0);
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 point{points[3 * k], points[3 * k + 1], points[3 * k + 2]};
    add_gradient(*state.kinematics, w.poser, w.joints[at(pair)], tangent, point, normal, &out[k * tangent.width]);
  }
}

// ----- one state

const PoseColumns* DistanceCore::posed_links(const GivenStates& states, std::size_t row, Workspace& w) const {
  if (states.kinematics != nullptr) return w.poser.pose(states.numbers + row * at(states.kinematics->width()));
  const double* const links = states.numbers + row * at(links_) * kPoseNumbersGiven;
  for (std::size_t k = 0; k < w.links.size(); ++k) w.links[k] = columns_of(links + k * kPoseNumbersGiven);
  return w.links.data();
}

PosedPolytope DistanceCore::posed(std::int32_t body, const PoseColumns* links) const {
  const GeometryObject& object = bodies_[at(body)];
  return {object.body.get(), object.link < 0 ? object.placement : placed_on(links[at(object.link)], object.placement)};
}

DistanceCore::PosedPair DistanceCore::posed_pair(std::int32_t pair, const PoseColumns* links) const {
  const auto& bodies = pairs_[at(pair)];
  return {posed(bodies[0], links), posed(bodies[1], links), bodies};
}

bool DistanceCore::PosedPair::are_convex() const { return a.body->traits().is_convex && b.body->traits().is_convex; }

bool DistanceCore::PosedPair::are_hulls() const {
  return a.body->traits().fills_hull() && b.body->traits().fills_hull();
}

void DistanceCore::order_by_gaps(const PoseColumns* links, Workspace& w) const {
  w.gaps.resize(pairs_.size());
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    w.gaps[k] = ball_gap(posed(pairs_[k][0], links), posed(pairs_[k][1], links));
  }
  w.order = all_pairs_;
  std::sort(w.order.begin(), w.order.end(), [&](std::int32_t a, std::int32_t b) {
    return w.gaps[at(a)] < w.gaps[at(b)] || (w.gaps[at(a)] == w.gaps[at(b)] && a < b);
  });
}

void DistanceCore::add_row(std::size_t state, std::int32_t pair, const PairDistance& found, double spread,
                           const VertexPairs& corners, const GivenStates& states, const Tangent* tangent,
                           DistanceTable& out, Workspace& w) const {
  const auto [a, b] = pairs_[at(pair)];
  const double size = smaller(extent(*bodies_[at(a)].body), extent(*bodies_[at(b)].body));
  out.rows.push_back({static_cast<std::int64_t>(states.first + state), pair, found.measured(), found.lower,
                      found.on_body_a, found.on_body_b, found.direction, spread, spread <= kOnePoint * size, corners});
  if (tangent == nullptr) return;
  out.gradients.resize(out.gradients.size() + tangent->width, 0.0);
  double* const gradient = out.gradients.data() + out.gradients.size() - tangent->width;
  add_gradient(*states.kinematics, w.poser, w.joints[at(pair)], *tangent, found.on_body_a, found.direction, gradient);
}

PairDistance DistanceCore::between_hulls(const GivenStates& states, std::size_t row, std::int32_t pair,
                                         const PosedPair& posed, double limit, VertexPairs& corners,
                                         PairCounters& counters) const {
  if (!states.earlier.bounds.empty()) take_earlier(states, row, pair, posed, corners);
  return convex_distance(posed.a, posed.b, limit, counters, &corners);
}

void DistanceCore::take_earlier(const GivenStates& states, std::size_t row, std::int32_t pair, const PosedPair& posed,
                                VertexPairs& corners) {
  const EarlierRows& earlier = states.earlier;
  const std::int32_t* const bounds = &earlier.bounds[states.first + row];
  const std::int32_t* const own = std::find(earlier.pairs + bounds[0], earlier.pairs + bounds[1], pair);
  if (own == earlier.pairs + bounds[1]) return;
  const std::int32_t* const numbers = earlier.corners + kCornerNumbers * static_cast<std::size_t>(own - earlier.pairs);
  const std::int32_t count = numbers[0];
  const auto are_of = [&](const std::int32_t* vertices, const Polytope& body) {
    const auto is_own = [&](std::int32_t vertex) { return vertex >= 0 && at(vertex) < body.inner.points.size(); };
    return std::all_of(vertices, vertices + count, is_own);
  };
  if (count < 1 || count > 4 || !are_of(numbers + 1, *posed.a.body) || !are_of(numbers + 5, *posed.b.body)) return;
  corners.count = count;
  std::copy_n(numbers + 1, count, corners.body_a.begin());
  std::copy_n(numbers + 5, count, corners.body_b.begin());
}

PairDistance DistanceCore::with_parts(const PosedPair& pair, double limit, NearestParts& nearest,
                                      PairCounters& counters) const {
  if (pair.are_convex()) return pair_distance(pair.a, pair.b, limit, counters);
  std::array<HullEdges, 2> of_parts;
  const auto edges_from = [&](const PosedPolytope& part, HullEdges& own) -> const HullEdges& {
    if (part.body == pair.a.body) return edges(pair.bodies[0]);
    return part.body == pair.b.body ? edges(pair.bodies[1]) : own = edges_of(*part.body);
  };
  const auto show = [&](const PosedPolytope& part_a, const PosedPolytope& part_b, const PairDistance& found) {
    nearest.add(part_a, edges_from(part_a, of_parts[0]), part_b, edges_from(part_b, of_parts[1]), found, counters);
  };
  const PartVisitor add{show};
  return pair_distance(pair.a, pair.b, limit, counters, &add);
}

double DistanceCore::spread(const PosedPair& pair, const PairDistance& found, const NearestParts& nearest,
                            PairCounters& counters) const {
  if (!pair.are_convex()) return nearest.spread();
  return nearest_spread(pair.a, edges(pair.bodies[0]), pair.b, edges(pair.bodies[1]), found, counters);
}

const HullEdges& DistanceCore::edges(std::int32_t body) const {
  return edges_[at(body)].get([&] { return edges_of(*bodies_[at(body)].body); });
}

}  // namespace plannercheck
