#include "narrow_phase/simplex_double_double.hpp"

namespace plannercheck {
namespace {

// The projection of the origin on the span of a set's corners; false unless it lies inside their hull.
class Projection {
 public:
  Projection(const FineSimplex& simplex, unsigned set) {
    face_.set = set;
    for (std::size_t i = 0; i < static_cast<std::size_t>(simplex.count); ++i) {
      if ((set >> i & 1U) != 0) p_[n_++] = &simplex.corner[i].difference;
    }
  }

  bool run() { return n_ == 1 ? point() : n_ == 2 ? segment() : n_ == 3 ? triangle() : tetrahedron(); }
  const FineFace& face() const { return face_; }

 private:
  std::array<const DoubleDoubleVec3*, 4> p_{};
  std::size_t n_ = 0;
  FineFace face_;

  bool point() {
    face_.weight[0] = {1, 0};
    face_.towards = *p_[0];
    face_.square = dot(rounded(*p_[0]), rounded(*p_[0]));
    return true;
  }

  bool segment() {
    const DoubleDoubleVec3 e = *p_[1] - *p_[0];
    const DoubleDouble along = -dot(*p_[0], e), rest = dot(*p_[1], e);
    if (!positive(along) || !positive(rest)) return false;
    face_.weight = {rest, along};
    face_.towards = rest * *p_[0] + along * *p_[1];
    const double whole = rest.high + along.high;
    face_.square = dot(rounded(face_.towards), rounded(face_.towards)) / (whole * whole);
    return true;
  }

  bool triangle() {
    const DoubleDoubleVec3 n = cross(*p_[1] - *p_[0], *p_[2] - *p_[0]);
    face_.weight = {dot(n, cross(*p_[1], *p_[2])), dot(n, cross(*p_[2], *p_[0])), dot(n, cross(*p_[0], *p_[1]))};
    for (std::size_t i = 0; i < 3; ++i) {
      if (!positive(face_.weight[i])) return false;
    }
    const double height = dot(n, *p_[0]).high;
    face_.towards = height < 0 ? -n : n;
    face_.square = height * height / dot(rounded(n), rounded(n));
    return true;
  }

  bool tetrahedron() {
    const DoubleDoubleVec3 cd = cross(*p_[2], *p_[3]), ab = cross(*p_[0], *p_[1]);
    face_.weight = {dot(*p_[1], cd), -dot(*p_[0], cd), dot(*p_[3], ab), -dot(*p_[2], ab)};
    if (face_.weight[0].high < 0) {
      for (DoubleDouble& w : face_.weight) w = -w;
    }
    face_.square = 0;
    return positive(face_.weight[0]) && positive(face_.weight[1]) && positive(face_.weight[2]) &&
           positive(face_.weight[3]);
  }
};

}  // namespace

FineFace nearest_face(const FineSimplex& simplex, unsigned needed) {
  FineFace best;
  for (unsigned set = 1; set < 1U << simplex.count; ++set) {
    if ((set & needed) != needed) continue;
    Projection projection(simplex, set);
    if (projection.run() && projection.face().square < best.square) best = projection.face();
  }
  return best;
}

}  // namespace plannercheck
