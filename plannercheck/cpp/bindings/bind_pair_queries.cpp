// Queries on a pair of bodies as users ask them, without a detour over Python: bodies and poses are looked at here.
//
// In: what users pass to `intersects` and `distance`. Out: the answer; None for what needs a closer look, which Python
// then takes: it converts, or says what is wrong.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/numpy_poses.hpp"
#include "bindings/plain_floats.hpp"
#include "narrow_phase/distance.hpp"
#include "narrow_phase/given_poses.hpp"
#include "narrow_phase/pair_kernels.hpp"
#include "narrow_phase/part_depth.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

constexpr double kIdentityMatrix[kGivenPose] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

// A body at a pose that has been checked.
struct PlacedPolytope {
  std::shared_ptr<Polytope> body;
  std::array<double, kGivenPose> matrix;
};

class PairQueries {
 public:
  // The classes that users have for bodies and for placed ones, each with the core's as its attribute `_core`.
  PairQueries(nb::object polytope_class, nb::object placed_class, double tolerance)
      : polytope_class_(std::move(polytope_class)),
        placed_class_(std::move(placed_class)),
        core_(nb::steal(PyUnicode_InternFromString("_core"))),
        tolerance_(tolerance) {}

  nb::object intersects(nb::handle p, nb::handle r, nb::handle pose_p, nb::handle pose_r, int threads) const {
    Side first, second;
    if (!read(p, pose_p, first) || !read(r, pose_r, second) || are_half_spaces(first, second)) return nb::none();
    if (first.poses.are_many() || second.poses.are_many()) return intersect_many(first, second, threads);
    const PosedPolytope a = first.posed(), b = second.posed();
    PairCounters counters;
    const bool first_is_b = choose_b(*a.body, *b.body) == 0;
    return nb::bool_(share_a_point(first_is_b ? b : a, first_is_b ? a : b, options_, counters));
  }

  // (whether they overlap, upper and lower bound of the signed distance, points on p and r and the direction from r to
  // p as rows). `depths`: whether bodies that overlap get bounds as close as they can be.
  nb::object distance(nb::handle p, nb::handle r, nb::handle pose_p, nb::handle pose_r, bool depths) const {
    Side first, second;
    if (!read(p, pose_p, first) || !read(r, pose_r, second) || are_half_spaces(first, second)) return nb::none();
    if (first.poses.are_many() || second.poses.are_many()) return nb::none();
    PairCounters counters;
    const PosedPolytope a = first.posed(), b = second.posed();
    const PairDistance found = depths ? signed_distance(a, b, counters) : pair_distance(a, b, kNoLimit, counters);
    return nb::make_tuple(found.overlap, found.upper, found.lower,
                          point_array(std::vector<Vec3>{found.on_body_a, found.on_body_b, found.direction}));
  }

 private:
  // A body with its pose, or with many.
  struct Side {
    nb::object core;  // keeps the body
    const Polytope* body = nullptr;
    double matrix[kGivenPose];  // if it has one pose
    NumpyPoses poses;

    PosedPolytope posed() const { return {body, pose_from(matrix)}; }
    GivenPoses given() const {
      return poses.are_many() ? GivenPoses{body, poses.rows(), kGivenPose} : GivenPoses{body, matrix, 0};
    }
  };

  nb::object polytope_class_, placed_class_, core_;
  nb::handle polytope_core_ = nb::type<Polytope>(), placed_core_ = nb::type<PlacedPolytope>();
  NumpyArray numpy_;
  double tolerance_;
  PairOptions options_;

  static bool are_half_spaces(const Side& a, const Side& b) {
    return !a.body->traits().is_bounded && !b.body->traits().is_bounded;
  }

  bool read(nb::handle body, nb::handle pose, Side& side) const {
    const bool is_placed = body.type().is(placed_class_);
    if (!is_placed && !body.type().is(polytope_class_)) return false;
    side.core = nb::steal(PyObject_GetAttr(body.ptr(), core_.ptr()));
    if (!side.core.is_valid()) PyErr_Clear();
    if (!side.core.is_valid() || !side.core.type().is(is_placed ? placed_core_ : polytope_core_)) return false;
    if (is_placed) {
      const auto& placed = *nb::inst_ptr<PlacedPolytope>(side.core);
      side.body = placed.body.get();
      std::copy(placed.matrix.begin(), placed.matrix.end(), side.matrix);
      return pose.is_none();
    }
    side.body = nb::inst_ptr<Polytope>(side.core);
    return read_poses(pose, side);
  }

  bool read_poses(nb::handle pose, Side& side) const {
    if (pose.is_none()) {
      std::copy(std::begin(kIdentityMatrix), std::end(kIdentityMatrix), side.matrix);
      return true;
    }
    if (!side.poses.read(numpy_, pose)) return false;
    if (side.poses.are_many()) return true;
    side.poses.copy_to(side.matrix);
    return is_surely_rigid(side.matrix, tolerance_);
  }

  nb::object intersect_many(const Side& first, const Side& second, int threads) const {
    const GivenPoses a = first.given(), b = second.given();
    const std::size_t n = a.step == 0 ? second.poses.count() : first.poses.count();
    if (a.step != 0 && b.step != 0 && second.poses.count() != n) return nb::none();
    auto shared = std::make_unique<bool[]>(std::max<std::size_t>(n, 1));
    const std::size_t parts =
        std::clamp<std::size_t>(static_cast<std::size_t>(std::max(threads, 1)), 1, std::max<std::size_t>(n, 1));
    std::atomic<bool> all_rigid{true};
    without_gil(parts, [&](std::size_t k) {
      const std::size_t start = n * k / parts, past = n * (k + 1) / parts;
      const auto from = [&](const GivenPoses& of) {
        return GivenPoses{of.body, of.matrices + start * of.step, of.step};
      };
      if (!test_given_poses(from(a), from(b), past - start, tolerance_, options_, shared.get() + start))
        all_rigid = false;
    });
    if (!all_rigid) return nb::none();
    bool* const raw = shared.release();
    const nb::capsule owner(raw, [](void* values) noexcept { delete[] static_cast<bool*>(values); });
    return nb::cast(nb::ndarray<nb::numpy, bool>(raw, {n}, owner));
  }
};

// Whether a value is surely a rigid transform in a NumPy array of doubles.
nb::object rigid_matrix_test() {
  const auto test = [array = NumpyArray()](nb::handle pose, double tolerance) {
    NumpyPoses poses;
    double matrix[kGivenPose];
    if (!poses.read(array, pose) || poses.are_many()) return false;
    poses.copy_to(matrix);
    return is_surely_rigid(matrix, tolerance);
  };
  return nb::cpp_function(test, nb::arg("pose").none(), nb::arg("tolerance"), plain_floats);
}

}  // namespace

void bind_pair_queries(nb::module_& m) {
  nb::class_<PlacedPolytope>(m, "PlacedPolytope")
      .def(
          "__init__",
          [](PlacedPolytope* self, std::shared_ptr<Polytope> body, InputArray<double, 4, 4> pose) {
            new (self) PlacedPolytope{std::move(body), {}};
            std::copy_n(pose.data(), kGivenPose, self->matrix.begin());
          },
          plain_floats);
  m.attr("is_surely_rigid") = rigid_matrix_test();
  nb::class_<PairQueries>(m, "PairQueries")
      .def(nb::init<nb::object, nb::object, double>(), plain_floats)
      .def("intersects", &PairQueries::intersects, nb::arg().none(), nb::arg().none(), nb::arg().none(),
           nb::arg().none(), nb::arg(), plain_floats)
      .def("distance", &PairQueries::distance, nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(),
           nb::arg(), plain_floats);
}

}  // namespace plannercheck
