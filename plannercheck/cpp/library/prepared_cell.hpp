// A prepared cell: all that the core's checkers and certifiers of one robot in one scene are made of.
//
// In: the sections of a file (plannercheck/motions/prepared_cell.py writes them). Out: `PreparedCell`. Every index,
// length and pose that the core relies on is checked here, so that a hostile file may give wrong verdicts, but leads no
// query out of its memory. This header is free of lanes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "broad_phase/apart_cells.hpp"
#include "broad_phase/geometry_object.hpp"
#include "broad_phase/sampled_poses.hpp"
#include "distances/point_rates.hpp"
#include "library/cell_file.hpp"
#include "motions/motion_certifier.hpp"
#include "robots/kinematics.hpp"

namespace plannercheck {

// Which pairs judge: within the limits those that can meet there, beyond them all.
enum class Table { kWithinLimits, kAll };

// Some pairs of a cell, and the chains of joints between their bodies, as the certifier of motions takes them.
struct ChainedTable {
  std::vector<CertifiedPair> pairs;  // that move relative to each other; indices into all bodies
  std::vector<std::int32_t> rows;    // theirs in the cell's pairs
  MotionChains chains;
  std::vector<std::array<std::int32_t, 2>> from_world;  // bodies that meet added obstacles, and chains from the world
  std::vector<std::int32_t> touching;  // pairs that never move relative to each other and touch, by their rows
};

// How an obstacle that an edit adds is tested (plannercheck/motions/added_obstacles.py).
struct AddedObstacle {
  std::string name;                                // "" of all others
  std::vector<double> paddings;                    // of its body and each copy, m
  std::vector<std::array<std::int32_t, 2>> pairs;  // of the robot's bodies with these
};

struct PreparedCell {
  std::string about, robot, scene;
  std::vector<std::string> joint_names, link_names, body_names;  // of each body its link or obstacle
  std::string columns;                                           // says in words which joint takes which

  std::vector<double> lower, upper;                             // (nq)
  double largest_value = 0;                                     // of a configuration's numbers
  std::vector<std::pair<std::size_t, std::size_t>> unit_parts;  // first and past columns of unit vectors
  double unit_tolerance = 0;
  Tangent tangent;
  std::vector<std::size_t> turning_columns;  // whose whole turns change no pose
  // Between these, the poses of motions err by at most `kinematic_error`, m.
  std::vector<double> usual_low, usual_high;
  double kinematic_error = 0;

  std::vector<JointSpec> joints;
  std::vector<LinkSpec> links;
  std::shared_ptr<const SampledPoses> sampled;

  std::vector<double> paddings;         // of each body, m: the part of its inflation radius
  std::vector<GeometryObject> bodies;   // without a body where no pair needs it
  std::vector<Pose> own_poses;          // of each body: its shape's in its obstacle
  std::vector<std::string> part_names;  // of each body: its own, if it is a part of an object
  std::size_t robot_bodies = 0;         // so many come first
  std::vector<std::string> obstacles;   // in the order in which they were added
  std::vector<AddedObstacle> added;     // of any name first; none where bodies stand in for others
  std::vector<std::array<std::int32_t, 2>> pairs;
  std::vector<std::uint8_t> unreachable;  // by pair
  bool has_limits = false;                // whether the unreachable pairs are left out within the limits
  std::vector<PairsInCells> in_cells;     // of the pairs that are reachable, by their places among these

  MotionModel motion;  // without bodies, pairs and chains, but for the joints of these
  ChainedTable within_limits;
  ChainedTable all;  // none unless `has_limits`

  std::size_t width() const { return lower.size(); }
  const ChainedTable& chained(Table table) const { return table == Table::kAll && has_limits ? all : within_limits; }
};

// The rows of a cell's pairs that are in a table, ascending.
std::vector<std::int32_t> rows_of(const PreparedCell& cell, Table table);

// Throws CellError; HullError or PartSetError for a body.
PreparedCell read_cell(CellFile& file);

// The parts of it, in their order.
void read_bodies(CellFile& file, PreparedCell& cell);
void read_added(CellFile& file, PreparedCell& cell);
void read_pairs(CellFile& file, PreparedCell& cell);
void read_motions(CellFile& file, PreparedCell& cell);

// The largest defect of a body's placement (plannercheck/bodies/shapes.py).
inline constexpr double kRigidTolerance = 1e-6;

// Whether a link, or an object that a link carries, has this name.
bool is_link(const PreparedCell& cell, const std::string& name);
bool is_carried(const PreparedCell& cell, const std::string& name);

// What is checked of numbers.
bool are_finite(std::span<const double> numbers);
bool is_index(std::int32_t index, std::size_t end);          // 0 … end − 1
bool is_index_or_none(std::int32_t index, std::size_t end);  // −1 as well
bool is_coordinate(double x);                                // m, finite
bool is_radius(double x);                                    // m, at least 0
bool is_placement(const Pose& pose);                         // rigid, as far as bodies need it

}  // namespace plannercheck
