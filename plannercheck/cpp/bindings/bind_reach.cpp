// Cells of reach in Python: they come as arrays from plannercheck/checking/robot_reach.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "broad_phase/apart_cells.hpp"
#include "checking/reach_cells.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

// centres: (n, 3) of all sets, first_centre: where each set begins, and the end; sets, radii, extents: of each cut;
// first_cut: where each body's cuts begin, and the end.
ReachCells reach_cells(InputArray<double, -1, 3> centres, InputArray<std::int64_t, -1> first_centre,
                       InputArray<std::int64_t, -1> sets, InputArray<double, -1> radii, InputArray<double, -1> extents,
                       InputArray<std::int64_t, -1> first_cut, double margin, double relative) {
  std::vector<std::vector<Vec3>> listed;
  for (std::size_t s = 0; s + 1 < first_centre.shape(0); ++s) {
    std::vector<Vec3> set;
    for (auto k = static_cast<std::size_t>(first_centre(s)); k < static_cast<std::size_t>(first_centre(s + 1)); ++k)
      set.push_back({centres(k, 0), centres(k, 1), centres(k, 2)});
    listed.push_back(std::move(set));
  }
  std::vector<ReachCut> cuts;
  for (std::size_t c = 0; c < sets.shape(0); ++c)
    cuts.push_back({static_cast<std::size_t>(sets(c)), radii(c), extents(c)});
  std::vector<std::size_t> first;
  for (std::size_t b = 0; b < first_cut.shape(0); ++b) first.push_back(static_cast<std::size_t>(first_cut(b)));
  return {listed, std::move(cuts), std::move(first), margin, relative};
}

// (bodies, n) whether each body never meets each of n obstacles: posed boxes (n, 3) to (n, 3), with their inflation
// radii and sizes.
auto clear_of(const ReachCells& cells, InputArray<double, -1, 4, 4> poses, InputArray<double, -1, 3> low,
              InputArray<double, -1, 3> high, InputArray<double, -1> inflation_radii, InputArray<double, -1> sizes) {
  const std::size_t n = poses.shape(0), bodies = cells.body_count();
  if (low.shape(0) != n || high.shape(0) != n || inflation_radii.shape(0) != n || sizes.shape(0) != n)
    throw std::invalid_argument("poses, corners, inflation radii and sizes are not of as many obstacles");
  std::vector<std::uint8_t> clear(bodies * n);
  without_gil([&] {
    for (std::size_t o = 0; o < n; ++o) {
      if (o > 0) poll_interruption();
      const ReachObstacle obstacle{pose_from(poses.data() + 16 * o),
                                   {low(o, 0), low(o, 1), low(o, 2)},
                                   {high(o, 0), high(o, 1), high(o, 2)},
                                   inflation_radii(o),
                                   sizes(o)};
      for (std::size_t b = 0; b < bodies; ++b) clear[b * n + o] = cells.is_clear(b, obstacle) ? 1 : 0;
    }
  });
  return output_array(clear, {bodies, n});
}

// may_meet: (cells of the first number, of the second), a bit for each pair.
ApartCells apart_cells(const std::array<std::size_t, 2>& columns, const std::array<double, 2>& low,
                       const std::array<double, 2>& per_unit, InputArray<std::uint8_t, -1, -1> may_meet) {
  const auto of = [&](std::size_t k) {
    return CellsOfColumn{columns[k], low[k], per_unit[k], static_cast<int>(may_meet.shape(k))};
  };
  return {{of(0), of(1)}, {may_meet.data(), may_meet.data() + may_meet.size()}};
}

}  // namespace

void bind_reach(nb::module_& m) {
  nb::class_<ApartCells>(m, "ApartCells");
  m.def("apart_cells", &apart_cells, plain_floats);
  nb::class_<ReachCells>(m, "ReachCells").def("clear_of", &clear_of, plain_floats);
  m.def("reach_cells", &reach_cells, plain_floats);
}

}  // namespace plannercheck
