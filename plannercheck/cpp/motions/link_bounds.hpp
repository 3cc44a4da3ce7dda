// A ball and a box around all bodies of a link, and chains whose bounds hold for all of them.
//
// In: bodies on links, chains of joints. Out: one ball and one box a link, in the link's frame; and of the given
// chains, a subset with the same bounds. The ball's centre is a mean of points of the bodies. Velocities and
// accelerations of points of a link are affine functions of the points, so their lengths are convex: the lengths at the
// centre are at most the largest bound of all bodies.
#pragma once

#include <cstdint>
#include <vector>

#include "math/box.hpp"
#include "motions/motion_certifier.hpp"

namespace plannercheck {

// Around the hulls of bodies of one link, in the link's frame.
struct LinkBox : Box {
  std::int32_t link = -1;
};

struct LinkBound {
  std::size_t link;
  Vec3 centre;  // on the link
  double radius;
  LinkBox box;
  double inflation_radius;  // the largest; the box is without it
};

// One for each link with bodies of `movers`; writes the place of each body's.
std::vector<LinkBound> link_bounds(const MotionModel& model, const std::vector<std::int32_t>& movers,
                                   std::vector<std::size_t>& bound_of);

// Some of the chains, each once, without those whose bounds are at most another one's on any motion.
std::vector<std::int32_t> longest_chains(const MotionChains& chains, std::vector<std::int32_t> some);

}  // namespace plannercheck
