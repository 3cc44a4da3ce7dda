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

constexpr const char* kTooLarge = "coordinates must be at most 1e+50 m in size";

using Matrix = std::array<double, 16>;

Pose pose_of(const Matrix& m) {
  Pose pose;
  std::copy_n(m.begin(), pose.m.size(), pose.m.begin());
  return pose;
}

Matrix matrix_of(const Pose& pose) {
  Matrix m{};
  std::copy(pose.m.begin(), pose.m.end(), m.begin());
  m.back() = 1;
  return m;
}

// The bodies of an obstacle; the robot's have copies beside obstacles', whose padding is another one.
Rows bodies_of(const PreparedCell& cell, const std::string& name) {
  Rows found;
  if (std::find(cell.obstacles.begin(), cell.obstacles.end(), name) == cell.obstacles.end()) return found;
  for (std::size_t k = cell.robot_bodies; k < cell.bodies.size(); ++k) {
    if (cell.body_names[k] == name && cell.bodies[k].link < 0) found.push_back(static_cast<std::int32_t>(k));
  }
  return found;
}

// As `checked_pose` of plannercheck/bodies/shapes.py does.
void check_pose(const std::string& name, const Matrix& m) {
  const std::string what = "pose of object '" + name + "'";
  const std::span<const double> rows(m);
  if (!are_finite(rows))
    throw EditError(what + " has values that are not finite: [" + listed(rows.first(4)) + ", " +
                    listed(rows.subspan(4, 4)) + ", " + listed(rows.subspan(8, 4)) + ", " + listed(rows.last(4)) + "]");
  if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1) {
    const bool is_transposed = m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1;
    throw EditError(what + ": last row must be 0 0 0 1, not " + listed(rows.last(4)) +
                    (is_transposed ? "; it looks transposed" : ""));
  }
  const Pose pose = pose_of(m);
  const double defect = rigidity_defect(pose);
  if (!(defect <= kRigidTolerance))
    throw EditError(what + " is not rigid: |M^T M - 1| is " +
                    (std::isfinite(defect) ? rounded(defect, 3) : std::string("inf")) + ", accepted is " +
                    rounded(kRigidTolerance, 6));
  if (!is_placement(pose)) throw EditError(what + " is a reflection: det M is -1, a rotation has +1");
}

void check_radius(const Edit& edit) {
  if (edit.kind != Edit::Kind::kCloud) {
    if (edit.radius < 0 || !std::isfinite(edit.radius))
      throw EditError("sphere radius must be finite and not negative (m), not " + shown(edit.radius));
    return;
  }
  if (!(edit.radius > 0 && std::isfinite(edit.radius)))
    throw EditError("radius of a cloud must be finite and above 0 (m), not " + shown(edit.radius));
  if (!is_radius(edit.radius)) throw EditError(std::string("radius of a cloud: ") + kTooLarge);
}

bool is_in_range(Vec3 point) { return is_coordinate(point.x) && is_coordinate(point.y) && is_coordinate(point.z); }

// What Python's shapes check when they are made.
void check_shape(const Edit& edit) {
  const bool is_cloud = edit.kind == Edit::Kind::kCloud;
  const std::string what = is_cloud ? "points of a cloud: " : "hull vertices: ";
  check_radius(edit);
  for (std::size_t row = 0; row < edit.points.size(); ++row) {
    const std::array<double, 3> point{edit.points[row].x, edit.points[row].y, edit.points[row].z};
    if (!are_finite(point))
      throw EditError(what + "row " + std::to_string(row) + " is " + listed(point) + (is_cloud ? ":" : ",") +
                      " coordinates must be finite");
  }
  if (is_cloud && !std::all_of(edit.points.begin(), edit.points.end(), is_in_range)) throw EditError(what + kTooLarge);
}

void check_not_carried(const PreparedCell& cell, const std::string& name) {
  if (is_carried(cell, name))
    throw EditError("object '" + name + "' is attached to a link: change it in Python, and save the cell again");
}

// What Python's scene checks of the name, before and after the pose.
void check_name(const PreparedCell& cell, const Edit& edit) {
  const std::string what = "object '" + edit.name + "'";
  if (edit.name.empty()) throw EditError(what + " needs a name and at least one shape");
  check_pose(edit.name, edit.matrix);
  check_not_carried(cell, edit.name);
  for (std::size_t k = 0; k < cell.bodies.size(); ++k) {
    if (cell.part_names[k] == edit.name && cell.body_names[k] != edit.name)
      throw EditError(what + ": another object is named '" + edit.name + "', as its part would be");
  }
}

void check_edit(const PreparedCell& cell, const Edit& edit) {
  const bool is_added = edit.kind == Edit::Kind::kHull || edit.kind == Edit::Kind::kCloud;
  if (is_added) {
    check_shape(edit), check_name(cell, edit);
  } else {
    check_not_carried(cell, edit.name);
    if (bodies_of(cell, edit.name).empty()) throw EditError(unknown_name("object", edit.name, cell.obstacles));
    if (edit.kind == Edit::Kind::kMove) check_pose(edit.name, edit.matrix);
  }
  if (cell.added.empty())
    throw EditError("a checker with stand-ins for its bodies can't take another scene: build a new one");
  if (is_added && is_link(cell, edit.name))
    throw EditError("object '" + edit.name + "' has the name of a link of '" + cell.robot +
                    "', so what the scene allows the link would hold for the object: rename the object");
}

// As `core_polytope` of plannercheck/bodies/core_polytopes.py makes it.
Polytope hull_of(const Edit& edit, double radius) {
  const std::string what = "body '" + edit.name + "'";
  if (!std::all_of(edit.points.begin(), edit.points.end(), is_in_range)) throw EditError(what + ": " + kTooLarge);
  if (!is_radius(radius))
    throw EditError(what + ": inflation radius must be a length in m of at least 0, not " + shown(radius));
  try {
    Polytope body = prepare_polytope(edit.points);
    body.inflation_radius = radius;
    return body;
  } catch (const HullError& error) {
    throw EditError(what + " (" + std::to_string(edit.points.size()) +
                    " points) has no hull to work with: " + error.what());
  }
}

std::shared_ptr<const Polytope> shape_of(const Edit& edit, double padding) {
  if (edit.kind == Edit::Kind::kHull) return std::make_shared<Polytope>(hull_of(edit, edit.radius + padding));
  std::vector<double> numbers;
  for (const Vec3& p : edit.points) numbers.insert(numbers.end(), {p.x, p.y, p.z});
  auto set = std::make_shared<PartSet>(PartSet::balls(numbers.data(), edit.points.size(), &edit.radius, true));
  return std::make_shared<Polytope>(polytope_around(std::move(set), padding));
}

bool is_one_of(const Rows& bodies, std::int32_t body) {
  return std::find(bodies.begin(), bodies.end(), body) != bodies.end();
}

// The pairs of the new cell: the row in the old cell, or −1 and the pair's chains.
struct NewPairs {
  std::vector<std::array<std::int32_t, 2>> pairs;
  Rows old_rows;
  std::vector<CertifiedPair> chains;
};

// The place of each of the cell's rows among a table's pairs, or −1.
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

// How far from the world's origin a link may be within the limits, m.
double reach_of(const PreparedCell& cell) {
  double reach = cell.motion.extent;
  for (std::size_t k = 0; k < cell.width(); ++k) {
    const double travel = cell.motion.travel[k];
    if (travel > 0) reach += travel * std::max(std::fabs(cell.lower[k]), std::fabs(cell.upper[k]));
  }
  return reach;
}

// Whether a body of the robot never meets an obstacle within the limits: twice the lengths are above all rounding.
bool is_out_of_reach(const GeometryObject& own, const GeometryObject& obstacle, double reach) {
  if (!obstacle.body->traits().is_bounded) return false;
  for (const GeometryObject* object : {&own, &obstacle})
    reach += object->body->origin_radius + object->body->inflation_radius;
  const double distance = norm(obstacle.placement.translation());
  return std::isfinite(distance) && distance > 2 * (reach + norm(own.placement.translation())) + 1;
}

// The cell with bodies of which some have changed; pairs of `removed` bodies go, `added` come.
PreparedCell with_pairs(const PreparedCell& old, PreparedCell cell, const Rows& removed, const Rows& changed,
                        const std::vector<CertifiedPair>& added) {
  NewPairs made;
  const double reach = reach_of(cell);
  const auto is_unreachable = [&](std::int32_t own, std::int32_t obstacle) {
    return is_out_of_reach(cell.bodies[at(own)], cell.bodies[at(obstacle)], reach) ? std::uint8_t{1} : std::uint8_t{0};
  };
  cell.unreachable.clear();
  for (std::size_t k = 0; k < old.pairs.size(); ++k) {
    const auto& [a, b] = old.pairs[k];
    if (is_one_of(removed, a) || is_one_of(removed, b)) continue;
    made.pairs.push_back(old.pairs[k]), made.old_rows.push_back(static_cast<std::int32_t>(k));
    made.chains.push_back({});
    cell.unreachable.push_back(is_one_of(changed, a)   ? is_unreachable(b, a)
                               : is_one_of(changed, b) ? is_unreachable(a, b)
                                                       : old.unreachable[k]);
  }
  for (const CertifiedPair& pair : added) {
    made.pairs.push_back({pair.a, pair.b}), made.chains.push_back(pair);
    made.old_rows.push_back(-1), cell.unreachable.push_back(is_unreachable(pair.a, pair.b));
  }
  cell.pairs = made.pairs;
  cell.has_limits |= std::find(cell.unreachable.begin(), cell.unreachable.end(), 1) != cell.unreachable.end();
  const ChainedTable& whole = old.chained(Table::kAll);
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

// A body without a name: one that was removed, or one more.
std::int32_t free_body(PreparedCell& cell) {
  const auto first = cell.body_names.begin() + static_cast<std::ptrdiff_t>(cell.robot_bodies);
  const auto found = std::find_if(first, cell.body_names.end(), [&](const std::string& name) {
    return name.empty() && cell.bodies[static_cast<std::size_t>(&name - cell.body_names.data())].link < 0;
  });
  const auto body = static_cast<std::size_t>(found - cell.body_names.begin());
  if (body == cell.bodies.size()) {
    cell.bodies.push_back({}), cell.paddings.push_back(0), cell.own_poses.push_back({});
    cell.body_names.push_back({}), cell.part_names.push_back({});
  }
  return static_cast<std::int32_t>(body);
}

PreparedCell with_new(const PreparedCell& old, PreparedCell cell, const Edit& edit) {
  const auto by_name = std::find_if(old.added.begin(), old.added.end(),
                                    [&](const AddedObstacle& each) { return each.name == edit.name; });
  const AddedObstacle& as = by_name == old.added.end() ? old.added.front() : *by_name;
  Rows bodies;
  for (const double padding : as.paddings) {
    const std::int32_t body = free_body(cell);
    bodies.push_back(body);
    cell.bodies[at(body)] = {shape_of(edit, padding), -1, pose_of(edit.matrix)};
    cell.body_names[at(body)] = edit.name;
    cell.paddings[at(body)] = padding;
  }
  cell.obstacles.push_back(edit.name);
  const auto& from_world = old.chained(Table::kAll).from_world;
  std::vector<CertifiedPair> added;
  for (const auto& [meeting, which] : as.pairs) {
    const auto chain = std::find_if(from_world.begin(), from_world.end(),
                                    [body = meeting](const auto& each) { return each[0] == body; });
    added.push_back({meeting, bodies[at(which)], -1, chain == from_world.end() ? -1 : chain->at(1), -1});
  }
  return with_pairs(old, std::move(cell), {}, bodies, added);
}

PreparedCell without(const PreparedCell& old, PreparedCell cell, const std::string& name, const Rows& bodies) {
  std::erase(cell.obstacles, name);
  for (const std::int32_t body : bodies) {
    cell.bodies[at(body)].body = nullptr, cell.own_poses[at(body)] = {};
    cell.body_names[at(body)].clear(), cell.part_names[at(body)].clear();
  }
  return with_pairs(old, std::move(cell), bodies, {}, {});
}

}  // namespace

PreparedCell edited(const PreparedCell& old, const Edit& edit) {
  check_edit(old, edit);
  const Rows bodies = bodies_of(old, edit.name);
  PreparedCell cell = old;
  if (edit.kind == Edit::Kind::kRemove) return without(old, std::move(cell), edit.name, bodies);
  if (edit.kind != Edit::Kind::kMove) {
    if (bodies.empty()) return with_new(old, std::move(cell), edit);
    const PreparedCell removed = without(old, std::move(cell), edit.name, bodies);
    return with_new(removed, removed, edit);
  }
  for (const std::int32_t body : bodies) {
    const Pose posed = placed_on(pose_of(edit.matrix).m, cell.own_poses[at(body)]);
    check_pose(edit.name, matrix_of(posed));
    cell.bodies[at(body)].placement = posed;
  }
  return with_pairs(old, std::move(cell), {}, bodies, {});
}

}  // namespace plannercheck
