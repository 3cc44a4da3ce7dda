#include "bodies/quickhull.hpp"

#include <cstdint>
#include <utility>

#include "bodies/affine_dimension.hpp"
#include "math/interruption.hpp"
#include "math/predicates.hpp"

namespace plannercheck {
namespace {

struct Face {
  Triangle corner{};
  Triangle neighbour{-1, -1, -1};
  std::vector<int> outside;  // points strictly above this face, each in the list of one face
  bool alive = true;
  int visited = -1;  // number of the last search that saw this face
  bool visible = false;
};

struct HorizonEdge {
  int from, to;  // counter-clockwise around the visible region
  int beyond;    // the face on the far side, which stays
};

class Quickhull {
 public:
  explicit Quickhull(const std::vector<Vec3>& points) : points_(points), starts_at_(points.size(), -1) {}

  TriangleSurface run() {
    start();
    while (!pending_.empty()) {
      poll_interruption();
      std::swap(pending_[draw(pending_.size())], pending_.back());
      const int face = pending_.back();
      pending_.pop_back();
      if (faces_[at(face)].alive && !faces_[at(face)].outside.empty()) add(face);
    }
    return surface();
  }

 private:
  const std::vector<Vec3>& points_;
  std::vector<Face> faces_;
  std::vector<int> pending_;
  std::vector<int> visible_, orphans_, created_;
  std::vector<HorizonEdge> horizon_;
  std::vector<int> starts_at_;  // the new face whose horizon edge starts at a point
  int searches_ = 0;
  std::uint32_t draws_ = 0;

  Vec3 point(int index) const { return points_[at(index)]; }

  // A fixed sequence, so that equal points give equal meshes.
  std::size_t draw(std::size_t count) { return ++draws_ * 2654435761U % count; }

  TriangleSurface surface() const {
    TriangleSurface out;
    std::vector<int> number(faces_.size(), -1);
    int alive = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (faces_[f].alive) number[f] = alive++;
    }
    for (const Face& face : faces_) {
      if (!face.alive) continue;
      out.triangles.push_back(face.corner);
      out.neighbours.push_back(
          {number[at(face.neighbour[0])], number[at(face.neighbour[1])], number[at(face.neighbour[2])]});
    }
    return out;
  }

  bool sees(int p, const Face& face) const {
    if (p == face.corner[0] || p == face.corner[1] || p == face.corner[2]) return false;  // avoids an exact zero
    return orientation(point(face.corner[0]), point(face.corner[1]), point(face.corner[2]), point(p)) > 0;
  }

  int new_face(int a, int b, int c) {
    Face face;
    face.corner = {a, b, c};
    faces_.push_back(std::move(face));
    return static_cast<int>(faces_.size()) - 1;
  }

  void start() {
    const AffineSpan span = affine_span(points_);
    if (span.dimension < 3) throw HullError("its points have no volume");
    const auto [a, b, c, d] = span.index;
    if (orientation(point(a), point(b), point(c), point(d)) > 0) {
      create_tetrahedron(a, c, b, d);
    } else {
      create_tetrahedron(a, b, c, d);
    }
  }

  // Triangle a b c, with d below it.
  void create_tetrahedron(int a, int b, int c, int d) {
    new_face(a, b, c);
    new_face(b, a, d);
    new_face(c, b, d);
    new_face(a, c, d);
    faces_[0].neighbour = {1, 2, 3};
    faces_[1].neighbour = {0, 3, 2};
    faces_[2].neighbour = {0, 1, 3};
    faces_[3].neighbour = {0, 2, 1};
    orphans_ = indices_below(points_.size());
    created_ = {0, 1, 2, 3};
    adopt_orphans();
  }

  // A point of a removed face that is still outside lies above a new face. On the way from the removed face to a face
  // that the point sees, it crosses the horizon, where the new face's plane lies between the two old ones.
  void adopt_orphans() {
    for (const int p : orphans_) {
      for (const int face : created_) {
        if (!sees(p, faces_[at(face)])) continue;
        faces_[at(face)].outside.push_back(p);
        break;
      }
    }
    for (const int face : created_) {
      if (!faces_[at(face)].outside.empty()) pending_.push_back(face);
    }
  }

  void add(int face) {
    const int apex = faces_[at(face)].outside[draw(faces_[at(face)].outside.size())];
    find_visible(face, apex);
    orphans_.clear();
    for (const int v : visible_) {
      orphans_.insert(orphans_.end(), faces_[at(v)].outside.begin(), faces_[at(v)].outside.end());
      faces_[at(v)].outside = {};
      faces_[at(v)].alive = false;
    }
    create_cone(apex);
    adopt_orphans();
  }

  void find_visible(int face, int apex) {
    ++searches_;
    visible_ = {face};
    horizon_.clear();
    faces_[at(face)].visited = searches_;
    faces_[at(face)].visible = true;
    for (std::size_t next = 0; next < visible_.size(); ++next) {
      const Face& current = faces_[at(visible_[next])];
      for (int i = 0; i < 3; ++i) {
        const int beyond = current.neighbour[at(i)];
        Face& neighbour = faces_[at(beyond)];
        if (neighbour.visited != searches_) {
          neighbour.visited = searches_;
          neighbour.visible = sees(apex, neighbour);
          if (neighbour.visible) visible_.push_back(beyond);
        }
        if (!neighbour.visible) {
          horizon_.push_back({current.corner[at(i)], current.corner[at(next_corner(i))], beyond});
        }
      }
    }
  }

  void create_cone(int apex) {
    created_.clear();
    for (const HorizonEdge& edge : horizon_) {
      const int face = new_face(edge.from, edge.to, apex);
      created_.push_back(face);
      starts_at_[at(edge.from)] = face;
      Face& beyond = faces_[at(edge.beyond)];
      for (int i = 0; i < 3; ++i) {
        if (beyond.corner[at(i)] == edge.to && beyond.corner[at(next_corner(i))] == edge.from) {
          beyond.neighbour[at(i)] = face;
        }
      }
      faces_[at(face)].neighbour[0] = edge.beyond;
    }
    for (const int face : created_) {
      const int following = starts_at_[at(faces_[at(face)].corner[1])];
      faces_[at(face)].neighbour[1] = following;
      faces_[at(following)].neighbour[2] = face;
    }
  }
};

}  // namespace

TriangleSurface quickhull(const std::vector<Vec3>& points) { return Quickhull(points).run(); }

}  // namespace plannercheck
