// A body that is the union of many small convex parts of one kind, as sensors see a scene, with a tree over them.
//
// In: points with radii (balls), cells of a lattice (boxes), or heights over a lattice (prisms). Out: the parts in the
// order of a tree, and nodes of eight boxes each. Eight parts in a row are a leaf, eight leaves in a row a node, and so
// on, so that nodes store no indices of children. A part is no object: only its given numbers are stored. Boxes are in
// floats, about the set's middle, in units in which the set reaches from −1 to 1, rounded outwards.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "bodies/height_ceilings.hpp"
#include "bodies/lazy_value.hpp"
#include "bodies/part_order.hpp"
#include "math/box.hpp"
#include "math/vec.hpp"

namespace plannercheck {

inline constexpr std::size_t kPartCorners = 8;  // at most

// How much longer than in the world a radius may be in a frame: poses are off rigid by at most 3.6e-6
// (plannercheck/robots/unit_lengths.py), and rounding is far below the rest.
inline constexpr double kRadiusStretch = 1 + 1e-5;

// A part: the points within `radius` of the hull of its corners.
struct PartShape {
  std::array<Vec3, kPartCorners> corner;
  std::size_t corners = 0;  // 0: there is no part
  double radius = 0;        // m, of the world
};

// Bytes that are loaded at once: what stands in a tree begins there.
inline constexpr std::size_t kCacheLine = 64;

// The boxes of a node's children, by axis. A child that is not there has half extents of −∞.
struct alignas(kCacheLine) PartNode {
  std::array<std::array<float, kChildren>, 3> centre, half;
};

// Eight balls of a leaf; the last one fills the places that are left.
struct alignas(kCacheLine) EightPoints {
  std::array<double, kPartsInLeaf> x, y, z;
};

class PartSetError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

class PartSet {
 public:
  enum class Kind { kBalls, kCells, kColumns };

  // Balls around n points, 3 coordinates each. `radii`: n of them, or one for all.
  static PartSet balls(const double* points, std::size_t n, const double* radii, bool one_radius);
  // Boxes of a lattice, from `keys` (n, 3) on, `sizes` steps long; a coordinate is origin + key · resolution, rounded
  // after each operation.
  static PartSet cells(const std::int32_t* keys, const std::int32_t* sizes, std::size_t n, double resolution,
                       Vec3 origin);
  // The prisms below the two triangles of each cell of a lattice of heights (rows, columns), down to `base`. The vertex
  // (i, j) is at origin + (i · step[0], j · step[1]), and the triangles of a cell share the edge from (i, j) to (i + 1,
  // j + 1). Where a height is NaN there is no triangle.
  static PartSet columns(const double* heights, std::size_t rows, std::size_t columns, std::array<double, 2> step,
                         std::array<double, 2> origin, double base);

  Kind kind() const { return kind_; }
  std::size_t leaf_count() const { return leaves_; }
  // Places of parts are 0 to 8 leaf_count() − 1; some have none.
  PartShape shape(std::size_t place) const;
  // Hands over all parts with their places until one is taken; whether one was.
  template <class Take>
  bool any_part(Take take) const {
    for (std::size_t place = 0; place < leaves_ * kPartsInLeaf; ++place) {
      const PartShape part = shape(place);
      if (part.corners != 0 && take(part, place)) return true;
    }
    return false;
  }
  // What a place was given as: a ball's or cell's index; of heights 2 (i (columns − 1) + j), plus 1 for the triangle on
  // the side of (i, j + 1).
  std::int64_t source(std::size_t place) const;
  std::size_t part_count() const { return parts_; }

  // Around all parts, radii included, rounded outwards.
  const Box& box() const { return box_; }
  Vec3 middle() const { return middle_; }
  double units() const { return units_; }  // a length in m times this is one in the tree's units
  double largest_radius() const { return largest_radius_; }

  // Levels of nodes; the children of the first level's are leaves, the last level has one node.
  const std::vector<std::vector<PartNode>>& levels() const { return levels_; }
  // The points of a leaf of balls, and the radius of its ball k.
  const EightPoints& points(std::size_t leaf) const { return points_[leaf]; }
  double radius(std::size_t place) const { return radii_.size() == 1 ? radii_[0] : radii_[place]; }
  bool has_one_radius() const { return radii_.size() == 1; }
  // The boxes of the parts of a leaf.
  PartNode leaf_boxes(std::size_t leaf) const;
  const HeightCeilings& ceilings() const {
    return lazy_ceilings_.get(
        [this] { return HeightCeilings(heights_.data(), rows_, columns_, step_, {origin_.x, origin_.y, base_}); });
  }

  std::size_t bytes() const;

  // What the set was made of, in the order that was given.
  struct Given {
    std::vector<double> numbers;  // points, or heights
    std::vector<double> radii;    // of balls
    std::vector<std::int32_t> keys, sizes;
    std::size_t rows = 0, columns = 0;
    double resolution = 1, base = 0;
    Vec3 origin;
    std::array<double, 2> step{1, 1};
  };
  Given given() const;

 private:
  // Boxes around points and radii, in m, by axis; `low` is above `high` where there is nothing.
  struct EightExtents {
    std::array<std::array<double, kChildren>, 3> low, high;

    EightExtents();
    void put(std::size_t k, const Box& extent);
    Box around() const;
  };

  // Eight cells of a leaf; `size` 0 where there is none.
  struct alignas(kCacheLine) EightCells {
    std::array<std::array<std::int32_t, kPartsInLeaf>, 3> key;
    std::array<std::int32_t, kPartsInLeaf> size;
  };

  Kind kind_ = Kind::kBalls;
  std::size_t parts_ = 0, leaves_ = 0;
  Box box_{{}, {}};
  Vec3 middle_;
  double units_ = 1, largest_radius_ = 0;
  std::vector<std::vector<PartNode>> levels_;
  std::vector<std::int32_t> source_;  // by place, of balls and cells; by leaf, of tiles of heights
  std::vector<EightPoints> points_;
  std::vector<double> radii_;  // one, or one by place
  std::vector<EightCells> cells_;
  double resolution_ = 1;
  Vec3 origin_;
  std::vector<double> heights_;
  std::size_t rows_ = 0, columns_ = 0;
  std::array<double, 2> step_{1, 1};
  double base_ = 0;
  LazyValue<HeightCeilings> lazy_ceilings_;

  double lattice(std::size_t axis, std::int64_t key) const;
  PartShape ball(std::size_t place) const;
  PartShape cell(std::size_t place) const;
  PartShape prism(std::size_t place) const;
  double height_x(std::size_t i) const;
  double height_y(std::size_t j) const;
  Vec3 height_point(std::size_t i, std::size_t j) const;
  std::array<std::size_t, 2> tile_of(std::size_t leaf) const;
  EightExtents part_extents(std::size_t leaf) const;
  EightExtents ball_extents(std::size_t leaf) const;
  EightExtents cell_extents(std::size_t leaf) const;
  EightExtents prism_extents(std::size_t leaf) const;
  PartNode boxes(const EightExtents& extents) const;
  void frame_units(const Box& all);
  void build_levels();
};

}  // namespace plannercheck
