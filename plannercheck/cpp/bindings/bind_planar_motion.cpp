// Certified motions of planar robots in Python: batches, with the GIL released, on as many threads as asked for.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/vector.h>

#include <cstring>

#include "bindings/array_types.hpp"
#include "bindings/module.hpp"
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

// A certifier with the workspaces that its callers have returned.
class BoundPlanarCertifier {
 public:
  // Arguments as those of PlanarChecker.
  BoundPlanarCertifier(InputArray<std::int32_t, -1, 3> links, InputArray<double, -1, 3> anchors, std::int32_t width,
                       const nb::list& polygons, InputArray<std::int32_t, -1> mounts,
                       InputArray<double, -1, 3, 3> poses, InputArray<double, -1, 3> circles,
                       InputArray<double, -1, 4> boxes, InputArray<std::int32_t, -1, 2> pairs)
      : polygons_(polygons),
        certifier_(planar_arrays::links_from(links, anchors), width,
                   planar_arrays::bodies_from(polygons, mounts, poses, circles, boxes),
                   planar_arrays::pairs_from(pairs)) {}

  template <class Work>
  void with_workspace(Work work) {
    pool_.with_one([&] { return certifier_.new_workspace(); }, work,
                   [&](auto& workspace) { add(PlanarCertifier::take_counters(workspace)); });
  }

  const PlanarCertifier& certifier() const { return certifier_; }

  nb::dict statistics() {
    const PlanarMotionCounters total = pool_.alone([&] { return total_; });
    nb::dict out;
    out["motions"] = total.motions;
    out["grids"] = total.grids;
    out["states"] = total.states;
    out["intervals"] = total.intervals;
    out["lines"] = total.lines;
    out["swept"] = total.swept;
    return out;
  }

 private:
  nb::list polygons_;  // kept alive
  PlanarCertifier certifier_;
  WorkspacePool<PlanarCertifier::WorkspacePointer> pool_;
  PlanarMotionCounters total_;

  void add(const PlanarMotionCounters& c) {
    total_.motions += c.motions, total_.grids += c.grids, total_.states += c.states;
    total_.intervals += c.intervals, total_.lines += c.lines, total_.swept += c.swept;
  }
};

// MotionAnswer of each of n straight motions; `given`: ends before whole turns were taken off.
auto check_straight(BoundPlanarCertifier& bound, Rows q0, Rows q1, Rows given, double tolerance, int threads) {
  std::vector<std::uint8_t> answers(q0.shape(0));
  {
    nb::gil_scoped_release release;
    const std::size_t width = q0.shape(1);
    in_parallel(answers.size(), threads, [&](std::size_t from, std::size_t to) {
      bound.with_workspace([&](PlanarCertifier::Workspace& w) {
        for (std::size_t i = from; i < to; ++i) {
          const double *start = q0.data() + i * width, *end = q1.data() + i * width;
          const PlanarPiece piece = bound.certifier().straight(start, end);
          const PlanarMotion motion{start, end, given.data() + i * width, &piece, 1};
          answers[i] = static_cast<std::uint8_t>(bound.certifier().check(motion, tolerance, w).answer);
        }
      });
    });
  }
  return output_array(answers, {answers.size()});
}

// A motion's pieces, of rows of numbers; the straight one if there are none.
std::vector<PlanarPiece> pieces_from(const PlanarCertifier& certifier, const double* q0, const double* q1,
                                     Pieces pieces) {
  if (pieces.shape(0) == 0) return {certifier.straight(q0, q1)};
  std::vector<PlanarPiece> out(pieces.shape(0));
  std::memcpy(out.data(), pieces.data(), out.size() * sizeof(PlanarPiece));
  return out;
}

int check_pieces(BoundPlanarCertifier& bound, Row q0, Row q1, Row given, Pieces rows, double tolerance) {
  MotionReport report;
  {
    nb::gil_scoped_release release;
    const std::vector<PlanarPiece> pieces = pieces_from(bound.certifier(), q0.data(), q1.data(), rows);
    bound.with_workspace([&](PlanarCertifier::Workspace& w) {
      const PlanarMotion motion{q0.data(), q1.data(), given.data(), pieces.data(), pieces.size()};
      report = bound.certifier().check(motion, tolerance, w);
    });
  }
  return static_cast<int>(report.answer);
}

// (answer, proved free up to, refused at, pair) of one motion, and if wanted the proofs: pairs (k,), intervals (k, 2),
// directions (k, 2), gaps and bulges (k, 2).
nb::tuple explain_pieces(BoundPlanarCertifier& bound, Row q0, Row q1, Row given, Pieces rows, double tolerance,
                         bool proved) {
  MotionReport report;
  std::vector<PlanarProof> proofs;
  {
    nb::gil_scoped_release release;
    const std::vector<PlanarPiece> pieces = pieces_from(bound.certifier(), q0.data(), q1.data(), rows);
    bound.with_workspace([&](PlanarCertifier::Workspace& w) {
      const PlanarMotion motion{q0.data(), q1.data(), given.data(), pieces.data(), pieces.size()};
      report = bound.certifier().explain(motion, tolerance, proved ? &proofs : nullptr, w);
    });
  }
  std::vector<std::int32_t> pairs;
  std::vector<double> intervals, directions, gaps;
  for (const PlanarProof& p : proofs) {
    pairs.push_back(p.pair);
    intervals.insert(intervals.end(), {p.from, p.to});
    const PlanarVector direction = p.direction.vector();
    directions.insert(directions.end(), {direction.x, direction.y});
    gaps.insert(gaps.end(), {p.gap, p.bulge});
  }
  const std::size_t n = proofs.size();
  return nb::make_tuple(static_cast<int>(report.answer), report.free_until, report.refused, report.pair,
                        output_array(pairs, {n}), output_array(intervals, {n, std::size_t{2}}),
                        output_array(directions, {n, std::size_t{2}}), output_array(gaps, {n, std::size_t{2}}));
}

// Configurations at parameters (n,) of a motion.
auto piece_states(BoundPlanarCertifier& bound, Row q0, Row q1, Pieces rows, Row parameters) {
  const std::vector<PlanarPiece> pieces = pieces_from(bound.certifier(), q0.data(), q1.data(), rows);
  const std::size_t n = parameters.shape(0), width = q0.shape(0);
  std::vector<double> q(n * width);
  bound.with_workspace([&](PlanarCertifier::Workspace& w) {
    const PlanarMotion motion{q0.data(), q1.data(), q1.data(), pieces.data(), pieces.size()};
    bound.certifier().states(motion, parameters.data(), n, q.data(), w);
  });
  return output_array(q, {n, width});
}

// Link in whose frame each pair's proofs are, -1 for the world.
auto pair_frames(const BoundPlanarCertifier& bound) {
  const std::vector<std::int32_t> frames = bound.certifier().frames();
  return output_array(frames, {frames.size()});
}

}  // namespace planar_motion_binding

void bind_planar_motion(nb::module_& m) {
  using namespace planar_motion_binding;
  nb::class_<BoundPlanarCertifier>(m, "PlanarCertifier")
      .def(nb::init<InputArray<std::int32_t, -1, 3>, InputArray<double, -1, 3>, std::int32_t, const nb::list&,
                    InputArray<std::int32_t, -1>, InputArray<double, -1, 3, 3>, InputArray<double, -1, 3>,
                    InputArray<double, -1, 4>, InputArray<std::int32_t, -1, 2>>(),
           plain_floats)
      .def("check", &check_straight, plain_floats)
      .def("check_pieces", &check_pieces, plain_floats)
      .def("explain", &explain_pieces, plain_floats)
      .def("states", &piece_states, plain_floats)
      .def("frames", &pair_frames, plain_floats)
      .def("statistics", &BoundPlanarCertifier::statistics, plain_floats);
}

}  // namespace plannercheck
