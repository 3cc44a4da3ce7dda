#include "library/cell_edits.hpp"

#include <algorithm>
#include <cmath>

#include "narrow_phase/distance.hpp"

namespace plannercheck {
namespace {

using Rows = std::vector<std::int32_t>;

// Two bodies at rest that are further apart than this, m, are apart (plannercheck/motions/certifier_pairs.py).
constexpr double kPermanentGap = 1e-9;

constexpr std::size_t kListedNames = 20;

// The bodies of an obstacle.
Rows bodies_of(const PreparedCell& cell, const std::string& name) {
  Rows found;
  for (std::size_t k = cell.meets_obstacles.size(); k < cell.bodies.size(); ++k) {
    if (cell.body_names[k] == name && cell.bodies[k].link < 0) found.push_back(static_cast<std::int32_t>(k));
  }
  return found;
}

[[noreturn]] void refuse_name(const PreparedCell& cell, const std::string& name) {
  std::string known;
  std::size_t listed = 0;
  for (std::size_t k = cell.meets_obstacles.size(); k < cell.bodies.size() && listed < kListedNames; ++k) {
    const std::string& other = cell.body_names[k];  // empty once it is removed
    if (other.empty() || (k > 0 && other == cell.body_names[k - 1])) continue;
    known += (listed++ > 0 ? ", " : "") + other;
  }
  throw EditError("unknown obstacle '" + name + "': there is " + (known.empty() ? "none" : known));
}

void check_edit(const Edit& edit) {
  if (edit.name.empty()) throw EditError("an obstacle must have a name");
  if (edit.kind == Edit::Kind::kRemove) return;
  if (!is_placement(edit.pose))
    throw EditError("obstacle '" + edit.name +
                    "': a pose must be rigid, finite and right-handed: |M^T M - 1| at most 1e-6");
  if (edit.kind == Edit::Kind::kMove) return;
  if (edit.points.empty()) throw EditError("obstacle '" + edit.name + "' has no points, a body needs at least one");
  const auto is_point = [](const Vec3& p) { return is_coordinate(p.x) && is_coordinate(p.y) && is_coordinate(p.z); };
  if (!std::all_of(edit.points.begin(), edit.points.end(), is_point))
    throw EditError("obstacle '" + edit.name + "': coordinates must be finite, and at most 1e50 m in size");
  if (!is_radius(edit.radius))
    throw EditError("obstacle '" + edit.name + "': a radius must be a length in m of at least 0");
}

Polytope hull_of(const Edit& edit) {
  try {
    return prepare_polytope(edit.points);
  } catch (const HullError& error) {
    throw EditError("obstacle '" + edit.name + "' has no hull to work with: " + error.what());
  }
}

std::shared_ptr<const Polytope> shape_of(const Edit& edit, double padding) {
  if (edit.kind == Edit::Kind::kHull) {
    Polytope body = hull_of(edit);
    body.inflation_radius = edit.radius + padding;
    return std::make_shared<Polytope>(std::move(body));
  }
  std::vector<double> numbers;
  for (const Vec3& p : edit.points) numbers.insert(numbers.end(), {p.x, p.y, p.z});
  auto set = std::make_shared<PartSet>(PartSet::balls(numbers.data(), edit.points.size(), &edit.radius, true));
  return std::make_shared<Polytope>(polytope_around(std::move(set), padding));
}

bool is_one_of(const Rows& bodies, std::int32_t body) {
  return std::find(bodies.begin(), bodies.end(), body) != bodies.end();
}

// Of each pair of the new cell, its row in the old one, or −1.
struct NewPairs {
  std::vector<std::array<std::int32_t, 2>> pairs;
  Rows old_rows;
};

// The chains between the bodies of rows of a new cell; those of the old one, and those from the world.
ChainedTable chained(const PreparedCell& cell, const ChainedTable& old, std::size_t old_rows, const NewPairs& made,
                     const Rows& rows) {
  ChainedTable out;
  out.chains = old.chains, out.from_world = old.from_world;
  Rows place(old_rows, -1);  // of an old row among the old table's pairs
  for (std::size_t k = 0; k < old.rows.size(); ++k) place[at(old.rows[k])] = static_cast<std::int32_t>(k);
  for (const std::int32_t row : rows) {
    const auto [a, b] = cell.pairs[at(row)];
    if (cell.bodies[at(a)].link < 0 && cell.bodies[at(b)].link < 0) continue;
    const std::int32_t old_row = made.old_rows[at(row)];
    if (old_row >= 0) {
      out.pairs.push_back(old.pairs[at(place[at(old_row)])]);
    } else {
      const auto found = std::find_if(old.from_world.begin(), old.from_world.end(),
                                      [&, body = a](const auto& each) { return each[0] == body; });
      out.pairs.push_back({a, b, -1, found->at(1), -1});
    }
    out.rows.push_back(row);
  }
  return out;
}

// The pairs at rest that touch: those that did, and those of changed bodies that do now.
Rows touching(const PreparedCell& cell, const ChainedTable& old, const NewPairs& made, const Rows& changed,
              const Rows& rows) {
  Rows out;
  PairCounters counters;
  for (const std::int32_t row : rows) {
    const auto& [a, b] = cell.pairs[at(row)];
    const GeometryObject &first = cell.bodies[at(a)], &second = cell.bodies[at(b)];
    if (first.link >= 0 || second.link >= 0) continue;
    const bool is_changed = is_one_of(changed, a) || is_one_of(changed, b);
    const bool touches = is_changed ? !(pair_distance({first.body.get(), first.placement},
                                                      {second.body.get(), second.placement}, kPermanentGap, counters)
                                            .lower > kPermanentGap)
                                    : is_one_of(old.touching, made.old_rows[at(row)]);
    if (touches) out.push_back(row);
  }
  return out;
}

// The pairs in cells by their places among those that are reachable now.
std::vector<PairsInCells> in_cells(const PreparedCell& old, const PreparedCell& cell, const NewPairs& made) {
  const Rows before = rows_of(old, Table::kWithinLimits), now = rows_of(cell, Table::kWithinLimits);
  Rows place(old.pairs.size(), -1);  // of an old row among the new reachable ones
  for (std::size_t k = 0; k < now.size(); ++k) {
    const std::int32_t row = made.old_rows[at(now[k])];
    if (row >= 0) place[at(row)] = static_cast<std::int32_t>(k);
  }
  std::vector<PairsInCells> out = old.in_cells;
  for (PairsInCells& each : out) {
    for (std::int32_t& pair : each.pairs) pair = pair < 0 ? -1 : place[at(before[at(pair)])];
  }
  return out;
}

// The cell with bodies of which some have changed; pairs of `removed` bodies go, `added` come.
PreparedCell with_pairs(const PreparedCell& old, PreparedCell cell, const Rows& removed, const Rows& changed,
                        const std::vector<std::array<std::int32_t, 2>>& added) {
  NewPairs made;
  cell.unreachable.clear();
  for (std::size_t k = 0; k < old.pairs.size(); ++k) {
    const auto& [a, b] = old.pairs[k];
    if (is_one_of(removed, a) || is_one_of(removed, b)) continue;
    made.pairs.push_back(old.pairs[k]), made.old_rows.push_back(static_cast<std::int32_t>(k));
    const bool is_changed = is_one_of(changed, a) || is_one_of(changed, b);
    cell.unreachable.push_back(is_changed ? 0 : old.unreachable[k]);
  }
  for (const auto& pair : added) {
    made.pairs.push_back(pair), made.old_rows.push_back(-1), cell.unreachable.push_back(0);
  }
  cell.pairs = made.pairs;
  const ChainedTable& whole = old.has_limits ? old.all : old.within_limits;
  const auto table = [&](Table which) {
    const Rows rows = rows_of(cell, which);
    ChainedTable out = chained(cell, whole, old.pairs.size(), made, rows);
    out.touching = touching(cell, whole, made, changed, rows);
    return out;
  };
  cell.within_limits = table(Table::kWithinLimits);
  if (cell.has_limits) cell.all = table(Table::kAll);
  cell.in_cells = in_cells(old, cell, made);
  return cell;
}

PreparedCell with_new(const PreparedCell& old, PreparedCell cell, const Edit& edit) {
  const auto body = static_cast<std::int32_t>(cell.bodies.size());
  cell.bodies.push_back({shape_of(edit, old.obstacle_padding), -1, edit.pose});
  cell.body_names.push_back(edit.name);
  cell.paddings.push_back(cell.obstacle_padding);
  cell.has_own_pose.push_back(0);
  std::vector<std::array<std::int32_t, 2>> added;
  for (std::size_t k = 0; k < old.meets_obstacles.size(); ++k) {
    if (old.meets_obstacles[k] != 0) added.push_back({static_cast<std::int32_t>(k), body});
  }
  return with_pairs(old, std::move(cell), {}, {body}, added);
}

}  // namespace

PreparedCell edited(const PreparedCell& old, const Edit& edit) {
  check_edit(edit);
  const Rows bodies = bodies_of(old, edit.name);
  PreparedCell cell = old;
  const bool is_shape = edit.kind == Edit::Kind::kHull || edit.kind == Edit::Kind::kCloud;
  if (bodies.empty()) {
    if (!is_shape) refuse_name(old, edit.name);
    return with_new(old, std::move(cell), edit);
  }
  if (edit.kind == Edit::Kind::kRemove) {
    for (const std::int32_t body : bodies) cell.bodies[at(body)].body = nullptr, cell.body_names[at(body)].clear();
    return with_pairs(old, std::move(cell), bodies, {}, {});
  }
  if (bodies.size() > 1) {
    throw EditError("obstacle '" + edit.name + "' has " + std::to_string(bodies.size()) +
                    " bodies: one pose places only one");
  }
  const std::size_t body = at(bodies[0]);
  if (is_shape) {
    cell.bodies[body].body = shape_of(edit, cell.paddings[body]), cell.has_own_pose[body] = 0;
  } else if (cell.has_own_pose[body] != 0) {
    throw EditError("obstacle '" + edit.name +
                    "' has a shape with a pose of its own: replace it, or move it in Python and save the cell again");
  }
  cell.bodies[body].placement = edit.pose;
  return with_pairs(old, std::move(cell), {}, bodies, {});
}

}  // namespace plannercheck
