// The bodies of a prepared cell, where they are, and the pairs of them that are tested.
//
// A hull has its hierarchies in the file (polytope_serialisation.cpp). Solids, sets of parts and half-spaces are
// prepared again from what they were made of, by the code that prepares them in Python.
#include <algorithm>
#include <cmath>

#include "bodies/half_space.hpp"
#include "library/prepared_cell.hpp"

namespace plannercheck {
namespace {

using Body = std::shared_ptr<const Polytope>;

// As files have them (plannercheck/motions/prepared_cell.py).
enum class BodyKind : std::int32_t { kHull, kSolid, kBalls, kCells, kColumns, kHalfSpace, kLast = kHalfSpace };

bool are_coordinates(std::span<const double> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), is_coordinate);
}

double read_inflation(CellFile& file) {
  const double radius = file.number("inflation radius");
  require_sound(is_radius(radius), "an inflation radius");
  return radius;
}

Polytope read_hull(CellFile& file) {
  const auto data = file.bytes("hull");
  Polytope body = parse_polytope(reinterpret_cast<const char*>(data.data()), data.size());
  require_sound(is_radius(body.inflation_radius), "an inflation radius");
  for (const Vec3& p : body.inner.points) require_sound(is_coordinate(norm_max(p)), "a vertex");
  return body;
}

Polytope read_solid(CellFile& file) {
  const Polytope hull = read_hull(file);
  const auto numbers = file.doubles("points", 3);
  const auto corners = file.integers("triangles", 3);
  require_sound(are_coordinates(numbers), "a solid's points");
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < numbers.size(); i += 3) points.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  std::vector<MeshTriangle> triangles;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    for (const std::int32_t corner : triangles.back()) require_sound(is_index(corner, points.size()), "a triangle");
  }
  return with_solid(hull, std::make_shared<Solid>(prepare_solid(points, triangles)));
}

Polytope around(PartSet set, double inflation_radius) {
  return polytope_around(std::make_shared<PartSet>(std::move(set)), inflation_radius);
}

Polytope read_balls(CellFile& file) {
  const double inflation = read_inflation(file);
  const auto points = file.doubles("points", 3), radii = file.doubles("radii");
  const std::size_t count = points.size() / 3;
  require_sound(radii.size() == 1 || radii.size() == count, "a cloud's radii");
  require_sound(are_coordinates(points) && std::all_of(radii.begin(), radii.end(), is_radius), "a cloud's points");
  return around(PartSet::balls(points.data(), count, radii.data(), radii.size() == 1), inflation);
}

// Boxes of a lattice; the last key and size give the furthest corner.
Polytope read_cells(CellFile& file) {
  const double inflation = read_inflation(file);
  const auto keys = file.integers("keys", 3), sizes = file.integers("sizes");
  const auto lattice = file.doubles("lattice", 4);
  require_sound(keys.size() == 3 * sizes.size() && lattice.size() == 4, "cells of a map");
  require_sound(std::all_of(sizes.begin(), sizes.end(), [](std::int32_t size) { return size > 0; }), "a cell's size");
  constexpr double kSteps = 0x1p33;  // more than any key and size together
  require_sound(lattice[0] > 0 && is_coordinate(kSteps * lattice[0]) && are_coordinates(lattice), "a map's lattice");
  const Vec3 origin{lattice[1], lattice[2], lattice[3]};
  return around(PartSet::cells(keys.data(), sizes.data(), sizes.size(), lattice[0], origin), inflation);
}

Polytope read_columns(CellFile& file) {
  const double inflation = read_inflation(file);
  const CellFile::Table heights = file.table("heights");
  const auto lattice = file.doubles("lattice", 5);
  const auto is_height = [](double height) { return std::isnan(height) || is_coordinate(height); };
  require_sound(
      heights.rows > 1 && heights.columns > 1 && std::all_of(heights.numbers.begin(), heights.numbers.end(), is_height),
      "heights");
  const double longest = static_cast<double>(std::max(heights.rows, heights.columns));
  require_sound(lattice.size() == 5 && are_coordinates(lattice) && lattice[0] > 0 && lattice[1] > 0 &&
                    is_coordinate(longest * lattice[0]) && is_coordinate(longest * lattice[1]),
                "a lattice of heights");
  PartSet set = PartSet::columns(heights.numbers.data(), heights.rows, heights.columns, {lattice[0], lattice[1]},
                                 {lattice[2], lattice[3]}, lattice[4]);
  return around(std::move(set), inflation);
}

Polytope read_half_space(CellFile& file) {
  const double inflation = read_inflation(file);
  const auto numbers = file.doubles("half-space", 4);
  require_sound(numbers.size() == 4 && are_coordinates(numbers), "a half-space");
  const HalfSpace half_space{{numbers[0], numbers[1], numbers[2]}, numbers[3]};
  require_sound(norm_max(half_space.normal) >= 0.5 && norm_max(half_space.normal) <= 1, "a half-space's normal");
  return polytope_of(half_space, inflation);
}

Polytope read_shape(CellFile& file, BodyKind kind) {
  switch (kind) {
    case BodyKind::kHull:
      return read_hull(file);
    case BodyKind::kSolid:
      return read_solid(file);
    case BodyKind::kBalls:
      return read_balls(file);
    case BodyKind::kCells:
      return read_cells(file);
    case BodyKind::kColumns:
      return read_columns(file);
    default:
      return read_half_space(file);
  }
}

std::vector<Body> read_shapes(CellFile& file) {
  const auto kinds = file.integers("shape kinds");
  std::vector<Body> shapes;
  for (const std::int32_t kind : kinds) {
    require_sound(kind >= 0 && kind <= static_cast<std::int32_t>(BodyKind::kLast), "a body's kind");
    shapes.push_back(std::make_shared<Polytope>(read_shape(file, static_cast<BodyKind>(kind))));
  }
  return shapes;
}

Pose placement_at(std::span<const double> rows, std::size_t i) {
  Pose pose;
  std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(pose.m.size() * i), pose.m.size(), pose.m.begin());
  require_sound(is_placement(pose), "a body's placement");
  return pose;
}

bool is_half_space(const GeometryObject& object) { return object.body != nullptr && !object.body->traits().is_bounded; }

// Pairs of cells that are apart in cells of two columns: by their places among the pairs that are reachable.
PairsInCells read_cell_table(CellFile& file, std::size_t width, std::size_t reachable) {
  const auto columns = file.integers("cell columns");
  const auto lows = file.doubles("cell lows"), per_unit = file.doubles("cells per unit");
  const CellFile::Table flags = file.byte_table("may meet");
  const auto pairs = file.integers("cell pairs");
  require_sound(columns.size() == 2 && lows.size() == 2 && per_unit.size() == 2, "the columns of cells");
  require_sound(are_finite(lows) && are_finite(per_unit) && per_unit[0] >= 0 && per_unit[1] >= 0, "a range of cells");
  require_sound(pairs.size() == ApartCells::kMostPairs, "pairs in cells");
  std::array<CellsOfColumn, 2> of_columns;
  const std::array<std::size_t, 2> counts{flags.rows, flags.columns};
  for (std::size_t k = 0; k < 2; ++k) {
    require_sound(is_index(columns[k], width) && counts[k] >= 1 && counts[k] <= 1024, "the columns of cells");
    of_columns[k] = {at(columns[k]), lows[k], per_unit[k], static_cast<int>(counts[k])};
  }
  PairsInCells out;
  out.cells =
      std::make_shared<ApartCells>(of_columns, std::vector<std::uint8_t>(flags.bytes.begin(), flags.bytes.end()));
  for (std::size_t bit = 0; bit < pairs.size(); ++bit) {
    require_sound(is_index_or_none(pairs[bit], reachable), "pairs in cells");
    out.pairs[bit] = pairs[bit];
  }
  return out;
}

}  // namespace

void read_bodies(CellFile& file, PreparedCell& cell) {
  const std::vector<Body> shapes = read_shapes(file);
  const auto of_bodies = file.integers("shapes"), links = file.integers("links");
  const auto placements = file.doubles("body placements", 12);
  const auto own_poses = file.doubles("own poses", 12);
  const auto paddings = file.doubles("paddings");
  const std::size_t count = of_bodies.size();
  require_sound(links.size() == count && placements.size() == 12 * count && own_poses.size() == 12 * count &&
                    paddings.size() == count && cell.body_names.size() == count && cell.part_names.size() == count,
                "bodies");
  require_sound(std::all_of(paddings.begin(), paddings.end(), is_radius), "a padding");
  cell.paddings.assign(paddings.begin(), paddings.end());
  for (std::size_t i = 0; i < count; ++i) {
    require_sound(is_index_or_none(of_bodies[i], shapes.size()), "a body's shape");
    require_sound(is_index_or_none(links[i], cell.links.size()), "a body's link");
    cell.bodies.push_back(
        {of_bodies[i] < 0 ? nullptr : shapes[at(of_bodies[i])], links[i], placement_at(placements, i)});
    cell.own_poses.push_back(placement_at(own_poses, i));
    require_sound(!is_half_space(cell.bodies[i]) || links[i] < 0, "a half-space on a link");
  }
  const std::int32_t robot_bodies = file.integer("robot bodies");
  require_sound(robot_bodies >= 0 && at(robot_bodies) <= count, "the robot's bodies");
  cell.robot_bodies = at(robot_bodies);
  for (std::size_t i = cell.robot_bodies; i < count; ++i) {
    const std::string& name = cell.body_names[i];
    if (links[i] >= 0) continue;
    require_sound(!name.empty(), "an obstacle's name");
    const bool is_new = std::find(cell.obstacles.begin(), cell.obstacles.end(), name) == cell.obstacles.end();
    if (is_new && !is_link(cell, name) && !is_carried(cell, name)) cell.obstacles.push_back(name);
  }
}

void read_added(CellFile& file, PreparedCell& cell) {
  for (const std::string& name : file.texts("names of added")) cell.added.push_back({name, {}, {}});
  const auto owners = file.integers("added");
  const auto paddings = file.doubles("added paddings");
  require_sound(paddings.size() == owners.size() && std::all_of(paddings.begin(), paddings.end(), is_radius),
                "the paddings of obstacles that are added");
  std::vector<std::int32_t> places;  // of each body among those of its obstacle
  for (std::size_t k = 0; k < owners.size(); ++k) {
    require_sound(is_index(owners[k], cell.added.size()), "obstacles that are added");
    std::vector<double>& own = cell.added[at(owners[k])].paddings;
    places.push_back(static_cast<std::int32_t>(own.size()));
    own.push_back(paddings[k]);
  }
  for (const AddedObstacle& each : cell.added) require_sound(!each.paddings.empty(), "obstacles that are added");
  const auto pairs = file.integers("added pairs", 2);
  for (std::size_t k = 0; k < pairs.size(); k += 2) {
    const std::int32_t body = pairs[k], of_obstacle = pairs[k + 1];
    require_sound(is_index(body, cell.bodies.size()) && is_index(of_obstacle, owners.size()), "an added pair");
    const GeometryObject& object = cell.bodies[at(body)];
    require_sound(object.body != nullptr && (at(body) < cell.robot_bodies || object.link >= 0), "an added pair");
    cell.added[at(owners[at(of_obstacle)])].pairs.push_back({body, places[at(of_obstacle)]});
  }
}

void read_pairs(CellFile& file, PreparedCell& cell) {
  const auto bodies = file.integers("pairs", 2);
  const auto unreachable = file.bytes("unreachable");
  require_sound(unreachable.size() == bodies.size() / 2, "unreachable pairs");
  for (std::size_t i = 0; i < bodies.size(); i += 2) {
    for (const std::int32_t body : {bodies[i], bodies[i + 1]}) {
      require_sound(is_index(body, cell.bodies.size()) && cell.bodies[at(body)].body != nullptr, "a pair's body");
    }
    require_sound(bodies[i] != bodies[i + 1], "a pair's body");
    require_sound(!is_half_space(cell.bodies[at(bodies[i])]) || !is_half_space(cell.bodies[at(bodies[i + 1])]),
                  "a pair of half-spaces");
    cell.pairs.push_back({bodies[i], bodies[i + 1]});
  }
  cell.unreachable.assign(unreachable.begin(), unreachable.end());
  cell.has_limits = file.integer("has limits") != 0;
  const auto left_out = static_cast<std::size_t>(
      std::count_if(unreachable.begin(), unreachable.end(), [](std::uint8_t is) { return is != 0; }));
  require_sound(cell.has_limits || left_out == 0, "unreachable pairs");
  const std::int32_t tables = file.integer("cell tables");
  require_sound(tables >= 0 && (cell.has_limits || tables == 0), "cell tables");
  for (std::int32_t k = 0; k < tables; ++k) {
    cell.in_cells.push_back(read_cell_table(file, cell.width(), cell.pairs.size() - left_out));
  }
}

}  // namespace plannercheck
