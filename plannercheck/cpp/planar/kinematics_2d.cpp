#include "planar/kinematics_2d.hpp"

#include "math/sincos.hpp"
#include "math/vec.hpp"

namespace plannercheck {

void pose_planar_links(const std::vector<PlanarLink>& links, const std::vector<Lanes>& columns,
                       std::vector<PlanarLinkLanes>& out) {
  out.resize(links.size());
  for (std::size_t k = 0; k < links.size(); ++k) {
    const PlanarLink& link = links[k];
    PlanarLinkLanes& to = out[k];
    to.angle = broadcast(link.angle);
    to.x = broadcast(link.x);
    to.y = broadcast(link.y);
    if (link.parent >= 0) {
      const PlanarLinkLanes& from = out[at(link.parent)];
      to.angle = from.angle + link.angle;
      to.x = from.x + (from.cos * link.x - from.sin * link.y);
      to.y = from.y + (from.sin * link.x + from.cos * link.y);
    }
    const Lanes* q = columns.data() + link.column;
    if (link.joint == PlanarJoint::kRevolute) to.angle = to.angle + q[0];
    if (link.joint == PlanarJoint::kFree) {
      to.x = to.x + q[0];
      to.y = to.y + q[1];
      to.angle = to.angle + q[2];
    }
    const SinCos turn = sincos(to.angle);
    to.cos = turn.cos;
    to.sin = turn.sin;
  }
}

}  // namespace plannercheck
