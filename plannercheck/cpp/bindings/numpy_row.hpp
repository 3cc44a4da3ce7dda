// One row of doubles in a NumPy array, read in place. A general array argument takes 0.3 µs longer (measured).
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace plannercheck {

// The class numpy.ndarray.
class NumpyArray {
 public:
  NumpyArray() : type_(nanobind::module_::import_("numpy").attr("ndarray")) {}

  bool is_class_of(nanobind::handle object) const { return object.type().is(type_); }

 private:
  nanobind::object type_;
};

// Keeps the array's memory alive while it exists.
class NumpyRow {
 public:
  NumpyRow(const NumpyArray& array, nanobind::handle object, std::size_t width) {
    if (!array.is_class_of(object)) return;
    if (PyObject_GetBuffer(object.ptr(), &view_, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) != 0) {
      PyErr_Clear();  // strided
      view_.obj = nullptr;
      return;
    }
    const bool is_row = view_.ndim == 1 && static_cast<std::size_t>(view_.shape[0]) == width;
    const bool is_aligned = reinterpret_cast<std::uintptr_t>(view_.buf) % alignof(double) == 0;
    if (is_row && is_aligned && std::strcmp(view_.format, "d") == 0) data_ = static_cast<const double*>(view_.buf);
  }
  NumpyRow(const NumpyRow&) = delete;
  NumpyRow& operator=(const NumpyRow&) = delete;
  ~NumpyRow() {
    if (view_.obj != nullptr) PyBuffer_Release(&view_);
  }

  // Null for anything but `width` native doubles in a row.
  const double* data() const { return data_; }

 private:
  Py_buffer view_{};
  const double* data_ = nullptr;
};

}  // namespace plannercheck
