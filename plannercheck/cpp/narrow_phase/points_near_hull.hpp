// Which of a few points lie within their radii of a posed body, exactly.
//
// In: a body at its pose, and a frame with up to eight points, each with a radius in m of the world. Out: bit k is set
// if the body, its inflation radius included, is within radius k of point k at its place in the world; touching counts.
// This is the verdict of `test_pair` for a sphere around the point, of which the frame maps only the centre. Idea: the
// points are posed in the body's frame in lanes. The body's ball, its box and the planes of facets decide points that
// are apart; a facet decides points that are inside, or near it along the ray to the centre. A descent and the exact
// test decide points in the regions of edges and vertices, and points in doubt by rounding.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

inline constexpr int kMostPoints = 8;

// One body and one frame, for any number of points.
class PointsNearHull {
 public:
  // `filters`: whether the lanes may decide; if not, every point takes the test of a pair. Verdicts are the same.
  PointsNearHull(const PosedPolytope& body, const Pose& frame, bool filters = true);

  // The bits of `count` <= kMostPoints points. Arrays need no more than `count` entries.
  unsigned near(const double* x, const double* y, const double* z, const double* radii, int count,
                PairCounters& counters);

  // A direction of the body's frame, of any length, along which points of the last call may be beyond the body: the
  // last direction that kept a point away, or from the centre to the first point.
  Vec3 beyond() const { return beyond_; }

  // The bits of the points that a ball and a box around the body leave open, in a few operations. A ball around several
  // points and their radii may stand for all of them.
  unsigned maybe_near(const double* x, const double* y, const double* z, const double* radii, int count) const;

 private:
  struct LanePoints;
  struct Verdicts;

  PosedPolytope body_;
  Pose frame_;
  bool filters_;
  PairFrame to_body_;
  double error_, error_growth_;  // of a coordinate in the body's frame: for the origin, and for each m of |point|_1
  Vec3 segment_from_, segment_direction_;  // of points and segments, relative to the centre
  Vec3 last_plane_;                        // a facet, beyond which points were found; 0 if none was
  Vec3 beyond_;

  LanePoints in_lanes(const double* x, const double* y, const double* z, const double* radii) const;
  LanePoints given(const double* x, const double* y, const double* z, const double* radii, int count) const;
  void decide(const LanePoints& points, Verdicts& verdicts, PairCounters& counters);
  void by_ball_and_box(const LanePoints& points, Verdicts& verdicts) const;
  void by_segment(const LanePoints& points, Verdicts& verdicts) const;
  void by_plane(Vec3 plane, const LanePoints& points, Verdicts& verdicts);
  void by_facets(const LanePoints& points, Verdicts& verdicts, PairCounters& counters);
  bool is_near(Vec3 point, double radius, PairCounters& counters);
};

// PointsNearHull::near, for a single call.
unsigned points_near_hull(const PosedPolytope& body, const Pose& frame, const double* x, const double* y,
                          const double* z, const double* radii, int count, PairCounters& counters);

}  // namespace plannercheck
