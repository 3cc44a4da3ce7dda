#include "motions/motion_collisions.hpp"

#include <array>

namespace plannercheck {
namespace {

std::vector<std::array<std::int32_t, 2>> bodies_of(const std::vector<CertifiedPair>& pairs) {
  std::vector<std::array<std::int32_t, 2>> out;
  for (const CertifiedPair& pair : pairs) out.push_back({pair.a, pair.b});
  return out;
}

}  // namespace

MotionCollisions::MotionCollisions(const MotionModel& model)
    : links_(at(model.links)), bounds_(model.bodies, bodies_of(model.pairs)) {
  for (const CertifiedPair& pair : model.pairs) {
    links_of_.push_back({model.bodies[at(pair.a)].link, model.bodies[at(pair.b)].link});
  }
}

void MotionCollisions::begin(const MotionGrid& grid, Workspace& w) const {
  w.used = grid.intervals() / kBlockStates + 1;
  while (w.blocks.size() < w.used) {
    w.blocks.push_back({RoundedPoses(links_), {}, bounds_.posed<FloatBlock>()});
  }
  for (std::size_t k = 0; k < w.used; ++k) {
    Block& block = w.blocks[k];
    block.links.begin(grid.links_at(k * kBlockStates));
    block.poses = block.links.block({}, kBlockStates);
    block.bounds.begin(block.poses);
  }
}

int MotionCollisions::colliding_state(const NearPair& near, Workspace& w) const {
  const std::uint64_t states = near.intervals | std::uint64_t{near.intervals} << 1;
  for (std::size_t k = 0; k < w.used; ++k) {
    const auto wanted = static_cast<unsigned>(states >> k * kBlockStates) & ((1U << kBlockStates) - 1);
    if (wanted == 0) continue;
    Block& block = w.blocks[k];
    for (const std::int32_t link : links_of_[at(near.pair)]) {
      if (link >= 0) block.links.round(at(link));
    }
    const unsigned found = wanted & bounds_.by_inner_shapes(at(near.pair), block.bounds).overlap;
    if (found != 0) return static_cast<int>(k * kBlockStates) + __builtin_ctz(found);
  }
  return -1;
}

}  // namespace plannercheck
