// Which joints and links are posed, in which order, and where, for the kernels of many states and of one.
#pragma once

#include <vector>

#include "robots/kinematics.hpp"

namespace plannercheck {

struct PosingOrder {
  std::vector<int> joints;  // that carry some needed link, parents first
  std::vector<int> home;    // by joint: a needed link that is posed as the joint is, or below 0
  std::vector<int> links;   // needed links that are not a joint's home

  // needed[link] != 0: for all links.
  void find(const Kinematics& kinematics, const unsigned char* needed);
};

}  // namespace plannercheck
