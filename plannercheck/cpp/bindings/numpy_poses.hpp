// Poses in NumPy arrays of doubles, read in place: one in any order of memory, or many in C order.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstring>

#include "bindings/numpy_row.hpp"

namespace plannercheck {

class NumpyPoses {
 public:
  // False for anything but native doubles of shape (4, 4), or of shape (n, 4, 4) in C order.
  bool read(const NumpyArray& array, nanobind::handle object) {
    if (!array_.read(array, object)) return false;
    const int row = array_.dimensions - 2, column = array_.dimensions - 1;
    if (row < 0 || row > 1 || array_.shape[row] != 4 || array_.shape[column] != 4) return false;
    row_step_ = array_.strides[row], step_ = array_.strides[column];
    if (row == 0) return true;
    are_many_ = true, count_ = static_cast<std::size_t>(array_.shape[0]);
    const bool follow = count_ < 2 || array_.strides[0] == kMatrix;
    return follow && row_step_ == kRow && step_ == kNumber && is_aligned_for_doubles(array_.data);
  }

  bool are_many() const { return are_many_; }

  // How many, if `are_many`.
  std::size_t count() const { return count_; }
  const double* rows() const { return static_cast<const double*>(array_.data); }

  // The matrix of one, by rows.
  void copy_to(double* matrix) const {
    if (row_step_ == kRow && step_ == kNumber) {
      std::memcpy(matrix, array_.data, 4 * kRow);
      return;
    }
    const auto* const from = static_cast<const char*>(array_.data);
    for (Py_ssize_t i = 0; i < 4; ++i) {
      for (Py_ssize_t j = 0; j < 4; ++j) std::memcpy(matrix + 4 * i + j, from + i * row_step_ + j * step_, kNumber);
    }
  }

 private:
  static constexpr Py_ssize_t kNumber = sizeof(double), kRow = 4 * kNumber, kMatrix = 4 * kRow;  // bytes

  NumpyDoubles array_;
  bool are_many_ = false;
  std::size_t count_ = 1;
  Py_ssize_t row_step_ = 0, step_ = 0;
};

}  // namespace plannercheck
