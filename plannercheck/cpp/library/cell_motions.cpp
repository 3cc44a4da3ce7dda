// The joints, chains and pairs of a prepared cell's motions (plannercheck/motions/robot_chains.py makes them).
#include <algorithm>
#include <cmath>
#include <iterator>

#include "library/prepared_cell.hpp"

namespace plannercheck {
namespace {

void read_drives(CellFile& file, PreparedCell& cell) {
  const auto drives = file.integers("drives", 2);
  const auto factors = file.doubles("factors", 2);
  require_sound(factors.size() == drives.size() && are_finite(factors), "drives");
  for (std::size_t k = 0; k < drives.size(); k += 2) {
    require_sound(drives[k] >= 0 && drives[k] <= static_cast<std::int32_t>(DriveKind::kPart), "a drive's kind");
    require_sound(is_index_or_none(drives[k + 1], cell.width()), "a drive's column");
    cell.motion.chains.joints.push_back({static_cast<DriveKind>(drives[k]), drives[k + 1], factors[k], factors[k + 1]});
  }
}

// Also that a joint which a part drives begins where a part does.
void read_parts(CellFile& file, PreparedCell& cell) {
  const auto parts = file.integers("parts", 2);
  std::vector<bool> begins(cell.width(), false), covered(cell.width(), false);
  for (std::size_t k = 0; k < parts.size(); k += 2) {
    require_sound(parts[k] >= 0 && parts[k] <= static_cast<std::int32_t>(PartKind::kFree), "a part's kind");
    const PathPart part{static_cast<PartKind>(parts[k]), parts[k + 1]};
    const std::size_t columns = part.width();
    require_sound(part.column >= 0 && at(part.column) + columns <= cell.width(), "a part's columns");
    for (std::size_t c = at(part.column); c < at(part.column) + columns; ++c) {
      require_sound(!covered[c], "a part's columns");
      covered[c] = true;
    }
    begins[at(part.column)] = true;
    cell.motion.parts.push_back(part);
  }
  for (const JointDrive& drive : cell.motion.chains.joints) {
    if (drive.kind == DriveKind::kPart) {
      require_sound(drive.column >= 0 && begins[at(drive.column)], "a drive's part");
    }
  }
}

void read_numbers(CellFile& file, PreparedCell& cell) {
  MotionModel& model = cell.motion;
  model.defect = file.number("defect"), model.leverage = file.number("leverage"), model.depth = file.number("depth");
  model.extent = file.number("extent"), model.joints = file.number("most joints");
  for (const double each : {model.defect, model.leverage, model.depth, model.extent, model.joints})
    require_sound(each >= 0 && std::isfinite(each), "a bound of the robot's motions");
  const auto travel = file.doubles("travel");
  require_sound(travel.size() == cell.width() && are_finite(travel) &&
                    std::all_of(travel.begin(), travel.end(), [](double each) { return each >= 0; }),
                "travel");
  model.travel.assign(travel.begin(), travel.end());
  model.width = static_cast<std::int32_t>(cell.width()), model.links = static_cast<std::int32_t>(cell.links.size());
}

MotionChains read_chains(CellFile& file, const std::vector<JointDrive>& joints) {
  const auto first_entry = file.integers("first entry"), entries = file.integers("entries", 3);
  const auto arms = file.doubles("arms");
  const auto slides = file.integers("slides");
  MotionChains out;
  out.joints = joints;
  require_sound(!first_entry.empty() && first_entry[0] == 0 && std::is_sorted(first_entry.begin(), first_entry.end()) &&
                    at(first_entry.back()) == arms.size() && entries.size() == 3 * arms.size(),
                "chains");
  out.first_entry.assign(first_entry.begin(), first_entry.end());
  for (const std::int32_t joint : slides) require_sound(is_index(joint, joints.size()), "a chain's slides");
  out.slides.assign(slides.begin(), slides.end());
  for (std::size_t e = 0; e < arms.size(); ++e) {
    const std::int32_t joint = entries[3 * e], first = entries[3 * e + 1], past = entries[3 * e + 2];
    require_sound(is_index(joint, joints.size()), "a chain's joint");
    require_sound(first >= 0 && first <= past && at(past) <= slides.size(), "a chain's slides");
    require_sound(arms[e] >= 0 && std::isfinite(arms[e]), "a chain's arm");
    out.entries.push_back({joint, arms[e], first, past});
  }
  return out;
}

// `rows`: the pairs of the table. The chained pairs are the ones that move relative to each other, in this order.
ChainedTable read_table(CellFile& file, const PreparedCell& cell, const std::vector<std::int32_t>& rows) {
  ChainedTable out;
  const auto pairs = file.integers("chained pairs", 5), from_world = file.integers("from world", 2);
  const auto moves = [&](std::int32_t row) {
    const auto& [a, b] = cell.pairs[at(row)];
    return cell.bodies[at(a)].link >= 0 || cell.bodies[at(b)].link >= 0;
  };
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(out.rows), moves);
  require_sound(pairs.size() == 5 * out.rows.size(), "chained pairs");
  out.chains = read_chains(file, cell.motion.chains.joints);
  const std::size_t chains = out.chains.first_entry.size() - 1;
  for (std::size_t k = 0; k < pairs.size(); k += 5) {
    const CertifiedPair pair{pairs[k], pairs[k + 1], pairs[k + 2], pairs[k + 3], pairs[k + 4]};
    const auto& [a, b] = cell.pairs[at(out.rows[k / 5])];
    require_sound((pair.a == a && pair.b == b) || (pair.a == b && pair.b == a), "a chained pair");
    require_sound(cell.bodies[at(pair.a)].link >= 0, "a chained pair");
    require_sound(is_index_or_none(pair.frame, cell.links.size()), "the frame of a pair");
    require_sound(is_index_or_none(pair.chain_a, chains) && is_index_or_none(pair.chain_b, chains), "a pair's chains");
    out.pairs.push_back(pair);
  }
  std::vector<std::int32_t> meeting;
  for (const AddedObstacle& added : cell.added) {
    for (const auto& [body, _] : added.pairs) {
      if (cell.bodies[at(body)].link >= 0) meeting.push_back(body);
    }
  }
  std::sort(meeting.begin(), meeting.end());
  meeting.erase(std::unique(meeting.begin(), meeting.end()), meeting.end());
  require_sound(from_world.size() == 2 * meeting.size(), "chains from the world");
  for (std::size_t k = 0; k < from_world.size(); k += 2) {
    require_sound(from_world[k] == meeting[k / 2] && is_index(from_world[k + 1], chains), "a chain from the world");
    out.from_world.push_back({from_world[k], from_world[k + 1]});
  }
  for (const std::int32_t row : file.integers("touching")) {
    require_sound(is_index(row, cell.pairs.size()), "touching pairs");
    out.touching.push_back(row);
  }
  return out;
}

}  // namespace

void read_motions(CellFile& file, PreparedCell& cell) {
  read_drives(file, cell);
  read_parts(file, cell);
  read_numbers(file, cell);
  cell.within_limits = read_table(file, cell, rows_of(cell, Table::kWithinLimits));
  if (cell.has_limits) cell.all = read_table(file, cell, rows_of(cell, Table::kAll));
}

}  // namespace plannercheck
