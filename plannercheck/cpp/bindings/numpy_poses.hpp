// Poses in NumPy arrays of doubles, read in place: one in any order of memory, or many in C order.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstring>

#include "bindings/numpy_row.hpp"

namespace plannercheck {

// Keeps the array's memory alive while it exists, if the caller keeps the array.
class NumpyPoses {
 public:
  NumpyPoses() = default;
  NumpyPoses(const NumpyPoses&) = delete;
  NumpyPoses& operator=(const NumpyPoses&) = delete;
  ~NumpyPoses() {
    if (view_.obj != nullptr) PyBuffer_Release(&view_);
  }

  // False for anything but native doubles of shape (4, 4), or of shape (n, 4, 4) in C order.
  bool read(const NumpyArray& array, nanobind::handle object) {
    if (const NumpyArray::Head* const head = array.doubles_in(object))
      return take(head->data, head->dimensions, head->shape, head->strides);
    if (!array.is_class_of(object)) return false;
    if (PyObject_GetBuffer(object.ptr(), &view_, PyBUF_STRIDED_RO | PyBUF_FORMAT) != 0) {
      PyErr_Clear();
      view_.obj = nullptr;
      return false;
    }
    return std::strcmp(view_.format, "d") == 0 && take(view_.buf, view_.ndim, view_.shape, view_.strides);
  }

  bool are_many() const { return are_many_; }

  // Of many.
  std::size_t count() const { return count_; }
  const double* rows() const { return reinterpret_cast<const double*>(data_); }

  // The matrix of one, by rows.
  void copy_to(double* matrix) const {
    if (row_step_ == kRow && step_ == kNumber) {
      std::memcpy(matrix, data_, 4 * kRow);
      return;
    }
    for (Py_ssize_t i = 0; i < 4; ++i) {
      for (Py_ssize_t j = 0; j < 4; ++j) std::memcpy(matrix + 4 * i + j, data_ + i * row_step_ + j * step_, kNumber);
    }
  }

 private:
  static constexpr Py_ssize_t kNumber = sizeof(double), kRow = 4 * kNumber, kMatrix = 4 * kRow;  // bytes

  Py_buffer view_{};
  const char* data_ = nullptr;
  bool are_many_ = false;
  std::size_t count_ = 1;
  Py_ssize_t row_step_ = 0, step_ = 0;

  bool take(const void* data, int dimensions, const Py_ssize_t* shape, const Py_ssize_t* strides) {
    if (dimensions < 2 || dimensions > 3) return false;
    const int row = dimensions - 2, column = dimensions - 1;
    if (shape[row] != 4 || shape[column] != 4) return false;
    data_ = static_cast<const char*>(data), row_step_ = strides[row], step_ = strides[column];
    if (dimensions == 2) return true;
    are_many_ = true, count_ = static_cast<std::size_t>(shape[0]);
    const bool follow = shape[0] < 2 || strides[0] == kMatrix;
    return follow && row_step_ == kRow && step_ == kNumber && is_aligned_for_doubles(data);
  }
};

}  // namespace plannercheck
