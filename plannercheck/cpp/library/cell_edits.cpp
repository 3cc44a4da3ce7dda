#include "library/cell_edits.hpp"

#include <algorithm>
#include <cmath>

#include "library/shown_values.hpp"
#include "narrow_phase/distance.hpp"

namespace plannercheck {
namespace {

using Rows = std::vector<std::int32_t>;

// Two bodies at rest that are further apart than this, m, are apart (plannercheck/motions/certifier_pairs.py).
constexpr double kPermanentGap = 1e-9;

bool is_link(const PreparedCell& cell, const std::string& name) {
  return std::find(cell.link_names.begin(), cell.link_names.end(), name) != cell.link_names.end();
}

// Whether a link carries an object of this name.
bool is_carried(const PreparedCell& cell, const std::string& name) {
  const auto past = cell.body_names.begin() + static_cast<std::ptrdiff_t>(cell.meets_obstacles.size());
  return !is_link(cell, name) && std::find(cell.body_names.begin(), past, name) != past;
}

// The bodies of an obstacle; the robot's have copies beside obstacles', whose padding is another one.
Rows bodies_of(const PreparedCell& cell, const std::string& name) {
  Rows found;
  if (is_link(cell, name) || is_carried(cell, name)) return found;
  for (std::size_t k = cell.meets_obstacles.size(); k < cell.bodies.size(); ++k) {
    if (cell.body_names[k] == name && cell.bodies[k].link < 0) found.push_back(static_cast<std::int32_t>(k));
  }
  return found;
}

[[noreturn]] void refuse_name(const PreparedCell& cell, const std::string& name) {
  std::vector<std::string> known;
  for (std::size_t k = cell.meets_obstacles.size(); k < cell.bodies.size(); ++k) {
    const std::string& other = cell.body_names[k];  // empty once it is removed
    const Rows bodies = bodies_of(cell, other);
    if (!other.empty() && !bodies.empty() && at(bodies[0]) == k) known.push_back(other);
  }
  throw EditError(unknown_name("object", name, known));
}

void check_name(const PreparedCell& cell, const std::string& name) {
  if (name.empty()) throw EditError("object '' needs a name and at least one shape");
  if (is_link(cell, name))
    throw EditError("object '" + name + "' has the name of a link of '" + cell.robot +
                    "', so what the scene allows the link would hold for the object: rename the object");
  if (is_carried(cell, name))
    throw EditError("object '" + name + "' exists already: remove it first, or choose another name");
}

// As `checked_pose` of plannercheck/bodies/shapes.py does; the largest coordinate is the library's own limit.
void check_pose(const std::string& name, const Pose& pose) {
  const std::string what = "pose of object '" + name + "'";
  if (!are_finite(pose.m)) {
    const std::span<const double> m(pose.m);
    throw EditError(what + " has values that are not finite: [" + listed(m.first(4)) + ", " + listed(m.subspan(4, 4)) +
                    ", " + listed(m.last(4)) + ", [0.0, 0.0, 0.0, 1.0]]");
  }
  if (!std::all_of(pose.m.begin(), pose.m.end(), is_coordinate))
    throw EditError(what + ": coordinates must be at most 1e+50 m in size");
  const double defect = rigidity_defect(pose);
  if (!(defect <= kRigidTolerance))
    throw EditError(what + " is not rigid: |M^T M - 1| is " + rounded(defect, 3) + ", accepted is " +
                    rounded(kRigidTolerance, 6));
  if (!is_placement(pose)) throw EditError(what + " is a reflection: det M is -1, a rotation has +1");
}

void check_points(const Edit& edit) {
  const bool is_cloud = edit.kind == Edit::Kind::kCloud;
  const std::string what = is_cloud ? "points of a cloud: " : "hull vertices: ";
  if (edit.points.empty() && !is_cloud) throw EditError(what + "a body needs at least one point");
  for (std::size_t row = 0; row < edit.points.size(); ++row) {
    const std::array<double, 3> point{edit.points[row].x, edit.points[row].y, edit.points[row].z};
    if (!are_finite(point))
      throw EditError(what + "row " + std::to_string(row) + " is " + listed(point) + (is_cloud ? ":" : ",") +
                      " coordinates must be finite");
    if (!std::all_of(point.begin(), point.end(), is_coordinate))
      throw EditError((is_cloud ? what : "body '" + edit.name + "': ") + "coordinates must be at most 1e+50 m in size");
  }
}

void check_radius(const Edit& edit) {
  if (edit.kind == Edit::Kind::kCloud && !(edit.radius > 0 && std::isfinite(edit.radius)))
    throw EditError("radius of a cloud must be finite and above 0 (m), not " + shown(edit.radius));
  if (is_radius(edit.radius)) return;
  if (edit.kind == Edit::Kind::kCloud)
    throw EditError("radius of a cloud: coordinates must be at most 1e+50 m in size");
  if (edit.radius < 0 || !std::isfinite(edit.radius))
    throw EditError("sphere radius must be finite and not negative (m), not " + shown(edit.radius));
  throw EditError("body '" + edit.name + "': inflation radius must be a length in m of at least 0, not " +
                  shown(edit.radius));
}

void check_edit(const PreparedCell& cell, const Edit& edit) {
  if (!cell.takes_other_scenes)
    throw EditError("a checker with stand-ins for its bodies can't take another scene: build a new one");
  if (edit.kind == Edit::Kind::kRemove || edit.kind == Edit::Kind::kMove) {
    if (bodies_of(cell, edit.name).empty()) refuse_name(cell, edit.name);
    if (edit.kind == Edit::Kind::kMove) check_pose(edit.name, edit.pose);
    return;
  }
  check_name(cell, edit.name);
  check_points(edit), check_radius(edit);
  check_pose(edit.name, edit.pose);
}

Polytope hull_of(const Edit& edit) {
  try {
    return prepare_polytope(edit.points);
  } catch (const HullError& error) {
    throw EditError("body '" + edit.name + "': " + error.what());
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

// Of each pair of the new cell its row in the old one; or −1, and its chains.
struct NewPairs {
  std::vector<std::array<std::int32_t, 2>> pairs;
  Rows old_rows;
  std::vector<CertifiedPair> chains;
};

const ChainedTable& whole_table(const PreparedCell& cell) { return cell.has_limits ? cell.all : cell.within_limits; }

// Of each row of the cell its place among a table's pairs, or −1.
Rows places_in(const ChainedTable& table, std::size_t rows) {
  Rows place(rows, -1);
  for (std::size_t k = 0; k < table.rows.size(); ++k) place[at(table.rows[k])] = static_cast<std::int32_t>(k);
  return place;
}

// The chains between the bodies of rows of a new cell.
ChainedTable chained(const PreparedCell& cell, const ChainedTable& old, std::size_t old_rows, const NewPairs& made,
                     const Rows& rows) {
  ChainedTable out;
  out.chains = old.chains, out.from_world = old.from_world;
  const Rows place = places_in(old, old_rows);
  for (const std::int32_t row : rows) {
    const auto [a, b] = cell.pairs[at(row)];
    if (cell.bodies[at(a)].link < 0 && cell.bodies[at(b)].link < 0) continue;
    const std::int32_t old_row = made.old_rows[at(row)];
    out.pairs.push_back(old_row >= 0 ? old.pairs[at(place[at(old_row)])] : made.chains[at(row)]);
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
                        const std::vector<CertifiedPair>& added) {
  NewPairs made;
  cell.unreachable.clear();
  for (std::size_t k = 0; k < old.pairs.size(); ++k) {
    const auto& [a, b] = old.pairs[k];
    if (is_one_of(removed, a) || is_one_of(removed, b)) continue;
    made.pairs.push_back(old.pairs[k]), made.old_rows.push_back(static_cast<std::int32_t>(k));
    made.chains.push_back({});
    const bool is_changed = is_one_of(changed, a) || is_one_of(changed, b);
    cell.unreachable.push_back(is_changed ? 0 : old.unreachable[k]);
  }
  for (const CertifiedPair& pair : added) {
    made.pairs.push_back({pair.a, pair.b}), made.chains.push_back(pair);
    made.old_rows.push_back(-1), cell.unreachable.push_back(0);
  }
  cell.pairs = made.pairs;
  const ChainedTable& whole = whole_table(old);
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

// Gives a body of an obstacle the shape of an edit.
void put_shape(PreparedCell& cell, std::int32_t body, const Edit& edit) {
  cell.bodies[at(body)] = {shape_of(edit, cell.paddings[at(body)]), -1, edit.pose};
  cell.body_names[at(body)] = edit.name;
  cell.own_poses[at(body)] = {};
}

PreparedCell with_new(const PreparedCell& old, PreparedCell cell, const Edit& edit) {
  const auto body = static_cast<std::int32_t>(cell.bodies.size());
  cell.bodies.push_back({}), cell.body_names.push_back({}), cell.own_poses.push_back({});
  cell.paddings.push_back(cell.obstacle_padding);
  put_shape(cell, body, edit);
  const auto& from_world = whole_table(old).from_world;
  std::vector<CertifiedPair> added;
  for (std::size_t k = 0; k < old.meets_obstacles.size(); ++k) {
    if (old.meets_obstacles[k] == 0) continue;
    const auto meeting = static_cast<std::int32_t>(k);
    const auto chain =
        std::find_if(from_world.begin(), from_world.end(), [&](const auto& each) { return each[0] == meeting; });
    added.push_back({meeting, body, -1, chain == from_world.end() ? -1 : chain->at(1), -1});
  }
  return with_pairs(old, std::move(cell), {}, {body}, added);
}

PreparedCell without(const PreparedCell& old, PreparedCell cell, const std::string& name, const Rows& bodies) {
  const ChainedTable& whole = whole_table(old);
  const Rows place = places_in(whole, old.pairs.size());
  RemovedObstacle removed{name, bodies, {}};
  for (std::size_t row = 0; row < old.pairs.size(); ++row) {
    const auto& [a, b] = old.pairs[row];
    const bool is_first = is_one_of(bodies, a);
    if (is_first == is_one_of(bodies, b)) continue;
    const CertifiedPair at_rest{is_first ? b : a, is_first ? a : b, -1, -1, -1};
    removed.pairs.push_back(place[row] < 0 ? at_rest : whole.pairs[at(place[row])]);
  }
  cell.removed.push_back(std::move(removed));
  for (const std::int32_t body : bodies) cell.bodies[at(body)].body = nullptr, cell.body_names[at(body)].clear();
  return with_pairs(old, std::move(cell), bodies, {}, {});
}

// With an obstacle that was removed before, of one shape: a body for each padding, and what these met.
PreparedCell with_again(const PreparedCell& old, PreparedCell cell, const Edit& edit, const RemovedObstacle& removed) {
  const auto first_alike = [&](std::int32_t body) {
    return *std::find_if(removed.bodies.begin(), removed.bodies.end(),
                         [&](std::int32_t each) { return cell.paddings[at(each)] == cell.paddings[at(body)]; });
  };
  Rows bodies;
  for (const std::int32_t body : removed.bodies) {
    if (first_alike(body) != body) continue;
    bodies.push_back(body), put_shape(cell, body, edit);
  }
  std::vector<CertifiedPair> added;
  for (CertifiedPair pair : removed.pairs) {
    if (cell.bodies[at(pair.a)].body == nullptr) continue;  // only a hostile file pairs obstacles
    pair.b = first_alike(pair.b);
    const bool is_known = std::any_of(added.begin(), added.end(),
                                      [&](const CertifiedPair& each) { return each.a == pair.a && each.b == pair.b; });
    if (!is_known) added.push_back(pair);
  }
  std::erase_if(cell.removed, [&](const RemovedObstacle& each) { return each.name == edit.name; });
  return with_pairs(old, std::move(cell), {}, bodies, added);
}

}  // namespace

PreparedCell edited(const PreparedCell& old, const Edit& edit) {
  check_edit(old, edit);
  const Rows bodies = bodies_of(old, edit.name);
  PreparedCell cell = old;
  if (edit.kind == Edit::Kind::kHull || edit.kind == Edit::Kind::kCloud) {
    if (!bodies.empty()) return edited(without(old, std::move(cell), edit.name, bodies), edit);
    for (const RemovedObstacle& removed : old.removed) {
      if (removed.name == edit.name) return with_again(old, std::move(cell), edit, removed);
    }
    return with_new(old, std::move(cell), edit);
  }
  if (edit.kind == Edit::Kind::kRemove) return without(old, std::move(cell), edit.name, bodies);
  for (const std::int32_t body : bodies) {
    cell.bodies[at(body)].placement = placed_on(edit.pose.m, cell.own_poses[at(body)]);
    check_pose(edit.name, cell.bodies[at(body)].placement);
  }
  return with_pairs(old, std::move(cell), {}, bodies, {});
}

}  // namespace plannercheck
