// Doubles in a NumPy array, read in place: where they are, one row of them, and rows of one width. A general array
// argument takes 0.3 µs longer, Python's buffer protocol 0.05 µs (measured).
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace plannercheck {

// The class numpy.ndarray, and how its arrays begin: NumPy's binary interface keeps that as it is, since extensions are
// compiled against it. It is compared with what the buffer protocol says of an array all the same; if that differs,
// `doubles_in` finds none.
class NumpyArray {
 public:
  // The fields that extensions read.
  struct Head {
    PyObject_HEAD char* data;
    int dimensions;
    Py_ssize_t* shape;
    Py_ssize_t* strides;
    PyObject* base;
    PyObject* dtype;
  };

  NumpyArray() {
    const nanobind::module_ numpy = nanobind::module_::import_("numpy");
    type_ = numpy.attr("ndarray");
    double_ = numpy.attr("dtype")("float64");
    head_is_known_ = is_as_buffers_say(numpy.attr("zeros")(nanobind::make_tuple(2, 3, 5)).attr("T"));
  }

  bool is_class_of(nanobind::handle object) const { return object.type().is(type_); }

  // The array's fields; null for what is surely no array of native doubles, and where it may be one all the same.
  const Head* doubles_in(nanobind::handle object) const {
    if (!head_is_known_ || !is_class_of(object)) return nullptr;
    const auto* const head = reinterpret_cast<const Head*>(object.ptr());
    return head->dtype == double_.ptr() ? head : nullptr;
  }

 private:
  nanobind::object type_, double_;
  bool head_is_known_ = false;

  bool is_as_buffers_say(nanobind::handle probe) const {
    Py_buffer view;
    if (reinterpret_cast<PyTypeObject*>(type_.ptr())->tp_basicsize < static_cast<Py_ssize_t>(sizeof(Head)))
      return false;
    if (PyObject_GetBuffer(probe.ptr(), &view, PyBUF_STRIDED_RO) != 0) {
      PyErr_Clear();
      return false;
    }
    const auto& head = *reinterpret_cast<const Head*>(probe.ptr());
    const std::size_t size = static_cast<std::size_t>(view.ndim) * sizeof(Py_ssize_t);
    const bool is_same = head.data == view.buf && head.dimensions == view.ndim && head.dtype == double_.ptr() &&
                         std::memcmp(head.shape, view.shape, size) == 0 &&
                         std::memcmp(head.strides, view.strides, size) == 0;
    PyBuffer_Release(&view);
    return is_same;
  }
};

inline bool is_aligned_for_doubles(const void* data) {
  return reinterpret_cast<std::uintptr_t>(data) % alignof(double) == 0;
}

// An array of native doubles: its fields, and its memory kept alive while this exists, if the caller keeps the array.
struct NumpyDoubles {
  const void* data = nullptr;
  int dimensions = 0;
  const Py_ssize_t *shape = nullptr, *strides = nullptr;

  NumpyDoubles() = default;
  NumpyDoubles(const NumpyDoubles&) = delete;
  NumpyDoubles& operator=(const NumpyDoubles&) = delete;
  ~NumpyDoubles() {
    if (view_.obj != nullptr) PyBuffer_Release(&view_);
  }

  // False for anything else.
  bool read(const NumpyArray& array, nanobind::handle object) {
    if (const NumpyArray::Head* const head = array.doubles_in(object)) {
      data = head->data, dimensions = head->dimensions, shape = head->shape, strides = head->strides;
      return true;
    }
    if (!array.is_class_of(object)) return false;
    if (PyObject_GetBuffer(object.ptr(), &view_, PyBUF_STRIDED_RO | PyBUF_FORMAT) != 0) {
      PyErr_Clear();
      view_.obj = nullptr;
      return false;
    }
    data = view_.buf, dimensions = view_.ndim, shape = view_.shape, strides = view_.strides;
    return std::strcmp(view_.format, "d") == 0;
  }

 private:
  Py_buffer view_{};
};

class NumpyRow {
 public:
  NumpyRow(const NumpyArray& array, nanobind::handle object, std::size_t width) {
    if (!row_.read(array, object) || row_.dimensions != 1) return;
    const bool is_dense = row_.strides[0] == static_cast<Py_ssize_t>(sizeof(double)) || width < 2;
    if (static_cast<std::size_t>(row_.shape[0]) == width && is_dense && is_aligned_for_doubles(row_.data))
      data_ = static_cast<const double*>(row_.data);
  }

  // Null for anything but `width` native doubles in a row.
  const double* data() const { return data_; }

 private:
  NumpyDoubles row_;
  const double* data_ = nullptr;
};

// Rows of `width` doubles one after the other: n rows at `data`, which is null for anything else.
struct NumpyRows {
  NumpyRows(const NumpyArray& array, nanobind::handle object, std::size_t width) {
    if (!rows_.read(array, object) || rows_.dimensions != 2) return;
    if (static_cast<std::size_t>(rows_.shape[1]) != width) return;
    const auto step = static_cast<Py_ssize_t>(sizeof(double));
    const bool is_one = rows_.shape[0] == 1, in_order = is_one || rows_.strides[0] == step * rows_.shape[1];
    if (rows_.strides[1] != step || !in_order || !is_aligned_for_doubles(rows_.data)) return;
    data = static_cast<const double*>(rows_.data);
    n = static_cast<std::size_t>(rows_.shape[0]);
  }

  const double* data = nullptr;
  std::size_t n = 0;

 private:
  NumpyDoubles rows_;
};

}  // namespace plannercheck
