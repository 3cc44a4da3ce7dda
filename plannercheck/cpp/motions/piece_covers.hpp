// Straight motions with tubes that each cover several pieces of a trajectory, so that one proof serves all of these.
//
// In: pieces. Out: straight motions, and which pieces each covers: as many successive pieces as a thin tube holds, each
// beginning where the one before ends.
//
// Proof. Let b[k] be the control points of a piece, c(s) = a + s (e − a) the straight motion, and r a width in each
// column. If for each k there is an s[k] in [0, 1] with |b[k] − c(s[k])| ≤ r, then at any parameter of the piece, with
// the weights w[k] ≥ 0 of Bernstein, which add up to 1, its configuration Σ w[k] b[k] is within r of c(Σ w[k] s[k]),
// because c is linear. So the piece with its own tube t runs in the tube t + r of the straight motion.
//
// On a straight motion bodies have to stay further apart than on its pieces, by the tolerance. A piece that it proves
// would so be proved by itself: verdicts do not depend on which pieces are covered.
#pragma once

#include <cstddef>
#include <vector>

#include "motions/path.hpp"

namespace plannercheck {

// Between these, (width), the error of computed poses has a bound.
struct PoseRange {
  const double *low, *high;
};

class PieceCovers {
 public:
  // Covers n pieces of `width` linear columns.
  void find(const Segments& pieces, std::size_t n, std::size_t width, double tolerance, const PoseRange& range);

  std::size_t size() const { return first_.size(); }
  Segments motions() const;
  // The pieces of a cover.
  std::size_t first(std::size_t cover) const { return first_[cover]; }
  std::size_t past(std::size_t cover) const { return past_[cover]; }

 private:
  // How far some control points are off the straight motion from the first to the last, by column.
  struct Deviation {
    std::vector<double> low, high;
    double width;  // the largest of all columns
  };

  std::size_t width_ = 0;
  std::vector<std::size_t> first_, past_;
  std::vector<double> ends_, tubes_;  // of all covers: 2 rows and 1 row each
  std::vector<double> columns_;       // control points of pieces that go on, column by column
  std::size_t stride_ = 0;            // of a column
  std::vector<double> places_;        // of control points on a straight motion
  Deviation found_, tried_;

  void set_columns(const Segments& pieces, std::size_t first, std::size_t past);
  std::size_t fitting(std::size_t degree, std::size_t first, std::size_t most, std::size_t guess);
  void measure(std::size_t from, std::size_t to, Deviation& out);
  void keep(const Segments& pieces, std::size_t first, std::size_t past, double tolerance, const PoseRange& range);
};

}  // namespace plannercheck
