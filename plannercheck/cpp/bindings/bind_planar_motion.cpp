// Certified motions of planar robots in Python: batches, with the GIL released, on any number of threads.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/vector.h>

#include <cstring>

#include "bindings/array_types.hpp"
#include "bindings/module.hpp"
#include "bindings/motion_arrays.hpp"
#include "bindings/plain_floats.hpp"
#include "bindings/planar_arrays.hpp"
#include "bindings/workspace_pool.hpp"
#include "planar/motion_certifier_2d.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace planar_motion_binding {  // names of its own: bindings are compiled in one piece

using Row = InputArray<double, -1>;
using Rows = InputArray<double, -1, -1>;
using Pieces = InputArray<double, -1, static_cast<int>(kPieceNumbers)>;

class BoundPlanarCertifier : public Pooled<PlanarCertifier> {
 public:
  explicit BoundPlanarCertifier(const PlanarModel& model)
      : Pooled(model.links, model.width, model.bodies, model.pairs), polygons_(model.polygons) {}

  nb::dict statistics() {
    using C = GridCounters;
    return named_counters(counted(), {{"motions", &C::motions},
                                      {"grids", &C::grids},
                                      {"states", &C::states},
                                      {"intervals", &C::intervals},
                                      {"lines", &C::planes},
                                      {"swept", &C::swept}});
  }

 private:
  nb::list polygons_;  // kept alive
};

// MotionAnswer of each of n straight motions; `given`: ends before whole turns were taken off.
auto check_straight(BoundPlanarCertifier& bound, Rows q0, Rows q1, Rows given, double tolerance, int threads) {
  const std::size_t width = q0.shape(1);
  return bound.of_each_row<std::uint8_t>(q0.shape(0), threads, [&](std::size_t i, PlanarCertifier::Workspace& w) {
    const double *start = q0.data() + i * width, *end = q1.data() + i * width;
    const PlanarPiece piece = bound.core().straight(start, end);
    return bound.core().check({start, end, given.data() + i * width, &piece, 1}, tolerance, w).answer;
  });
}

// A motion's pieces from rows of numbers; without rows, the straight one.
std::vector<PlanarPiece> pieces_from(const PlanarCertifier& certifier, const double* q0, const double* q1,
                                     Pieces pieces) {
  if (pieces.shape(0) == 0) return {certifier.straight(q0, q1)};
  std::vector<PlanarPiece> out(pieces.shape(0));
  std::memcpy(out.data(), pieces.data(), out.size() * sizeof(PlanarPiece));
  return out;
}

int check_pieces(BoundPlanarCertifier& bound, Row q0, Row q1, Row given, Pieces rows, double tolerance) {
  MotionReport report;
  without_gil([&] {
    const std::vector<PlanarPiece> pieces = pieces_from(bound.core(), q0.data(), q1.data(), rows);
    bound.with_workspace([&](PlanarCertifier::Workspace& w) {
      const PlanarMotion motion{q0.data(), q1.data(), given.data(), pieces.data(), pieces.size()};
      report = bound.core().check(motion, tolerance, w);
    });
  });
  return static_cast<int>(report.answer);
}

// See `explained_motion`; with proofs if wanted.
nb::tuple explain_pieces(BoundPlanarCertifier& bound, Row q0, Row q1, Row given, Pieces rows, double tolerance,
                         bool proved) {
  MotionReport report;
  std::vector<PlanarProof> proofs;
  without_gil([&] {
    const std::vector<PlanarPiece> pieces = pieces_from(bound.core(), q0.data(), q1.data(), rows);
    bound.with_workspace([&](PlanarCertifier::Workspace& w) {
      const PlanarMotion motion{q0.data(), q1.data(), given.data(), pieces.data(), pieces.size()};
      report = bound.core().explain(motion, tolerance, proved ? &proofs : nullptr, w);
    });
  });
  return explained_motion<2>(report, proofs, [](PlanarDirection d, std::vector<double>& row) {
    row.insert(row.end(), {d.vector().x, d.vector().y});
  });
}

// Configurations at parameters (n,) of a motion.
auto piece_states(BoundPlanarCertifier& bound, Row q0, Row q1, Pieces rows, Row parameters) {
  const std::vector<PlanarPiece> pieces = pieces_from(bound.core(), q0.data(), q1.data(), rows);
  const std::size_t n = parameters.shape(0), width = q0.shape(0);
  std::vector<double> q(n * width);
  bound.with_workspace([&](PlanarCertifier::Workspace& w) {
    const PlanarMotion motion{q0.data(), q1.data(), q1.data(), pieces.data(), pieces.size()};
    bound.core().states(motion, parameters.data(), n, q.data(), w);
  });
  return output_array(q, {n, width});
}

// The link in whose frame each pair's proofs are, or -1 for the world.
auto pair_frames(const BoundPlanarCertifier& bound) {
  const std::vector<std::int32_t> frames = bound.core().frames();
  return output_array(frames, {frames.size()});
}

}  // namespace planar_motion_binding

void bind_planar_motion(nb::module_& m) {
  using namespace planar_motion_binding;
  nb::class_<BoundPlanarCertifier>(m, "PlanarCertifier")
      .def(nb::init<const PlanarModel&>(), plain_floats)
      .def("check", &check_straight, plain_floats)
      .def("check_pieces", &check_pieces, plain_floats)
      .def("explain", &explain_pieces, plain_floats)
      .def("states", &piece_states, plain_floats)
      .def("frames", &pair_frames, plain_floats)
      .def("statistics", &BoundPlanarCertifier::statistics, plain_floats);
}

}  // namespace plannercheck
