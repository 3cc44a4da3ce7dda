#include "checking/posed_in_floats.hpp"

#include <algorithm>
#include <limits>

#include "broad_phase/float_link_poser.hpp"
#include "checking/state_blocks.hpp"
#include "math/vec.hpp"

namespace plannercheck {

PosedInFloats posed_in_floats(const Kinematics& kinematics, const double* q, std::size_t n,
                              const unsigned char* needed) {
  const std::size_t links = at(kinematics.link_count()), width = at(kinematics.width());
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  PosedInFloats out{std::vector<float>(n * links * 12, kNone), std::vector<float>(n * links * 2, kNone)};
  FloatLinkPoser poser;
  poser.begin(kinematics, needed);
  std::vector<Lanes> columns(kBlockGroups * width);
  for (std::size_t first = 0; poser.is_possible() && first < n; first += kBlockStates) {
    const std::size_t count = std::min<std::size_t>(kBlockStates, n - first);
    load_rows<kBlockStates>([&](std::size_t state) { return q + (first + state) * width; }, count, width,
                            columns.data());
    if (!poser.pose(columns.data())) continue;
    const FloatBlock block = poser.block({columns.data(), width}, static_cast<int>(count));
    for (std::size_t state = 0; state < count; ++state) {
      for (std::size_t link = 0; link < links; ++link) {
        if (needed[link] == 0) continue;
        const std::size_t place = (first + state) * links + link;
        for (std::size_t i = 0; i < 12; ++i) out.poses[place * 12 + i] = block.pose(link).m[i][state];
        out.errors[place * 2] = block.error(link).turn;
        out.errors[place * 2 + 1] = block.error(link).shift;
      }
    }
  }
  return out;
}

}  // namespace plannercheck
