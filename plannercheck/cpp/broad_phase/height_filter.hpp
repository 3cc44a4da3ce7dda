// Which bounding balls may touch static height fields: by one look at the ceiling of the cell below each centre
// (height_ceilings.hpp), in floats.
//
// In: fields in the world, posed balls of a block of states, or of one. Out: the states in which a pair is apart. A
// ball is clear if it is above the ceiling, or beyond a side of the box around the field. In doubt, and for NaN, a pair
// may touch.
//
// Proof. A pair that touches shares a point w of the ball around c, with the field's inflation radius added, R, and the
// place s of the field: w = M s + t. Then M⁻¹ (c − t) is at most (1 + 2e-6) R from s along each axis, and the computed
// l is near M⁻¹ (c − t). Let E be the bound of all that errs (kHeightError) and `reach` (1 + 2e-6) R + E. The cell's
// index is that of a place within the rest of E of l, or the first or last one if l is beyond the field; so s is less
// than a cell's width beyond the sides of that cell if `reach` is less than that, and belongs to a square of the cell
// or of its neighbours: it is no higher than the ceiling. But if l less `reach` is above the ceiling, so is s.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "bodies/height_ceilings.hpp"
#include "broad_phase/bounding_sphere.hpp"
#include "broad_phase/filter.hpp"
#include "broad_phase/geometry_object.hpp"
#include "broad_phase/posed_balls.hpp"
#include "broad_phase/single_state_filter.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"

namespace plannercheck {

class HeightFilter {
 public:
  static bool is_for(const GeometryObject& object);

  // A level of ceilings, of one ball or of eight.
  template <class Numbers, class Integers>
  struct Level {
    std::array<Numbers, 2> per_width, last;  // cells a metre, and the last cell's index, along x and y
    Numbers width;                           // the lesser one of a cell, m; infinite if there is one cell
    Integers tiles, first;
  };
  // A field that a ball, by its number, has a pair with.
  struct Row {
    std::int32_t pair;
    std::size_t ball, field;
    Level<float, std::int32_t> level;
  };
  // `index` is the field's.
  void add(std::int32_t pair, std::size_t ball, const BoundingBall& bound, std::int32_t index,
           const GeometryObject& field);
  const std::vector<Row>& rows() const { return rows_; }

  Masks look(const Row& row, const PosedBalls& ball) const {
    return {.apart = bits(is_clear(fields_[row.field], row.level, ball.x, ball.y, ball.z, ball.radius))};
  }

  // Eight balls of one state at a time: calls found(pair) for pairs that may touch.
  template <class Found>
  void find(const SingleStateFilter::Workspace& balls, Found found) const {
    for (const Field& field : fields_) {
      for (const Eight& own : field.eights) {
        const SingleStateFilter::Posed& ball = balls.posed[own.index];
        const unsigned clear = bits(is_clear(field, own.level, ball.x, ball.y, ball.z, ball.radius));
        for (unsigned near = ~clear & own.paired; near != 0; near &= near - 1)
          found(own.pairs[static_cast<std::size_t>(__builtin_ctz(near))]);
      }
    }
  }

 private:
  // Eight balls side by side; `paired` has a bit for each ball that has a pair with the field.
  struct Eight {
    std::size_t index;
    unsigned paired = 0;
    std::array<std::int32_t, kFloats> pairs{};
    Level<Floats, FloatMask> level{};
  };
  struct Field {
    std::int32_t index;
    std::shared_ptr<const PartSet> parts;
    const std::uint16_t* ceilings;
    std::array<float, 9> turn;               // from the world to the field, row by row
    std::array<float, 3> origin, low, high;  // of the field's frame; of the box around its parts
    std::array<float, 3> corner;             // where the ceilings begin
    float unit;                              // of ceilings, m
    float room;                              // to add to radii
    double size;                             // of all that enters
    std::vector<Eight> eights;
  };

  // Lengths err by less than this part of |.|_1 of the ball's centre, of the field's translation, of the sides of its
  // box, and of the corner of its lattice. u = 2^-24, δ = 3.6e-6 bounds how far poses are off rigid, |MᵀM − 1|. Mᵀ in
  // place of M⁻¹ errs by δ (1 + δ), 62u, of |c − t|; rounding the translation, the difference, the entries, and three
  // products and sums by 7u of |c| + |t| along each axis. The index errs by 5u of |l| and of the sides besides, the
  // ceiling and the comparison by 9u of both. That is less than 90u of each. 128u of the radius is more than its
  // stretch, 34u, and the rounding of `reach`.
  static constexpr float kHeightError = 0x1p-17F;

  std::vector<Field> fields_;
  std::vector<Row> rows_;

  std::size_t field_of(std::int32_t index, const GeometryObject& object);
  static Level<float, std::int32_t> level_for(double radius, const HeightCeilings& ceilings);
  static void put_beside_others(const Row& row, std::vector<Eight>& eights);

  template <class Numbers, class Level>
  static auto is_clear(const Field& field, const Level& level, Numbers x, Numbers y, Numbers z, Numbers radius)
      -> decltype(x < y) {
    const Numbers size = (absolute(x) + absolute(y)) + absolute(z);
    const Numbers reach = ((size * kHeightError + field.room) + radius) * (1 + kHeightError);
    const Numbers dx = x - field.origin[0], dy = y - field.origin[1], dz = z - field.origin[2];
    const auto along = [&](std::size_t i) {
      return (field.turn[3 * i] * dx + field.turn[3 * i + 1] * dy) + field.turn[3 * i + 2] * dz;
    };
    const std::array<Numbers, 3> l{along(0), along(1), along(2)};
    const auto beyond = [&](std::size_t i) { return (l[i] + reach < field.low[i]) | (l[i] - reach > field.high[i]); };
    // NaN goes to the first cell.
    const auto cell = [&](std::size_t i) {
      const Numbers place = larger((l[i] - field.corner[i]) * level.per_width[i], Numbers{});
      return __builtin_convertvector(smaller(place, Numbers{} + level.last[i]), decltype(beyond(0)));
    };
    const auto tiles = decltype(beyond(0)){} + level.tiles;
    const auto units = gathered_shorts(field.ceilings, level.first + HeightCeilings::place(cell(0), cell(1), tiles));
    const Numbers ceiling = __builtin_convertvector(units, Numbers) * field.unit + field.corner[2];
    return beyond(0) | beyond(1) | beyond(2) | ((l[2] - reach > ceiling) & (reach < level.width));
  }
};

}  // namespace plannercheck
