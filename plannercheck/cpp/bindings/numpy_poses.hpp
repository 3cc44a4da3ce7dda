// Poses in NumPy arrays of doubles, read in place: one in any order of memory, or many in C order.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstring>

#include "bindings/numpy_row.hpp"

namespace plannercheck {

// Keeps the array's memory alive while it exists.
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
    if (!array.is_class_of(object)) return false;
    if (PyObject_GetBuffer(object.ptr(), &view_, PyBUF_STRIDED_RO | PyBUF_FORMAT) != 0) {
      PyErr_Clear();
      view_.obj = nullptr;
      return false;
    }
    if (view_.ndim < 2 || view_.ndim > 3 || std::strcmp(view_.format, "d") != 0) return false;
    const Py_ssize_t* const shape = view_.shape + (view_.ndim - 2);
    return shape[0] == 4 && shape[1] == 4 && (view_.ndim == 2 || PyBuffer_IsContiguous(&view_, 'C') != 0);
  }

  bool are_many() const { return view_.ndim == 3; }

  // Of many.
  std::size_t count() const { return static_cast<std::size_t>(view_.shape[0]); }
  const double* rows() const { return static_cast<const double*>(view_.buf); }

  // The matrix of one, by rows.
  void copy_to(double* matrix) const {
    const auto* const first = static_cast<const char*>(view_.buf);
    for (Py_ssize_t i = 0; i < 4; ++i) {
      for (Py_ssize_t j = 0; j < 4; ++j)
        std::memcpy(matrix + 4 * i + j, first + i * view_.strides[0] + j * view_.strides[1], sizeof(double));
    }
  }

 private:
  Py_buffer view_{};
};

}  // namespace plannercheck
