// A closed surface of triangles that grows inside a convex body, in doubles (the expanding polytope of van den Bergen
// 2001).
//
// In: corners of a body. Out: the triangle whose plane is nearest to the origin, and a proved lower bound of the
// distance of the body's boundary from the origin. Idea: a corner beyond a triangle replaces all triangles that it
// sees by a cone over their horizon. The surface is closed and oriented by construction, whatever the rounding. If the
// origin is below the planes of all its triangles, by h at least, the surface winds around the origin, and no triangle
// comes nearer than h; so it winds around every point of the ball of radius h, and this ball is in the corners' hull.
// Neither convexity of the surface nor any sign that was rounded on the way enters this proof.
#pragma once

#include <array>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

// The plane through three points, counter-clockwise from outside, computed in double-double.
struct FinePlane {
  Vec3 normal;        // outward, of length 1 up to rounding; 0 if the points are on a line as far as that tells
  double height = 0;  // the origin is at least that far below the plane, if that is above 0

  FinePlane(Vec3 a, Vec3 b, Vec3 c);
};

class ExpandingPolytope {
 public:
  struct Plane {
    Vec3 normal;  // outward, of length 1 up to rounding; 0 for a face without area, which is never seen
    double offset = 0;
  };

  // Starts with a tetrahedron of any orientation. `tie`: corners are beyond a plane that are further above it.
  void start(const std::array<Vec3, 4>& corners, double tie);

  // The face of least height. The origin is at least that far below the exact planes of all faces.
  std::int32_t nearest() const;
  std::int32_t face_count() const { return static_cast<std::int32_t>(faces_.size()); }
  double height(std::int32_t f) const { return heights_[at(f)]; }  // infinite where a face was removed
  const Plane& plane(std::int32_t f) const { return planes_[at(f)]; }
  bool is_refined(std::int32_t f) const { return faces_[at(f)].refined; }
  const std::array<std::int32_t, 3>& corners(std::int32_t f) const { return faces_[at(f)].corner; }
  Vec3 point(std::int32_t corner) const { return points_[at(corner)]; }

  // Adds a corner beyond a face; false if doubles do not tell one horizon, which leaves the surface open.
  bool expand(std::int32_t from, Vec3 corner);

  // Computes the plane of a face anew, in double-double.
  void refine(std::int32_t f);

 private:
  struct Face {
    std::array<std::int32_t, 3> corner, across;  // counter-clockwise from outside; the faces beyond the edges
    std::array<std::int8_t, 3> across_edge;      // which edge of the other face that is
    bool alive, refined;
  };
  struct HorizonEdge {
    std::int32_t face, edge;  // of the face beyond it, which stays
  };
  // Corners along the horizon from its apex, and planes through each two of them and the apex.
  static constexpr std::size_t kFan = 16;
  struct Fan {
    std::array<double, kFan + 1> x, y, z;
    std::array<double, kFan> normal_x, normal_y, normal_z, offset, height;

    void put(std::size_t k, Vec3 v) { x[k] = v.x, y[k] = v.y, z[k] = v.z; }
    void find_planes(Vec3 apex, std::size_t count);
  };

  std::vector<Vec3> points_;
  std::vector<Face> faces_;
  std::vector<Plane> planes_;    // of each face
  std::vector<double> heights_;  // of each face
  std::vector<std::int32_t> unused_;
  std::vector<HorizonEdge> horizon_;
  Fan fan_;
  double tie_ = 0;

  std::int32_t new_face(const std::array<std::int32_t, 3>& corner);
  void remove(std::int32_t f);
  void set_plane(std::int32_t f, std::size_t in_fan);
  void link(std::int32_t f, std::size_t edge, std::int32_t other, std::size_t other_edge);
  void find_horizon(std::int32_t f, std::int32_t edge, Vec3 corner);
  bool is_one_circuit() const;
};

}  // namespace plannercheck
