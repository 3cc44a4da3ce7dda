// Chooses the instruction set when a checker is made, as plannercheck/common/core.py does for Python.
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>

#include "library/engine.hpp"

#ifdef PLANNERCHECK_HAS_v4
extern "C" plannercheck::EngineMaker plannercheck_engine_v4;
#endif
#ifdef PLANNERCHECK_HAS_v3
extern "C" plannercheck::EngineMaker plannercheck_engine_v3;
#endif
#ifdef PLANNERCHECK_HAS_v2
extern "C" plannercheck::EngineMaker plannercheck_engine_v2;
#endif
#ifdef PLANNERCHECK_HAS_plain
extern "C" plannercheck::EngineMaker plannercheck_engine_plain;
#endif

namespace plannercheck {
namespace {

#if defined(__x86_64__)
[[maybe_unused]] bool runs_v2() {
  return __builtin_cpu_supports("sse4.2") != 0 && __builtin_cpu_supports("popcnt") != 0;
}

// Processors with these have MOVBE, F16C and LZCNT as well.
[[maybe_unused]] bool runs_v3() {
  return runs_v2() && __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi") != 0 &&
         __builtin_cpu_supports("bmi2") != 0 && __builtin_cpu_supports("fma") != 0;
}

[[maybe_unused]] bool runs_v4() {
  return runs_v3() && __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
         __builtin_cpu_supports("avx512cd") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
         __builtin_cpu_supports("avx512vl") != 0;
}
#endif

// Best first.
constexpr Level kLevels[] = {
#ifdef PLANNERCHECK_HAS_v4
    {"v4", &runs_v4, &plannercheck_engine_v4},
#endif
#ifdef PLANNERCHECK_HAS_v3
    {"v3", &runs_v3, &plannercheck_engine_v3},
#endif
#ifdef PLANNERCHECK_HAS_v2
    {"v2", &runs_v2, &plannercheck_engine_v2},
#endif
#ifdef PLANNERCHECK_HAS_plain
    {"plain", [] { return true; }, &plannercheck_engine_plain},
#endif
};

}  // namespace

const Level& chosen_level() {
  const char* const wanted = std::getenv("PLANNERCHECK_LEVEL");
  const bool any = wanted == nullptr || *wanted == '\0';
  std::string runnable;
  for (const Level& level : kLevels) {
    if (!level.runs()) continue;
    if (any || std::strcmp(level.name, wanted) == 0) return level;
    runnable += (runnable.empty() ? "" : ", ") + std::string(level.name);
  }
  if (any) throw std::runtime_error("this processor runs none of the instruction sets that plannercheck was built for");
  throw std::runtime_error("PLANNERCHECK_LEVEL='" + std::string(wanted) + "': this machine and build have " + runnable);
}

}  // namespace plannercheck
