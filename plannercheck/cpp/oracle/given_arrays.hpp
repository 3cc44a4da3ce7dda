// What the oracle's bindings share: arrays as Python gives them, and Python's lock.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

namespace plannercheck::oracle {

namespace nb = nanobind;

template <int... sizes>
using Doubles = nb::ndarray<const double, nb::shape<sizes...>, nb::c_contig, nb::device::cpu>;
using Verdicts = nb::ndarray<nb::numpy, std::uint8_t>;

constexpr std::size_t kPoseNumbers = 16;

// As bindings/gil.hpp has it, of which nothing is taken: at its end, Python unwinds a thread that asks for its lock,
// and a destructor that must not throw would end the process. The thread stops instead.
class GilReleased {
 public:
  GilReleased() : state_(PyEval_SaveThread()) {}
  ~GilReleased() {
    try {
      PyEval_RestoreThread(state_);
    } catch (...) {
      for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
    }
  }
  GilReleased(const GilReleased&) = delete;
  GilReleased& operator=(const GilReleased&) = delete;

 private:
  PyThreadState* state_;
};

inline void check_finite(const double* numbers, std::size_t count, const char* what) {
  if (!std::all_of(numbers, numbers + count, [](double x) { return std::isfinite(x); }))
    throw std::invalid_argument(std::string(what) + " must be finite");
}

inline Verdicts as_array(std::unique_ptr<std::uint8_t[]> verdicts, std::size_t count) {
  std::uint8_t* raw = verdicts.release();
  nb::capsule owner(raw, [](void* data) noexcept { delete[] static_cast<std::uint8_t*>(data); });
  return {raw, {count}, owner};
}

// Defined in bind_meshes.cpp.
void bind_meshes(nb::module_& m);

}  // namespace plannercheck::oracle
