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

MotionCollisions::Workspace MotionCollisions::new_workspace() const {
  return {RoundedLinks(links_), boxes_.new_workspace(), overlaps_.new_workspace()};
}

MotionCollisions::Found MotionCollisions::find(const MotionGrid& grid, const std::vector<NearPair>& near,
                                               Workspace& w) const {
  const std::size_t states = grid.intervals() + 1;
  for (std::size_t first = 0; first < states; first += kBlockStates) {
    w.links.begin(grid.links_at(first));
    w.boxes.begin(), w.overlaps.begin();
    for (const NearPair& pair : near) {
      const unsigned wanted = (pair.intervals | pair.intervals << 1) >> first & ((1U << kBlockStates) - 1);
      if (wanted == 0) continue;
      const unsigned found = wanted & overlaps_.overlap(w.links, at(pair.pair), boxes_, w.boxes, w.overlaps);
      if (found != 0) return {pair.pair, first + static_cast<std::size_t>(__builtin_ctz(found))};
    }
  }
  return {-1, 0};
}

}  // namespace plannercheck
