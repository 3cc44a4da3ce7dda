#include "evaluation/sphere_model.hpp"

#include <algorithm>

#include "broad_phase/broad_phase.hpp"
#include "robots/kinematics_lanes.hpp"

namespace plannercheck {

struct SphereModel::Centres {
  Floats x, y, z;
};

namespace {

using Centres = SphereModel::Centres;

Floats positive(Floats a) { return a > 0 ? a : Floats{}; }

Floats root(Floats a) {
  for (int i = 0; i < kFloats; ++i) a[i] = __builtin_sqrtf(a[i]);
  return a;
}

Centres local(const SphereModel::Obstacle& o, const Centres& c) {
  const auto& m = o.to_local;
  return {((c.x * m[0] + c.y * m[1]) + c.z * m[2]) + m[3], ((c.x * m[4] + c.y * m[5]) + c.z * m[6]) + m[7],
          ((c.x * m[8] + c.y * m[9]) + c.z * m[10]) + m[11]};
}

unsigned within(Floats x, Floats y, Floats z, float radius) {
  return float_bits(x * x + y * y + z * z <= radius * radius);
}

}  // namespace

struct SphereModel::Workspace {
  std::vector<Lanes> columns, links;
  LinkPoser poser;
  std::vector<Centres> centres;     // of all balls
  std::vector<unsigned char> done;  // bodies whose fine balls are posed
  std::size_t link_count;

  Centres posed(const Ball& ball, std::int32_t link) const {
    std::array<Lanes, kBlockGroups> x, y, z;
    const Vec3 c = ball.centre;
    for (std::size_t group = 0; group < kBlockGroups; ++group) {
      const Lanes* m = &links[pose_index(link_count, group, at(link))];
      x[group] = ((m[0] * c.x + m[1] * c.y) + m[2] * c.z) + m[3];
      y[group] = ((m[4] * c.x + m[5] * c.y) + m[6] * c.z) + m[7];
      z[group] = ((m[8] * c.x + m[9] * c.y) + m[10] * c.z) + m[11];
    }
    return {joined_floats(x.data(), 1), joined_floats(y.data(), 1), joined_floats(z.data(), 1)};
  }

  void pose_fine(const Parts& parts, const Body& body) {
    unsigned char& is_done = done[static_cast<std::size_t>(&body - parts.bodies.data())];
    if (is_done) return;
    is_done = 1;
    for (std::int32_t k = 1; k < body.balls; ++k) {
      centres[at(body.first_ball + k)] = posed(parts.balls[at(body.first_ball + k)], body.link);
    }
  }
};

namespace {

unsigned meets(const SphereModel::Obstacle& o, const std::vector<SphereModel::Plane>& planes, const Centres& centre,
               float radius) {
  const Centres c = local(o, centre);
  switch (o.kind) {
    case SphereModel::Kind::kRoundedBox:
      return within(positive(absolute(c.x) - o.half[0]), positive(absolute(c.y) - o.half[1]),
                    positive(absolute(c.z) - o.half[2]), radius + o.radius);
    case SphereModel::Kind::kCylinder:
      return within(positive(root(c.x * c.x + c.y * c.y) - o.half[0]), positive(absolute(c.z) - o.half[2]), Floats{},
                    radius);
    case SphereModel::Kind::kPlanes:
      break;
  }
  FloatMask inside = ~FloatMask{};
  for (std::int32_t k = 0; k < o.planes; ++k) {
    const SphereModel::Plane& p = planes[at(o.first_plane + k)];
    inside &= (c.x * p.x + c.y * p.y) + c.z * p.z <= p.offset + radius;
  }
  return float_bits(inside);
}

unsigned meet(const Centres& a, const Centres& b, float radius) {
  return within(a.x - b.x, a.y - b.y, a.z - b.z, radius);
}

}  // namespace

SphereModel::SphereModel(Parts parts) : parts_(std::move(parts)), needed_(at(parts_.links), 0) {
  for (const Body& body : parts_.bodies) needed_[at(body.link)] = 1;
}

std::size_t SphereModel::bytes() const {
  const auto size = [](const auto& v) { return v.size() * sizeof(v[0]); };
  return sizeof *this + size(parts_.balls) + size(parts_.bodies) + size(parts_.obstacles) + size(parts_.planes) +
         size(parts_.pairs) + size(needed_);
}

void SphereModel::check_states(const Kinematics& kinematics, const double* q, std::size_t n,
                               std::uint8_t* valid) const {
  const std::size_t width = at(kinematics.width()), links = at(parts_.links);
  Workspace w;
  w.columns.resize(kBlockGroups * width);
  w.links.resize(kBlockGroups * links * 12);
  w.poser.begin(kinematics, needed_.data());
  w.centres.resize(parts_.balls.size());
  w.done.resize(parts_.bodies.size());
  w.link_count = links;
  for (std::size_t row = 0; row < n; row += kBlockStates) {
    const std::size_t count = std::min<std::size_t>(kBlockStates, n - row);
    for (std::size_t state = 0; state < kBlockStates; ++state) {
      const double* from = q + (row + std::min(state, count - 1)) * width;
      for (std::size_t c = 0; c < width; ++c) w.columns[state / kLanes * width + c][state % kLanes] = from[c];
    }
    for (std::size_t group = 0; group < kBlockGroups; ++group) {
      w.poser.pose(&w.columns[group * width], &w.links[group * links * 12]);
    }
    const unsigned free = judge((1U << count) - 1, w);
    for (std::size_t state = 0; state < count; ++state) valid[row + state] = (free >> state) & 1;
  }
}

unsigned SphereModel::judge(unsigned states, Workspace& w) const {
  std::fill(w.done.begin(), w.done.end(), static_cast<unsigned char>(0));
  for (const Body& body : parts_.bodies) {
    w.centres[at(body.first_ball)] = w.posed(parts_.balls[at(body.first_ball)], body.link);
  }
  const auto bodies = static_cast<std::int32_t>(parts_.bodies.size());
  for (const auto& [first, second] : parts_.pairs) {
    const Body& body = parts_.bodies[at(first)];
    states &= ~(second < bodies ? hits_body(body, parts_.bodies[at(second)], states, w)
                                : hits_obstacle(body, parts_.obstacles[at(second - bodies)], states, w));
    if (states == 0) return 0;
  }
  return states;
}

unsigned SphereModel::hits_obstacle(const Body& body, const Obstacle& obstacle, unsigned states, Workspace& w) const {
  const std::size_t first = at(body.first_ball);
  if ((meets(obstacle, parts_.planes, w.centres[first], parts_.balls[first].radius) & states) == 0) return 0;
  w.pose_fine(parts_, body);
  unsigned hit = 0;
  for (std::size_t k = first + 1; k < first + at(body.balls) && (states & ~hit) != 0; ++k) {
    hit |= meets(obstacle, parts_.planes, w.centres[k], parts_.balls[k].radius) & states;
  }
  return hit;
}

unsigned SphereModel::hits_body(const Body& a, const Body& b, unsigned states, Workspace& w) const {
  const auto& balls = parts_.balls;
  const std::size_t first_a = at(a.first_ball), first_b = at(b.first_ball);
  if ((meet(w.centres[first_a], w.centres[first_b], balls[first_a].radius + balls[first_b].radius) & states) == 0) {
    return 0;
  }
  w.pose_fine(parts_, a);
  w.pose_fine(parts_, b);
  unsigned hit = 0;
  for (std::size_t i = first_a + 1; i < first_a + at(a.balls) && (states & ~hit) != 0; ++i) {
    if ((meet(w.centres[i], w.centres[first_b], balls[i].radius + balls[first_b].radius) & states) == 0) continue;
    for (std::size_t k = first_b + 1; k < first_b + at(b.balls); ++k) {
      hit |= meet(w.centres[i], w.centres[k], balls[i].radius + balls[k].radius) & states;
    }
  }
  return hit;
}

}  // namespace plannercheck
