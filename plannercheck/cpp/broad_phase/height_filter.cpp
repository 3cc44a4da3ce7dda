#include "broad_phase/height_filter.hpp"

#include <algorithm>
#include <limits>

#include "broad_phase/obstacle_tree.hpp"

namespace plannercheck {
namespace {

// Levels are chosen for radii longer by this part, and with room for centres as far away as the field, of which there
// are rounding errors by this part.
constexpr double kLongerRadius = 1.01, kFarCentre = 0x1p-16;

constexpr double kTiniest = 1e-37;  // what denormals lose

}  // namespace

bool HeightFilter::is_for(const GeometryObject& object) {
  return object.link < 0 && object.body->traits().has_parts &&
         object.body->as<PartSet>().kind() == PartSet::Kind::kColumns;
}

std::size_t HeightFilter::field_of(std::int32_t index, const GeometryObject& object) {
  const auto known = std::find_if(fields_.begin(), fields_.end(), [&](const Field& f) { return f.index == index; });
  if (known != fields_.end()) return static_cast<std::size_t>(known - fields_.begin());
  const PartSet& parts = object.body->as<PartSet>();
  const Pose& pose = object.placement;
  const Vec3 origin = pose.translation(), low = parts.box().low, high = parts.box().high,
             corner = parts.ceilings().corner();
  Field field;
  field.index = index, field.parts = std::get<std::shared_ptr<const PartSet>>(object.body->shape),
  field.ceilings = parts.ceilings().values();
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) field.turn[3 * i + j] = static_cast<float>(pose.m[4 * j + i]);
    field.origin[i] = static_cast<float>(origin[i]), field.corner[i] = static_cast<float>(corner[i]);
    field.low[i] = rounded_down(low[i]), field.high[i] = rounded_up(high[i]);
  }
  field.unit = static_cast<float>(parts.ceilings().unit());
  field.size = norm_1(origin) + norm_1(low) + norm_1(high) + norm_1(corner);
  field.room = rounded_up(object.body->inflation_radius + field.size * double{kHeightError} + kTiniest);
  fields_.push_back(std::move(field));
  return fields_.size() - 1;
}

// The finest level that says something of such a radius.
HeightFilter::Level<float, std::int32_t> HeightFilter::level_for(double radius, const HeightCeilings& ceilings) {
  const auto width = [](const HeightCeilings::Level& level) { return smaller(level.width[0], level.width[1]); };
  const auto& levels = ceilings.levels();
  auto level = levels.begin();
  while (level + 1 != levels.end() && !(width(*level) > radius)) ++level;
  Level<float, std::int32_t> out;
  for (std::size_t i = 0; i < 2; ++i) {
    out.per_width[i] = static_cast<float>(1 / level->width[i]);
    out.last[i] = static_cast<float>(level->cells[i] - 1);
  }
  const bool is_one = level->cells[0] * level->cells[1] == 1;
  out.width = is_one ? std::numeric_limits<float>::infinity() : rounded_down(width(*level));
  out.tiles = level->tiles, out.first = level->first;
  return out;
}

void HeightFilter::add(std::int32_t pair, std::size_t ball, const BoundingBall& bound, std::int32_t index,
                       const GeometryObject& object) {
  const std::size_t number = field_of(index, object);
  Field& field = fields_[number];
  const double radius = (double{bound.radius} + double{bound.room} + double{field.room}) * kLongerRadius;
  const auto level = level_for(radius + field.size * kFarCentre, field.parts->ceilings());
  rows_.push_back({pair, ball, number, level});
  put_beside_others(rows_.back(), field.eights);
}

void HeightFilter::put_beside_others(const Row& row, std::vector<Eight>& eights) {
  const std::size_t index = row.ball / kFloats, lane = row.ball % kFloats;
  if (eights.empty() || eights.back().index != index) {
    eights.emplace_back();
    eights.back().index = index;
  }
  Eight& eight = eights.back();
  eight.paired |= 1U << lane, eight.pairs[lane] = row.pair;
  for (std::size_t i = 0; i < 2; ++i) {
    eight.level.per_width[i][lane] = row.level.per_width[i], eight.level.last[i][lane] = row.level.last[i];
  }
  eight.level.width[lane] = row.level.width;
  eight.level.tiles[lane] = row.level.tiles, eight.level.first[lane] = row.level.first;
}

}  // namespace plannercheck
