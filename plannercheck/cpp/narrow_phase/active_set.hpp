// The vertices and facets of which the solver's last game of a pair was mixed. Where the bodies have moved little, its
// next search mostly needs these again: with them it takes half the rounds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace plannercheck {

struct ActiveSet {
  static constexpr std::size_t kMost = 4;         // in space, mixtures need no more
  static constexpr std::uint16_t kNone = 0xffff;  // vertices and facets with such numbers, or larger ones, are not kept
  typedef std::array<std::uint16_t, kMost> Numbers;

  Numbers vertices{kNone, kNone, kNone, kNone};  // of the guest
  Numbers facets{kNone, kNone, kNone, kNone};    // of the host
};

}  // namespace plannercheck
