// Floating-point arithmetic as the proofs assume it while the core works: round to nearest, no flush to zero.
//
// In: the calling thread's settings. Out: the same, restored. Idea: another library may have left a thread with another
// rounding direction, or with denormals flushed to zero (loading code built with -ffast-math does so). Every function
// bound to Python is guarded (`plain_floats` in its definition); threads that the core starts inherit the settings of
// the starting thread. If the settings are right, which is nearly always, this costs one read and one comparison.
#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>

#if defined(__SSE2__)
#include <xmmintrin.h>
#elif !defined(__aarch64__)
#include <cfenv>
#endif

namespace plannercheck {

#if defined(__SSE2__)
namespace float_control {
using Word = std::uint32_t;
inline constexpr Word kPlain = 0x1f80;  // MXCSR: no exception traps, to nearest, denormals as they are
inline constexpr Word kFlags = 0x003f;  // sticky exception flags; they change nothing
inline Word read() { return _mm_getcsr(); }
inline void write(Word word) { _mm_setcsr(word); }
}  // namespace float_control
#elif defined(__aarch64__)
namespace float_control {
using Word = std::uint64_t;
inline constexpr Word kPlain = 0;  // FPCR; its flags are in another register
inline constexpr Word kFlags = 0;
inline Word read() {
  Word word = 0;
  __asm__ __volatile__("mrs %0, fpcr" : "=r"(word));
  return word;
}
inline void write(Word word) { __asm__ __volatile__("msr fpcr, %0" : : "r"(word) : "memory"); }
}  // namespace float_control
#else
namespace float_control {
using Word = int;
inline constexpr Word kPlain = FE_TONEAREST;
inline constexpr Word kFlags = 0;
inline Word read() { return std::fegetround(); }
inline void write(Word word) { std::fesetround(word); }
}  // namespace float_control
#endif

class PlainFloats {
 public:
  PlainFloats() : before_(float_control::read()) {
    if (is_other()) [[unlikely]]
      float_control::write(float_control::kPlain);
  }
  ~PlainFloats() {
    if (is_other()) [[unlikely]]
      float_control::write(before_);
  }
  PlainFloats(const PlainFloats&) = delete;
  PlainFloats& operator=(const PlainFloats&) = delete;

 private:
  float_control::Word before_;

  bool is_other() const { return (before_ & ~float_control::kFlags) != float_control::kPlain; }
};

// Belongs into every definition of a function for Python.
inline const nanobind::call_guard<PlainFloats> plain_floats;

}  // namespace plannercheck
