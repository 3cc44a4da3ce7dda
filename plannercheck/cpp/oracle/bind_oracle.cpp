// The oracle's Python module, which decides whether the core is right. It contains no code of the core.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <tuple>

#include "oracle/given_arrays.hpp"
#include "oracle/proofs.hpp"

namespace nb = nanobind;

namespace plannercheck::oracle {
namespace {

using Number = std::pair<std::string, int>;  // hexadecimal digits, and the power of two by which they are multiplied
using Weights = std::vector<Number>;

// Far beyond any double or product of a few; a larger exponent is a mistake.
constexpr int kLargestExponent = 100'000;

Points points_of(Doubles<-1, 3> vertices, double inflation_radius) {
  check_finite(vertices.data(), 3 * vertices.shape(0), "vertices");
  check_finite(&inflation_radius, 1, "the inflation radius");
  if (vertices.shape(0) == 0 || inflation_radius < 0)
    throw std::invalid_argument("at least one vertex, and an inflation radius of at least 0");
  return Points(vertices.data(), vertices.shape(0), inflation_radius);
}

Pair pair_of(const Points& p, Doubles<4, 4> pose_p, const Points& r, Doubles<4, 4> pose_r) {
  check_finite(pose_p.data(), kPoseNumbers, "poses"), check_finite(pose_r.data(), kPoseNumbers, "poses");
  return {PosedPoints(p, pose_p.data()), PosedPoints(r, pose_r.data())};
}

// Numbers as integers in a common unit, which changes no proof.
std::vector<Integer> in_common_unit(const std::vector<Number>& numbers) {
  int least = kLargestExponent;
  for (const Number& number : numbers) {
    if (std::abs(number.second) > kLargestExponent) throw std::invalid_argument("an exponent is too large");
    least = std::min(least, number.second);
  }
  std::vector<Integer> out;
  for (const Number& number : numbers)
    out.push_back(Integer(number.first) << static_cast<std::size_t>(number.second - least));
  return out;
}

// Verdicts (n,): 1 shared, 0 apart, 2 if no proof was found.
Verdicts decide_verdicts(const Points& p, Doubles<-1, 4, 4> poses_p, const Points& r, Doubles<-1, 4, 4> poses_r,
                         bool every) {
  const std::size_t count = poses_p.shape(0);
  if (poses_r.shape(0) != count) throw std::invalid_argument("as many poses of one body as of the other");
  check_finite(poses_p.data(), kPoseNumbers * count, "poses"),
      check_finite(poses_r.data(), kPoseNumbers * count, "poses");
  auto verdicts = std::make_unique<std::uint8_t[]>(std::max<std::size_t>(count, 1));
  {
    const GilReleased released;
    for (std::size_t i = 0; i < count; ++i) {
      const Pair pair{PosedPoints(p, poses_p.data() + kPoseNumbers * i),
                      PosedPoints(r, poses_r.data() + kPoseNumbers * i)};
      const Proof::Kind kind = prove(pair, every).kind;
      verdicts[i] = kind == Proof::Kind::kShared ? 1 : kind == Proof::Kind::kApart ? 0 : 2;
    }
  }
  return as_array(std::move(verdicts), count);
}

// (direction, first, second, weights): digits of integers; empty if not part of this kind of proof.
std::tuple<std::vector<std::string>, std::vector<std::size_t>, std::vector<std::size_t>, std::vector<std::string>>
proof(const Points& p, Doubles<4, 4> pose_p, const Points& r, Doubles<4, 4> pose_r) {
  const Proof found = prove(pair_of(p, pose_p, r, pose_r), true);
  std::vector<std::string> direction, weights;
  if (found.kind == Proof::Kind::kApart)
    direction = {found.direction.x.hexadecimal(), found.direction.y.hexadecimal(), found.direction.z.hexadecimal()};
  for (const Integer& w : found.mixture.weights) weights.push_back(w.hexadecimal());
  return {direction, found.mixture.first, found.mixture.second, weights};
}

bool separates(const Points& p, Doubles<4, 4> pose_p, const Points& r, Doubles<4, 4> pose_r,
               const std::vector<Number>& direction, bool every) {
  if (direction.size() != 3) throw std::invalid_argument("a direction has three numbers");
  const std::vector<Integer> d = in_common_unit(direction);
  return proves_apart(pair_of(p, pose_p, r, pose_r), {d[0], d[1], d[2]}, every);
}

bool shares(const Points& p, Doubles<4, 4> pose_p, const Points& r, Doubles<4, 4> pose_r,
            std::vector<std::size_t> first, std::vector<std::size_t> second, const Weights& weights) {
  return proves_shared(pair_of(p, pose_p, r, pose_r), {std::move(first), std::move(second), in_common_unit(weights)});
}

// a · b + c, as digits, to test the arithmetic.
std::string multiplied_and_added(const std::string& a, const std::string& b, const std::string& c) {
  return (Integer(a) * Integer(b) + Integer(c)).hexadecimal();
}

}  // namespace
}  // namespace plannercheck::oracle

NB_MODULE(_oracle, m) {
  using namespace plannercheck::oracle;
  nb::set_leak_warnings(false);
  nb::class_<Points>(m, "Points")
      .def(
          "__init__",
          [](Points* self, Doubles<-1, 3> vertices, double inflation_radius) {
            new (self) Points(points_of(vertices, inflation_radius));
          },
          nb::arg("vertices"), nb::arg("inflation_radius"));
  m.def("decide", &decide_verdicts, nb::arg("p"), nb::arg("poses_p"), nb::arg("r"), nb::arg("poses_r"),
        nb::arg("every"));
  m.def("proof", &proof, nb::arg("p"), nb::arg("pose_p"), nb::arg("r"), nb::arg("pose_r"));
  m.def("separates", &separates, nb::arg("p"), nb::arg("pose_p"), nb::arg("r"), nb::arg("pose_r"), nb::arg("direction"),
        nb::arg("every"));
  m.def("shares", &shares, nb::arg("p"), nb::arg("pose_p"), nb::arg("r"), nb::arg("pose_r"), nb::arg("first"),
        nb::arg("second"), nb::arg("weights"));
  bind_meshes(m);
  m.def("multiplied_and_added", &multiplied_and_added, nb::arg("a"), nb::arg("b"), nb::arg("c"));
}
