// A posed mesh's vertices, as intervals and as whole numbers; signs of polynomials of them.
//
// In: a mesh and a pose. Out: for each vertex an interval a coordinate, m, and, made when first asked for, the exact
// coordinates in units of 2^unit m; the sign of a polynomial, from intervals if they decide it, else from whole
// numbers. Polynomials are of differences of vertices: intervals are relative to the origin of the second mesh's pose.
#pragma once

#include <memory>
#include <vector>

#include "oracle/interval.hpp"
#include "oracle/mesh.hpp"

namespace plannercheck::oracle {

class PosedMesh {
 public:
  // `pose`: row-major 4x4; `origin`: three coordinates that intervals are without. Needs RoundedUpwards.
  PosedMesh(const Mesh& mesh, const double* pose, const double* origin);

  const Mesh& mesh() const { return *mesh_; }
  bool fits_intervals() const { return fits_intervals_; }
  int unit() const { return posed_.unit(); }
  // Before the first use of `exactly`; `unit` has to be at most the current one.
  void use_unit(int unit) { posed_.use_unit(unit); }

  const IntervalVector& about(std::uint32_t vertex) const { return about_[vertex]; }
  const Vector& exactly(std::uint32_t vertex) const;
  Integer inflation_radius() const { return posed_.inflation_radius(); }

 private:
  const Mesh* mesh_;
  PosedPoints posed_;
  std::vector<IntervalVector> about_;
  mutable std::vector<std::unique_ptr<Vector>> exactly_;
  bool fits_intervals_;
};

struct Corner {
  const PosedMesh* of;
  std::uint32_t vertex;
};

using Triangle = std::array<Corner, 3>;

inline Triangle triangle_of(const PosedMesh& posed, std::size_t index) {
  const auto& [a, b, c] = posed.mesh().triangles[index];
  return {Corner{&posed, a}, Corner{&posed, b}, Corner{&posed, c}};
}

// Two posed meshes in a common unit.
class MeshPair {
 public:
  // `every`: nothing is left to intervals.
  MeshPair(const Mesh& p, const double* pose_p, const Mesh& r, const double* pose_r, bool every);

  PosedMesh p, r;

  bool uses_intervals() const { return uses_intervals_; }
  // The sum of the inflation radii.
  const Interval& radius_about() const { return radius_about_; }
  const Integer& radius_exactly() const { return radius_exactly_; }

  // The sign of a polynomial. It is called with an object `at`: at(corner) is a vector, at.radius() the sum of the
  // inflation radii, both intervals or both whole numbers.
  template <class Polynomial>
  int sign(const Polynomial& polynomial) const {
    if (uses_intervals_) {
      const Interval value = polynomial(About{*this});
      if (value.low() > 0) return 1;
      if (value.high < 0) return -1;
      if (value.low() == 0 && value.high == 0) return 0;
    }
    return polynomial(Exactly{*this}).sign();
  }

 private:
  struct About {
    const MeshPair& pair;
    const IntervalVector& operator()(const Corner& c) const { return c.of->about(c.vertex); }
    const Interval& radius() const { return pair.radius_about_; }
  };
  struct Exactly {
    const MeshPair& pair;
    const Vector& operator()(const Corner& c) const { return c.of->exactly(c.vertex); }
    const Integer& radius() const { return pair.radius_exactly_; }
  };

  bool uses_intervals_;
  Interval radius_about_;
  Integer radius_exactly_;
};

}  // namespace plannercheck::oracle
