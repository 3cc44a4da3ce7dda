// Certified motions in Python: batches, with the GIL released, on any number of threads.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "bindings/array_types.hpp"
#include "bindings/module.hpp"
#include "bindings/motion_arrays.hpp"
#include "bindings/motion_memo.hpp"
#include "bindings/numpy_row.hpp"
#include "bindings/ompl_states.hpp"
#include "bindings/plain_floats.hpp"
#include "bindings/verdict_dicts.hpp"
#include "bindings/workspace_pool.hpp"
#include "motions/chunk_judge.hpp"
#include "motions/motion_certifier.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

using Configurations = InputArray<double, -1, -1>;
template <int columns>
using IndexTable = InputArray<std::int32_t, -1, columns>;

MotionChains chains_from(IndexTable<2> drives, InputArray<double, -1, 2> factors,
                         InputArray<std::int32_t, -1> first_entry, IndexTable<3> entries, InputArray<double, -1> arms,
                         InputArray<std::int32_t, -1> slides) {
  MotionChains out;
  for (std::size_t j = 0; j < drives.shape(0); ++j)
    out.joints.push_back({static_cast<DriveKind>(drives(j, 0)), drives(j, 1), factors(j, 0), factors(j, 1)});
  for (std::size_t e = 0; e < entries.shape(0); ++e) {
    // The largest of several bounds is taken by comparisons, in which a NaN could get lost.
    if (!(arms(e) >= 0.0)) throw std::invalid_argument("an arm of a chain is no length");
    out.entries.push_back({entries(e, 0), arms(e), entries(e, 1), entries(e, 2)});
  }
  out.slides.assign(slides.data(), slides.data() + slides.shape(0));
  out.first_entry.assign(first_entry.data(), first_entry.data() + first_entry.shape(0));
  return out;
}

class BoundCertifier : public Pooled<MotionCertifier> {
 public:
  using Pooled::Pooled;

  nb::dict statistics() {
    using C = MotionCounters;
    const C total = counted();
    nb::dict out = named_counters(total, {{"motions", &C::motions},
                                          {"grids", &C::grids},
                                          {"states", &C::states},
                                          {"pairs", &C::pairs},
                                          {"intervals", &C::intervals},
                                          {"planes", &C::planes},
                                          {"swept", &C::swept}});
    out["queries"] = counters_dict(total.pair);
    return out;
  }
};

using ControlPoints = InputArray<double, -1, -1, -1>;

// The motions of control points (n, degree + 1, width). `tubes`: (n, width + 1) by how much numbers may be off and how
// far bodies have to stay apart, one for all (1, width + 1), or none (0, …).
Segments curves(const ControlPoints& points, const Configurations* tubes = nullptr) {
  const std::size_t rows = points.shape(1), width = points.shape(2);
  if (rows < 2 || rows > kMostDegree + 1) throw std::invalid_argument("a curve has another number of control points");
  Segments motions{points.data(), points.data() + (rows - 1) * width, rows * width, rows - 1};
  if (tubes != nullptr && tubes->shape(0) != 0) {
    const bool is_one = tubes->shape(0) == 1;
    if ((!is_one && tubes->shape(0) != points.shape(0)) || tubes->shape(1) != width + 1) {
      throw std::invalid_argument("there is no tube for each motion");
    }
    motions.tubes = tubes->data(), motions.tube_stride = is_one ? 0 : width + 1;
  }
  return motions;
}

// MotionAnswer of each of n motions; `low` and `high`: where the kinematic error holds for more than these motions.
auto check_motions(BoundCertifier& bound, const Kinematics& kinematics, InputArray<double, -1> low,
                   InputArray<double, -1> high, double kinematic_error, ControlPoints points, Configurations tubes,
                   double tolerance, int threads) {
  const Segments motions = curves(points, &tubes);
  const PoseRange range{low.data(), high.data()};
  return bound.of_rows<std::uint8_t>(
      points.shape(0), threads,
      [&](std::size_t row, std::size_t n, std::uint8_t* answers, MotionCertifier::Workspace& w) {
        bound.core().check_pieces(kinematics, motions.from(row), n, tolerance, kinematic_error, range, answers, w);
      });
}

// The motions that are answered without Python: a kinematic error holds for all their configurations, and angles that
// whole turns do not change take the short way.
struct KnownMotions {
  std::vector<double> low, high;
  double error;
  std::vector<std::size_t> angles;
  double most_turn;  // rad

  std::size_t width() const { return low.size(); }
  bool hold(const Segment& motion) const {
    bool known = stays_within(motion, width(), low.data(), high.data());
    for (const std::size_t k : angles) known &= change(motion, k) <= most_turn;
    return known;
  }
};

// Angles that are no further apart than this surely take the short way, rad.
constexpr double kNearlyHalfTurn = 3.1415;

KnownMotions known_motions(InputArray<double, -1> low, InputArray<double, -1> high, double error,
                           const std::vector<std::size_t>& angles, double most_turn) {
  return {
      {low.data(), low.data() + low.shape(0)}, {high.data(), high.data() + high.shape(0)}, error, angles, most_turn};
}

// The MotionAnswer of one motion; kUnknown if Python has to judge it.
constexpr int kUnknown = 3;

int answer_of(BoundCertifier& bound, const Kinematics& kinematics, const Segment& motion, const KnownMotions& known,
              double tolerance) {
  if (!known.hold(motion)) return kUnknown;
  std::uint8_t answer = 0;
  bound.with_workspace([&](MotionCertifier::Workspace& w) {
    const Segments one{motion.start, motion.end, known.width()};
    bound.core().check(kinematics, one, 1, tolerance, known.error, &answer, w);
  });
  return answer;
}

// An array (n,) of whether each of n motions is free; None if Python has to judge any of them.
nb::object known_validity(BoundCertifier& bound, const Kinematics& kinematics, const Segments& motions, std::size_t n,
                          const KnownMotions& known, double tolerance, int threads) {
  for (std::size_t i = 0; i < n; ++i) {
    if (!known.hold(motions[i])) return nb::none();
  }
  std::atomic<bool> answered{true};
  const PoseRange range{known.low.data(), known.high.data()};
  const auto free = bound.of_rows<std::uint8_t>(
      n, threads, [&](std::size_t row, std::size_t count, std::uint8_t* answers, MotionCertifier::Workspace& w) {
        bound.core().check_pieces(kinematics, motions.from(row), count, tolerance, known.error, range, answers, w);
        for (std::size_t i = 0; i < count; ++i) {
          if (answers[i] > static_cast<std::uint8_t>(MotionAnswer::kRefused)) answered = false;
          answers[i] = answers[i] == static_cast<std::uint8_t>(MotionAnswer::kFree) ? 1 : 0;
        }
      });
  return answered ? nb::cast(free) : nb::none();
}

// known_validity for curves; the kinematic error holds between `low` and `high`.
nb::object curve_validity(BoundCertifier& bound, const Kinematics& kinematics, InputArray<double, -1> low,
                          InputArray<double, -1> high, double kinematic_error, ControlPoints points,
                          Configurations tubes, double tolerance, int threads) {
  const KnownMotions known = known_motions(low, high, kinematic_error, {}, 0);
  return known_validity(bound, kinematics, curves(points, &tubes), points.shape(0), known, tolerance, threads);
}

// A function of two states (ompl_states.hpp): whether the motion between them is free; it counts its answers. It passes
// motions that are not known to `elsewhere`, a function of two lists. `angles` are the columns of angles that whole
// turns do not change.
nb::object motion_validity(nb::object certifier, nb::object kinematics, InputArray<double, -1> low,
                           InputArray<double, -1> high, double tolerance, double kinematic_error, nb::object elsewhere,
                           std::shared_ptr<MotionCounts> counts, std::shared_ptr<const PlannerStates> states,
                           const std::vector<std::size_t>& angles, std::shared_ptr<PlannerFailure> failure) {
  auto* bound = nb::cast<BoundCertifier*>(certifier);
  const auto* kernel = nb::cast<const Kinematics*>(kinematics);
  const auto answer = [elsewhere, bound, kernel, tolerance,
                       known = known_motions(low, high, kinematic_error, angles, std::numbers::pi)](
                          const StateNumbers& q0, const StateNumbers& q1) {
    const int found = answer_of(*bound, *kernel, {q0.data(), q1.data()}, known, tolerance);
    if (found <= static_cast<int>(MotionAnswer::kRefused)) return found == static_cast<int>(MotionAnswer::kFree);
    return nb::cast<bool>(elsewhere(listed(q0), listed(q1)));
  };
  const auto counted = [certifier, kinematics, answer, counts, states = of_width(low.shape(0), std::move(states)),
                        memo = std::make_shared<MotionMemo>(low.shape(0)), failure](nb::handle s0, nb::handle s1) {
    end_on_signals();
    StateNumbers q0(states->width()), q1(states->width());
    states->read(s0, q0);
    states->read(s1, q1);
    const bool free = failure && failure->remembering.is_on() ? memo->answer(failure->remembering.begun(), q0.data(),
                                                                             q1.data(), [&] { return answer(q0, q1); })
                                                              : answer(q0, q1);
    counts->add(free);
    return free;
  };
  const auto is_free = [counted, failure](nb::handle s0, nb::handle s1) {
    return judged_or_failed(failure, [&] { return counted(s0, s1); });
  };
  return nb::cpp_function(is_free, plain_floats);
}

// A function of the ends of a motion and a tolerance, without the overhead of sets: whether the motion is free. It
// returns None where more care is needed: for anything but NumPy rows of numbers in the range, for tolerances that are
// no lengths, and where an angle takes the other way round.
nb::object motion_row_validity(nb::object certifier, nb::object kinematics, InputArray<double, -1> low,
                               InputArray<double, -1> high, double kinematic_error,
                               const std::vector<std::size_t>& angles) {
  auto* bound = nb::cast<BoundCertifier*>(certifier);
  const auto* kernel = nb::cast<const Kinematics*>(kinematics);
  const auto is_free = [certifier, kinematics, bound, kernel, array = NumpyArray(),
                        known = known_motions(low, high, kinematic_error, angles, kNearlyHalfTurn)](
                           nb::handle start, nb::handle end, nb::handle length) -> nb::object {
    const std::size_t width = known.width();
    const NumpyRow from(array, start, width), to(array, end, width);
    if (from.data() == nullptr || to.data() == nullptr || !PyFloat_Check(length.ptr())) return nb::none();
    const double tolerance = PyFloat_AS_DOUBLE(length.ptr());
    if (!(tolerance > 0 && std::isfinite(tolerance))) return nb::none();
    // Copies, since other threads may write to the arrays once the GIL is released.
    StateNumbers q0(width), q1(width);
    std::copy_n(from.data(), width, q0.data());
    std::copy_n(to.data(), width, q1.data());
    const int answer = [&] {
      const GilReleasedWhenLong gil;
      return answer_of(*bound, *kernel, {q0.data(), q1.data()}, known, tolerance);
    }();
    if (answer > static_cast<int>(MotionAnswer::kRefused)) return nb::none();
    return nb::bool_(answer == static_cast<int>(MotionAnswer::kFree));
  };
  return nb::cpp_function(is_free, nb::arg("start").none(), nb::arg("end").none(), nb::arg("tolerance").none(),
                          plain_floats);
}

// The judge of sets of motions, (n, nq) arrays of starts and ends: returns an array (n,) of whether each is free, or
// None if Python has to judge any of them.
nb::object motion_set_validity(nb::object certifier, nb::object kinematics, InputArray<double, -1> low,
                               InputArray<double, -1> high, double kinematic_error,
                               const std::vector<std::size_t>& angles) {
  auto* bound = nb::cast<BoundCertifier*>(certifier);
  const auto* kernel = nb::cast<const Kinematics*>(kinematics);
  const auto are_free = [certifier, kinematics, bound, kernel, array = NumpyArray(),
                         known = known_motions(low, high, kinematic_error, angles, kNearlyHalfTurn)](
                            nb::handle starts, nb::handle ends, nb::handle length, int threads) -> nb::object {
    const std::size_t width = known.width();
    const NumpyRows from(array, starts, width), to(array, ends, width);
    if (from.n == 0 || from.n != to.n || !PyFloat_Check(length.ptr())) return nb::none();
    const double tolerance = PyFloat_AS_DOUBLE(length.ptr());
    if (!(tolerance > 0 && std::isfinite(tolerance))) return nb::none();
    const Segments motions{from.data, to.data, width};
    return known_validity(*bound, *kernel, motions, from.n, known, tolerance, threads);
  };
  return nb::cpp_function(are_free, nb::arg("starts").none(), nb::arg("ends").none(), nb::arg("tolerance").none(),
                          nb::arg("threads"), plain_floats);
}

// For tests: asks a function of a motion's ends (2, width) and its tube (width + 1,) whether it is free.
MotionJudge judge_in_python(nb::object function, std::size_t width) {
  return [function, width](const Segment& motion) {
    std::vector<double> ends(motion.start, motion.start + width);
    ends.insert(ends.end(), motion.end, motion.end + width);
    const std::vector<double> tube(motion.tube, motion.tube + width + 1);
    const nb::object found = function(output_array(ends, {2, width}), output_array(tube, {width + 1}));
    return nb::cast<bool>(found) ? MotionAnswer::kFree : MotionAnswer::kRefused;
  };
}

// A function of the rows (n + 1, width) of a chunk, which nobody changes, its velocities at the start, and its first,
// last and least step: the ChunkAnswer as a number. `ask`, if it is not None, judges motions in place of the certifier.
nb::object chunk_judge(nb::object certifier, nb::object kinematics, InputArray<double, -1> low,
                       InputArray<double, -1> high, double kinematic_error, InputArray<double, 5, -1> limits,
                       InputArray<double, -1> tube, double tolerance, nb::object ask) {
  const std::size_t width = limits.shape(1);
  const auto row = [&](std::size_t k) {
    return std::vector<double>(limits.data() + k * width, limits.data() + (k + 1) * width);
  };
  auto* bound = nb::cast<BoundCertifier*>(certifier);
  const auto* kernel = nb::cast<const Kinematics*>(kinematics);
  return nb::cpp_function(
      [certifier, kinematics, bound, kernel, width, known = known_motions(low, high, kinematic_error, {}, 0),
       numbers =
           GateNumbers{row(0), row(1), row(2), row(3), row(4), {tube.data(), tube.data() + tube.shape(0)}, tolerance},
       ask = ask.is_none() ? MotionJudge() : judge_in_python(ask, width)](
          InputArray<double, -1, -1> rows, InputArray<double, -1> dq, double first, double last, double least) {
        if (rows.shape(0) < 2 || rows.shape(1) != width || dq.shape(0) != width) {
          throw std::invalid_argument("rows of a chunk have another width");
        }
        const auto judged = [&](const MotionJudge& judge) {
          return judged_chunk(numbers, rows.data(), rows.shape(0) - 1, dq.data(), {first, last, least}, judge);
        };
        ChunkAnswer answer = ChunkAnswer::kUnknown;
        if (ask) {
          answer = judged(ask);
        } else {
          const GilReleasedWhenLong gil;
          bound->with_workspace([&](MotionCertifier::Workspace& w) {
            answer = judged([&](const Segment& motion) {
              if (!known.hold(motion)) return MotionAnswer::kImprecise;
              std::uint8_t found = 0;
              const Segments one{motion.start, motion.end, width, 1, motion.tube, width + 1};
              bound->core().check(*kernel, one, 1, numbers.tolerance, known.error, &found, w);
              return static_cast<MotionAnswer>(found);
            });
          });
        }
        return static_cast<int>(answer);
      },
      plain_floats);
}

// See `explained_motion`, of the first motion; with proofs if wanted.
nb::tuple explain_motion(BoundCertifier& bound, const Kinematics& kinematics, ControlPoints points,
                         Configurations tubes, double tolerance, double kinematic_error, bool proved) {
  MotionReport report;
  std::vector<MotionProof> proofs;
  without_gil([&] {
    bound.with_workspace([&](MotionCertifier::Workspace& w) {
      report = bound.core().explain(kinematics, curves(points, &tubes)[0], tolerance, kinematic_error,
                                    proved ? &proofs : nullptr, w);
    });
  });
  return explained_motion<3>(report, proofs, [](Vec3 d, std::vector<double>& rows) { append(rows, d); });
}

// Configurations at parameters (n,) of the first motion.
auto motion_states(const BoundCertifier& bound, ControlPoints points, InputArray<double, -1> parameters) {
  const std::size_t width = points.shape(2);
  std::vector<double> q(parameters.shape(0) * width);
  bound.core().states(curves(points)[0], parameters.data(), parameters.shape(0), q.data());
  return output_array(q, {parameters.shape(0), width});
}

}  // namespace

void bind_motion(nb::module_& m) {
  nb::class_<BoundCertifier>(m, "MotionCertifier")
      .def(
          "__init__",
          [](BoundCertifier* self, const std::vector<std::shared_ptr<Polytope>>& bodies,
             InputArray<std::int32_t, -1> links, InputArray<double, -1, 4, 4> placements, IndexTable<5> pairs,
             IndexTable<2> drives, InputArray<double, -1, 2> factors, InputArray<std::int32_t, -1> first_entry,
             IndexTable<3> entries, InputArray<double, -1> arms, InputArray<std::int32_t, -1> slides,
             IndexTable<2> parts, int width, int link_count, double defect, double leverage, int depth, double extent,
             InputArray<double, -1> travel, int joints, const Tuning& tuning, nb::list states) {
            MotionModel model;
            model.bodies = geometry_objects(bodies, links, placements);
            for (std::size_t p = 0; p < pairs.shape(0); ++p)
              model.pairs.push_back({pairs(p, 0), pairs(p, 1), pairs(p, 2), pairs(p, 3), pairs(p, 4)});
            model.chains = chains_from(drives, factors, first_entry, entries, arms, slides);
            for (std::size_t k = 0; k < parts.shape(0); ++k)
              model.parts.push_back({static_cast<PartKind>(parts(k, 0)), parts(k, 1)});
            model.width = width;
            model.links = link_count;
            model.defect = defect;
            model.leverage = leverage;
            model.depth = depth;
            model.extent = extent;
            model.travel.assign(travel.data(), travel.data() + travel.shape(0));
            model.joints = joints;
            new (self)
                BoundCertifier(std::move(model), tuning, states.size() == 0 ? nullptr : shared_checker_core(states[0]));
          },
          plain_floats)
      .def("check", &check_motions, plain_floats)
      .def("explain", &explain_motion, plain_floats)
      .def("states", &motion_states, plain_floats)
      .def("statistics", &BoundCertifier::statistics, plain_floats);
  m.def("motion_row_validity", &motion_row_validity, plain_floats);
  m.def("motion_set_validity", &motion_set_validity, plain_floats);
  m.def("curve_validity", &curve_validity, plain_floats);
  m.def("chunk_judge", &chunk_judge, nb::arg("certifier"), nb::arg("kinematics"), nb::arg("low"), nb::arg("high"),
        nb::arg("kinematic_error"), nb::arg("limits"), nb::arg("tube"), nb::arg("tolerance"),
        nb::arg("ask").none() = nb::none(), plain_floats);
  m.def("motion_validity", &motion_validity, nb::arg("certifier"), nb::arg("kinematics"), nb::arg("low"),
        nb::arg("high"), nb::arg("tolerance"), nb::arg("kinematic_error"), nb::arg("elsewhere"), nb::arg("counts"),
        nb::arg("states").none() = nb::none(), nb::arg("angles") = std::vector<std::size_t>(),
        nb::arg("failure").none() = nb::none(), plain_floats);
}

}  // namespace plannercheck
