#include "motions/motion_collisions.hpp"

#include <array>
#include <utility>

namespace plannercheck {
namespace {

std::vector<std::array<std::int32_t, 2>> bodies_of(const std::vector<CertifiedPair>& pairs) {
  std::vector<std::array<std::int32_t, 2>> out;
  for (const CertifiedPair& pair : pairs) out.push_back({pair.a, pair.b});
  return out;
}

std::vector<BodyBox> boxes_of(const std::vector<GeometryObject>& bodies) {
  std::vector<BodyBox> out;
  for (const GeometryObject& body : bodies) out.push_back(body_box(body));
  return out;
}

}  // namespace

MotionCollisions::MotionCollisions(const MotionModel& model)
    : links_(at(model.links)), boxes_(boxes_of(model.bodies)), overlaps_(model.bodies, bodies_of(model.pairs)) {}

void MotionCollisions::begin(const MotionGrid& grid, Workspace& w) const {
  w.used = grid.intervals() / kBlockStates + 1;
  while (w.blocks.size() < w.used) {
    w.blocks.push_back({FloatLinkPoses(links_), boxes_.new_workspace(), overlaps_.new_workspace()});
  }
  for (std::size_t k = 0; k < w.used; ++k) {
    Block& block = w.blocks[k];
    block.links.begin(grid.links_at(k * kBlockStates));
    block.boxes.begin(), block.overlaps.begin();
  }
}

int MotionCollisions::colliding_state(const NearPair& near, Workspace& w) const {
  const std::uint64_t states = near.intervals | std::uint64_t{near.intervals} << 1;
  for (std::size_t k = 0; k < w.used; ++k) {
    const auto wanted = static_cast<unsigned>(states >> k * kBlockStates) & ((1U << kBlockStates) - 1);
    if (wanted == 0) continue;
    Block& block = w.blocks[k];
    const unsigned found = wanted & overlaps_.overlap(block.links, at(near.pair), boxes_, block.boxes, block.overlaps);
    if (found != 0) return static_cast<int>(k * kBlockStates) + __builtin_ctz(found);
  }
  return -1;
}

}  // namespace plannercheck
