// The robot of a prepared cell; its bodies and pairs are read by cell_bodies.cpp, its motions by cell_motions.cpp.
#include "library/prepared_cell.hpp"

#include <algorithm>
#include <cmath>

namespace plannercheck {
namespace {

// The largest coordinate, m (plannercheck/bodies/core_polytopes.py).
constexpr double kLargestCoordinate = 1e50;

constexpr std::size_t kRigidNumbers = 12, kJointNumbers = 7;

// How far the length of a joint's axis may be from 1 (plannercheck/robots/kinematics.py).
constexpr double kAxisError = 1e-6;

// The largest defect of a single placement on a joint (plannercheck/robots/unit_lengths.py).
constexpr double kLinkDefect = 2.5e-6;

std::vector<double> numbers(std::span<const double> from) { return {from.begin(), from.end()}; }

Rigid rigid_at(std::span<const double> rows, std::size_t i) {
  Rigid rigid;
  Pose pose;
  std::copy_n(rows.data() + kRigidNumbers * i, kRigidNumbers, rigid.m);
  std::copy_n(rigid.m, kRigidNumbers, pose.m.begin());
  require_sound(are_finite(pose.m) && rigidity_defect(pose) <= kLinkDefect, "a placement on a joint");
  return rigid;
}

void read_names(CellFile& file, PreparedCell& cell) {
  cell.about = file.text("about"), cell.robot = file.text("robot"), cell.scene = file.text("scene");
  cell.joint_names = file.texts("joint names"), cell.link_names = file.texts("link names");
  cell.columns = file.text("described columns");
  cell.body_names = file.texts("body names"), cell.part_names = file.texts("part names");
}

// As ConfigurationMap.tangent_places in plannercheck/robots/configurations.py has it.
Tangent tangent_of(const PreparedCell& cell) {
  Tangent out;
  std::vector<bool> is_counted(cell.width(), true);
  for (const auto& [first, past] : cell.unit_parts) is_counted[past - 1] = false;
  for (const bool is : is_counted) out.places.push_back(static_cast<std::int32_t>(is ? ++out.width : out.width) - 1);
  for (const auto& [first, past] : cell.unit_parts) out.places[past - 1] = past - first == 2 ? out.places[first] : -1;
  return out;
}

void read_unit_parts(CellFile& file, PreparedCell& cell) {
  const auto columns = file.integers("unit columns", 2);
  for (std::size_t k = 0; k < columns.size(); k += 2) {
    require_sound(columns[k] >= 0 && columns[k] < columns[k + 1] && at(columns[k + 1]) <= cell.width(), "unit columns");
    cell.unit_parts.emplace_back(at(columns[k]), at(columns[k + 1]));
  }
  cell.tangent = tangent_of(cell);
  cell.unit_tolerance = file.number("unit tolerance");
  require_sound(cell.unit_tolerance >= 0 && cell.unit_tolerance < 1, "unit tolerance");
}

void read_configurations(CellFile& file, PreparedCell& cell) {
  cell.lower = numbers(file.doubles("lower")), cell.upper = numbers(file.doubles("upper"));
  require_sound(cell.lower.size() == cell.upper.size(), "limits");
  const auto is_number = [](double limit) { return !std::isnan(limit); };
  require_sound(std::all_of(cell.lower.begin(), cell.lower.end(), is_number) &&
                    std::all_of(cell.upper.begin(), cell.upper.end(), is_number),
                "limits");
  cell.largest_value = file.number("largest value");
  require_sound(cell.largest_value > 0 && std::isfinite(cell.largest_value), "largest value");
  read_unit_parts(file, cell);
  for (const std::int32_t column : file.integers("turning columns")) {
    require_sound(is_index(column, cell.width()), "turning columns");
    cell.turning_columns.push_back(at(column));
  }
  cell.usual_low = numbers(file.doubles("usual low")), cell.usual_high = numbers(file.doubles("usual high"));
  require_sound(cell.usual_low.size() == cell.width() && cell.usual_high.size() == cell.width() &&
                    are_finite(cell.usual_low) && are_finite(cell.usual_high),
                "the range of motions");
  cell.kinematic_error = file.number("kinematic error");
  require_sound(cell.kinematic_error >= 0 && std::isfinite(cell.kinematic_error), "kinematic error");
}

JointSpec joint_from(std::int32_t parent, std::int32_t kind, const double* axis, const Rigid& placement,
                     std::size_t index) {
  require_sound(is_index_or_none(parent, index), "a joint's parent");
  require_sound(kind >= 0 && kind <= static_cast<std::int32_t>(JointKind::kFree), "a joint's kind");
  JointSpec joint{parent, static_cast<JointKind>(kind), {axis[0], axis[1], axis[2]}, placement, {}};
  const double length = norm({axis[0], axis[1], axis[2]});
  const bool has_axis = joint.kind <= JointKind::kSlide;
  require_sound(has_axis ? std::fabs(length - 1) <= kAxisError : std::isfinite(length), "a joint's axis");
  return joint;
}

void read_joints(CellFile& file, PreparedCell& cell) {
  const auto parents = file.integers("parents"), kinds = file.integers("kinds");
  const auto axes = file.doubles("axes", 3), placements = file.doubles("placements", kRigidNumbers);
  const auto columns = file.integers("columns", kJointNumbers);
  const auto multipliers = file.doubles("multipliers", kJointNumbers), offsets = file.doubles("offsets", kJointNumbers);
  const std::size_t count = parents.size();
  require_sound(kinds.size() == count && axes.size() == 3 * count && placements.size() == kRigidNumbers * count &&
                    columns.size() == kJointNumbers * count && multipliers.size() == columns.size() &&
                    offsets.size() == columns.size() && are_finite(multipliers) && are_finite(offsets),
                "joints");
  for (std::size_t i = 0; i < count; ++i) {
    JointSpec joint = joint_from(parents[i], kinds[i], axes.data() + 3 * i, rigid_at(placements, i), i);
    for (std::size_t k = 0; k < kJointNumbers; ++k) {
      const std::size_t from = kJointNumbers * i + k;
      require_sound(is_index_or_none(columns[from], cell.width()), "a joint's columns");
      joint.values[k] = {columns[from], multipliers[from], offsets[from]};
    }
    cell.joints.push_back(joint);
  }
}

void read_links(CellFile& file, PreparedCell& cell) {
  const auto joints = file.integers("link joints");
  const auto placements = file.doubles("link placements", kRigidNumbers);
  require_sound(placements.size() == kRigidNumbers * joints.size() && cell.link_names.size() == joints.size(), "links");
  for (std::size_t i = 0; i < joints.size(); ++i) {
    require_sound(is_index_or_none(joints[i], cell.joints.size()), "a link's joint");
    cell.links.push_back({joints[i], rigid_at(placements, i)});
  }
}

void read_sampled_poses(CellFile& file, PreparedCell& cell) {
  constexpr std::size_t kPoseNumbers = 16;
  const auto poses = file.doubles("sampled poses", kPoseNumbers);
  const std::size_t of_state = kPoseNumbers * cell.links.size();
  require_sound(are_finite(poses) && (of_state == 0 ? poses.empty() : poses.size() % of_state == 0), "sampled poses");
  cell.sampled =
      std::make_shared<SampledPoses>(SampledPoses{numbers(poses), of_state == 0 ? 0 : poses.size() / of_state});
}

}  // namespace

bool is_link(const PreparedCell& cell, const std::string& name) {
  return std::find(cell.link_names.begin(), cell.link_names.end(), name) != cell.link_names.end();
}

bool is_carried(const PreparedCell& cell, const std::string& name) {
  const auto past = cell.body_names.begin() + static_cast<std::ptrdiff_t>(cell.robot_bodies);
  return !is_link(cell, name) && std::find(cell.body_names.begin(), past, name) != past;
}

bool are_finite(std::span<const double> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
}

bool is_index(std::int32_t index, std::size_t end) { return index >= 0 && at(index) < end; }

bool is_index_or_none(std::int32_t index, std::size_t end) { return index == -1 || is_index(index, end); }

bool is_coordinate(double x) { return std::fabs(x) <= kLargestCoordinate; }

bool is_radius(double x) { return x >= 0 && x <= kLargestCoordinate; }

bool is_placement(const Pose& pose) {
  const Vec3 x{pose.m[0], pose.m[1], pose.m[2]}, y{pose.m[4], pose.m[5], pose.m[6]},
      z{pose.m[8], pose.m[9], pose.m[10]};
  return are_finite(pose.m) && rigidity_defect(pose) <= kRigidTolerance && dot(cross(x, y), z) > 0;
}

std::vector<std::int32_t> rows_of(const PreparedCell& cell, Table table) {
  std::vector<std::int32_t> rows;
  for (std::size_t k = 0; k < cell.pairs.size(); ++k) {
    if (table == Table::kAll || cell.unreachable[k] == 0) rows.push_back(static_cast<std::int32_t>(k));
  }
  return rows;
}

PreparedCell read_cell(CellFile& file) {
  PreparedCell cell;
  read_names(file, cell);
  read_configurations(file, cell);
  read_joints(file, cell);
  read_links(file, cell);
  read_sampled_poses(file, cell);
  read_bodies(file, cell);
  read_added(file, cell);
  read_pairs(file, cell);
  read_motions(file, cell);
  file.end();
  return cell;
}

}  // namespace plannercheck
