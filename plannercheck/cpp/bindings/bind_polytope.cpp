// Bodies and single pairs in Python.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <array>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "bindings/verdict_dicts.hpp"
#include "bodies/half_space.hpp"
#include "bodies/polytope.hpp"
#include "math/predicates.hpp"
#include "narrow_phase/pair_batch.hpp"
#include "narrow_phase/shared_point.hpp"
#include "narrow_phase/solid_pair.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

std::shared_ptr<Polytope> inflated(Polytope body, double inflation_radius) {
  body.inflation_radius = inflation_radius;
  return std::make_shared<Polytope>(std::move(body));
}

std::shared_ptr<Polytope> polytope_from_points(InputArray<double, -1, 3> vertices, double inflation_radius) {
  const std::vector<Vec3> points = points_from(vertices);
  std::shared_ptr<Polytope> body;
  without_gil([&] { body = inflated(prepare_polytope(points), inflation_radius); });
  return body;
}

std::shared_ptr<Polytope> polytope_from_faces(InputArray<double, -1, 3> vertices, InputArray<std::int32_t, -1, 3> faces,
                                              double inflation_radius) {
  const std::vector<Vec3> points = points_from(vertices);
  const std::vector<Triangle> triangles = triples_from(faces);
  std::shared_ptr<Polytope> body;
  without_gil([&] { body = inflated(prepare_polytope(verified_hull(points, triangles)), inflation_radius); });
  return body;
}

std::shared_ptr<Polytope> polytope_from_bytes(nb::bytes data) {
  return std::make_shared<Polytope>(parse_polytope(static_cast<const char*>(data.data()), data.size()));
}

nb::bytes bytes_of(const Polytope& body) {
  const std::string data = serialise(body);
  return nb::bytes(data.data(), data.size());
}

// The polytopes of n boxes of these full edge lengths; equal boxes share one. None where a box has no hull with volume.
// signs: (8, 3) of the corners, in the order to which `faces` refer.
nb::list polytopes_of_boxes(InputArray<double, -1, 3> sizes, InputArray<double, -1> inflation_radii,
                            InputArray<double, 8, 3> signs, InputArray<std::int32_t, -1, 3> faces) {
  if (inflation_radii.shape(0) != sizes.shape(0))
    throw std::invalid_argument("sizes and radii are not of as many boxes");
  const std::vector<Triangle> triangles = triples_from(faces);
  std::map<std::array<double, 4>, std::shared_ptr<Polytope>> known;
  std::vector<std::shared_ptr<Polytope>> bodies(sizes.shape(0));
  without_gil([&] {
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      if (k > 0) poll_interruption();
      const std::array<double, 4> key{sizes(k, 0), sizes(k, 1), sizes(k, 2), inflation_radii(k)};
      const auto [place, is_new] = known.try_emplace(key);
      if (is_new) {
        std::vector<Vec3> corners;
        for (std::size_t c = 0; c < 8; ++c)
          corners.push_back({signs(c, 0) * (key[0] / 2), signs(c, 1) * (key[1] / 2), signs(c, 2) * (key[2] / 2)});
        try {
          place->second = inflated(prepare_polytope(verified_hull(corners, triangles)), key[3]);
        } catch (const HullError&) {  // None
        }
      }
      bodies[k] = place->second;
    }
  });
  nb::list out;
  for (std::shared_ptr<Polytope>& body : bodies) out.append(body == nullptr ? nb::none() : nb::cast(std::move(body)));
  return out;
}

nb::dict shape_of(const Hierarchy& h) {
  nb::dict out;
  std::int32_t longest = 0;
  for (const ChainRange& chain : h.chains) longest = std::max(longest, chain.length);
  out["vertices"] = h.points.size();
  out["levels"] = h.depth + 1;
  out["longest_chain"] = longest;
  out["fans"] = h.fans.size();
  out["bytes"] = h.bytes();
  return out;
}

auto vertices_of(const Polytope& b) { return point_array(b.inner.points); }
auto triangles_of(const Polytope& b) {
  std::vector<std::int32_t> flat;
  for (const Triangle& t : b.triangles) flat.insert(flat.end(), t.begin(), t.end());
  return output_array(flat, {b.triangles.size(), std::size_t{3}});
}
auto source_of(const Polytope& b) { return output_array(b.source, {b.source.size()}); }
auto polar_points_of(const Polytope& b) { return point_array(b.polar.points); }
auto centre_of(const Polytope& b) { return point_array(std::vector<Vec3>{b.centre}); }
auto inner_shape_of(const Polytope& b) { return shape_of(b.inner); }
auto polar_shape_of(const Polytope& b) { return shape_of(b.polar); }

// For each vertex the level at which it is removed.
auto levels_of(const Polytope& b, bool of_polar) {
  const Hierarchy& h = of_polar ? b.polar : b.inner;
  return output_array(h.level, {h.level.size()});
}

// A scan on rounded products may have stopped at a vertex that is extreme up to kScanError: compares it with all.
std::int32_t surely_extreme(const Hierarchy& h, std::int32_t v, Vec3 u) {
  for (const std::int32_t other : h.top) {
    if (compare_along(u, h.points[static_cast<std::size_t>(other)], h.points[static_cast<std::size_t>(v)]) > 0)
      v = other;
  }
  return v;
}

// Balls (k, 4), centre and radius, and the rounded box (1, 7), two corners and radius, or (0, 7).
nb::tuple inner_shapes_of(const Polytope& body) {
  const InnerShapes& shapes = body.inner_shapes();
  std::vector<double> balls, box;
  for (const InnerBall& b : shapes.balls) balls.insert(balls.end(), {b.centre.x, b.centre.y, b.centre.z, b.radius});
  if (shapes.box) {
    const InnerBox& b = *shapes.box;
    box = {b.low.x, b.low.y, b.low.z, b.high.x, b.high.y, b.high.z, b.radius};
  }
  return nb::make_tuple(output_array(balls, {shapes.balls.size(), std::size_t{4}}),
                        output_array(box, {box.size() / 7, std::size_t{7}}));
}

// Centres and radii (n, 4); `few`: of two or three at most.
auto covering_balls_of(const Polytope& body, bool few) {
  std::vector<double> balls;
  for (const SmallBall& b : few ? body.few_covering_balls() : body.covering_balls())
    balls.insert(balls.end(), {b.centre.x, b.centre.y, b.centre.z, b.radius});
  return output_array(balls, {balls.size() / 4, std::size_t{4}});
}

// A copy without cells of directions, whose extreme vertices are found by hierarchies alone: for tests that compare
// both.
std::shared_ptr<Polytope> without_cells(const Polytope& body) {
  auto out = std::make_shared<Polytope>(body);
  for (Hierarchy* const h : {&out->inner, &out->polar}) h->cells = {}, h->top_levels.cells = {};
  return out;
}

// The extreme vertex along each direction, exactly, and the blocks each query visited.
nb::tuple extremes(const Polytope& body, InputArray<double, -1, 3> directions, bool of_polar) {
  const Hierarchy& h = of_polar ? body.polar : body.inner;
  std::vector<std::int32_t> vertices(directions.shape(0)), blocks(directions.shape(0));
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    QueryCounters counters;
    const Vec3 u{directions(i, 0), directions(i, 1), directions(i, 2)};
    vertices[i] = extreme(h, u, counters);
    if (h.depth == 0) vertices[i] = surely_extreme(h, vertices[i], u);
    blocks[i] = static_cast<std::int32_t>(counters.blocks);
  }
  return nb::make_tuple(output_array(vertices, {vertices.size()}), output_array(blocks, {blocks.size()}));
}

// Pairs of poses of the same two bodies; a single pose goes with all of the other's.
class PosedRows : public PairBatch {
 public:
  PosedRows(const Polytope& a, PoseRows poses_a, const Polytope& b, PoseRows poses_b)
      : size_(std::max(poses_a.shape(0), poses_b.shape(0))),
        first_is_b_(choose_b(a, b) == 0),
        body_a_(first_is_b_ ? Side{&b, poses_b} : Side{&a, poses_a}),
        body_b_(first_is_b_ ? Side{&a, poses_a} : Side{&b, poses_b}) {}

  std::size_t size() const { return size_; }
  bool first_is_a() const { return !first_is_b_; }
  PosedPolytope body_a(std::size_t i) const final { return {body_a_.body, pose_at(body_a_.poses, i)}; }
  PosedPolytope body_b(std::size_t i) const final { return {body_b_.body, pose_at(body_b_.poses, i)}; }

  void test(const PairOptions& options, PairCounters& counters) {
    test_pairs(*body_a_.body, *body_b_.body, size_, options, *this, counters);
  }

 private:
  struct Side {
    const Polytope* body;
    PoseRows poses;
  };

  std::size_t size_;
  bool first_is_b_;
  Side body_a_, body_b_;
};

class VerdictRows final : public PosedRows {
 public:
  std::vector<std::uint8_t> shared = std::vector<std::uint8_t>(size()), stages = shared;

  using PosedRows::PosedRows;
  void take(std::size_t i, const PairVerdict& verdict) final {
    shared[i] = verdict.shared;
    stages[i] = static_cast<std::uint8_t>(verdict.stage);
  }
  void take_far(std::size_t i, const CentreAxis&) final { stages[i] = static_cast<std::uint8_t>(Stage::kCentreAxis); }
};

class CertifiedRows final : public PosedRows {
 public:
  std::vector<PairVerdict> verdicts = std::vector<PairVerdict>(size());

  using PosedRows::PosedRows;
  void take(std::size_t i, const PairVerdict& verdict) final { verdicts[i] = verdict; }
};

// Verdicts for n pairs of poses of the same two bodies; stages and counters of all of them.
nb::tuple intersect_batch(const Polytope& a, PoseRows poses_a, const Polytope& b, PoseRows poses_b,
                          const PairOptions& options) {
  VerdictRows rows(a, poses_a, b, poses_b);
  PairCounters counters;
  without_gil([&] { rows.test(options, counters); });
  return nb::make_tuple(output_array(rows.shared, {rows.size()}), output_array(rows.stages, {rows.size()}),
                        counters_dict(counters));
}

// As certify_pair, for each of n pairs of poses.
nb::list certify_batch(const Polytope& a, PoseRows poses_a, const Polytope& b, PoseRows poses_b,
                       const PairOptions& options) {
  CertifiedRows rows(a, poses_a, b, poses_b);
  PairCounters counters;
  without_gil([&] { rows.test(options, counters); });
  nb::list out;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    out.append(verdict_dict(rows.verdicts[i], rows.body_a(i), rows.body_b(i), rows.first_is_a()));
  }
  return out;
}

nb::dict certify_pair(const Polytope& a, InputArray<double, 4, 4> pose_a, const Polytope& b,
                      InputArray<double, 4, 4> pose_b, const PairOptions& options, bool explain) {
  const PosedPolytope pa{&a, pose_from(pose_a.data())}, pb{&b, pose_from(pose_b.data())};
  const bool first_is_b = choose_b(a, b) == 0;
  PairCounters counters;
  const PosedPolytope &body_a = first_is_b ? pb : pa, &body_b = first_is_b ? pa : pb;
  if (!a.traits().is_bounded || !b.traits().is_bounded)
    throw nb::value_error("a half-space has certificates of its own");
  PairVerdict verdict = test_pair(body_a, body_b, options, nullptr, counters);
  verdict.shared = bodies_share(verdict, body_a, body_b, counters);
  if (explain && verdict.shared && !verdict.exact) {
    // The vertices and weights behind a shared point come from the exact stage.
    verdict.exact = exact_contact(body_a, body_b, verdict, counters);
  }
  return verdict_dict(verdict, body_a, body_b, !first_is_b);
}

constexpr KindTable<const char*> kKindNames{"hull", "solid", "part_set", "half_space"};

// What the body is besides its hull: a solid, a set of parts, or the normal and offset of a half-space; None for hulls.
nb::object body_shape(const Polytope& body) {
  const auto object = [](const auto& shape) -> nb::object {
    using Shape = std::decay_t<decltype(shape)>;
    if constexpr (std::is_same_v<Shape, std::monostate>) {
      return nb::none();
    } else if constexpr (std::is_same_v<Shape, std::shared_ptr<const HalfSpace>>) {
      return nb::make_tuple(nb::make_tuple(shape->normal.x, shape->normal.y, shape->normal.z), shape->offset);
    } else {
      return nb::cast(std::const_pointer_cast<std::remove_const_t<typename Shape::element_type>>(shape));
    }
  };
  return std::visit(object, body.shape);
}

}  // namespace

void bind_polytope(nb::module_& m) {
  m.attr("body_format") = kPolytopeFormat;
  nb::exception<HullError>(m, "HullError", PyExc_ValueError);

  nb::class_<Polytope>(m, "Polytope")
      .def_static("from_points", &polytope_from_points, plain_floats)
      .def_static("from_faces", &polytope_from_faces, plain_floats)
      .def_static("of_boxes", &polytopes_of_boxes, plain_floats)
      .def_static("parse", &polytope_from_bytes, plain_floats)
      .def("serialise", &bytes_of, plain_floats)
      .def("vertices", &vertices_of, plain_floats)
      .def("triangles", &triangles_of, plain_floats)
      .def("source", &source_of, plain_floats)
      .def("polar_points", &polar_points_of, plain_floats)
      .def("levels", &levels_of, plain_floats)
      .def("centre", &centre_of, plain_floats)
      .def("inner_shapes", &inner_shapes_of, plain_floats)
      .def("covering_balls", &covering_balls_of, nb::arg("few") = false, plain_floats)
      .def("inner_shape", &inner_shape_of, plain_floats)
      .def("polar_shape", &polar_shape_of, plain_floats)
      .def_ro("facets", &Polytope::facet_count)
      .def_ro("radius", &Polytope::radius)
      .def_ro("origin_radius", &Polytope::origin_radius)
      .def_ro("dimension", &Polytope::dimension)
      .def_ro("inflation_radius", &Polytope::inflation_radius)
      .def("bytes", &Polytope::bytes, plain_floats)
      .def("fault", &polytope_fault, plain_floats)
      .def("without_cells", &without_cells, plain_floats)
      .def(
          "with_solid",
          [](const Polytope& b, std::shared_ptr<Solid> solid) {
            return std::make_shared<Polytope>(with_solid(b, std::move(solid)));
          },
          plain_floats)
      .def(
          "surface", [](const Polytope& b) { return std::make_shared<Solid>(b.surface()); }, plain_floats)
      .def_prop_ro("dent", [](const Polytope& b) { return b.dents.deepest; })
      .def_prop_ro("kind", [](const Polytope& b) { return kKindNames[b.kind()]; })
      .def_prop_ro("shape", &body_shape)
      .def_static(
          "of_half_space",
          [](InputArray<double, 3> normal, double offset, double inflation_radius) {
            const HalfSpace half_space{{normal(0), normal(1), normal(2)}, offset};
            return std::make_shared<Polytope>(polytope_of(half_space, inflation_radius));
          },
          plain_floats)
      .def("extremes", &extremes, plain_floats);

  m.def("intersect_batch", &intersect_batch, plain_floats);
  m.def("certify_batch", &certify_batch, plain_floats);
  m.def("certify_pair", &certify_pair, plain_floats);
}

}  // namespace plannercheck
