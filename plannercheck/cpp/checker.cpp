#include "checker.hpp"

#include <algorithm>
#include <utility>

#include "kinematics_lanes.hpp"

namespace plannercheck {

// kLanes configurations at once: vectors and poses with one configuration a lane.
struct LaneVec3 {
  Lanes x, y, z;
};

struct LanePose {
  std::array<Lanes, 12> m;  // rows of the 3x4 matrix
};

namespace {

using LaneIndices = std::array<std::int32_t, kLanes>;

// Poses stretch by 1e-6 at most, and posing a centre errs by about 10u of its distance: this covers both.
constexpr double kStretch = 1 + 2e-6;
constexpr double kCentreError = 64 * 0x1p-53;
constexpr double kDefect = 2e-6;  // twice what a pose may be off rigid: the error of taking the transpose as inverse
constexpr double kSquareError = 1 + 1e-12;  // of comparing squared lengths

LanePose in_all_lanes(const Pose& pose) {
  LanePose out;
  for (std::size_t i = 0; i < 12; ++i) out.m[i] = broadcast(pose.m[i]);
  return out;
}

Pose lane_of(const LanePose& pose, int lane) {
  Pose out;
  for (std::size_t i = 0; i < 12; ++i) out.m[i] = pose.m[i][lane];
  return out;
}

// Link pose times placement, one formula for lanes and for single poses: the same bits.
template <class Number>
void compose(const Number* link, const std::array<double, 12>& p, Number* out) {
  for (std::size_t i = 0; i < 12; i += 4) {
    for (std::size_t j = 0; j < 4; ++j) {
      const Number sum = (link[i] * p[j] + link[i + 1] * p[j + 4]) + link[i + 2] * p[j + 8];
      out[i + j] = j == 3 ? sum + link[i + 3] : sum;
    }
  }
}

Lanes norm_1(const LaneVec3& v) { return (absolute(v.x) + absolute(v.y)) + absolute(v.z); }

constexpr std::size_t kPoseStride = 16;  // of posed links: row-major 4x4

}  // namespace

struct CheckerCore::Workspace {
  explicit Workspace(const CheckerCore& checker);

  CheckerCounters counters;
  std::vector<LanePose> poses;      // of the bodies, in the world
  std::vector<LaneVec3> centres;    // of the bodies, in the world
  std::vector<Lanes> slack, grown;  // rounding of posing a body; its radius enlarged by that
  std::vector<CachedPlane> planes;  // per pair
  std::vector<Lanes> columns, links, scratch;
};

CheckerCore::CheckerCore(std::vector<MountedBody> bodies, std::vector<std::array<std::int32_t, 2>> pairs,
                         std::int32_t links, CheckerOptions options)
    : bodies_(std::move(bodies)), pairs_(std::move(pairs)), links_(links), needed_(at(links), 0), options_(options) {
  std::vector<bool> used(bodies_.size(), false);
  for (auto& pair : pairs_) {
    if (choose_host(*bodies_[at(pair[0])].body, *bodies_[at(pair[1])].body) == 0) std::swap(pair[0], pair[1]);
    for (const std::int32_t body : pair) used[at(body)] = true;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!used[b] || bodies_[b].link < 0) continue;
    moving_.push_back(static_cast<std::int32_t>(b));
    needed_[at(bodies_[b].link)] = 1;
  }
}

CheckerCore::Workspace::Workspace(const CheckerCore& checker)
    : poses(checker.body_count()),
      centres(checker.body_count()),
      slack(checker.body_count()),
      grown(checker.body_count()),
      planes(checker.pair_count()),
      links(at(checker.links_) * 12) {
  for (std::size_t b = 0; b < checker.body_count(); ++b) {
    if (checker.bodies_[b].link >= 0) continue;
    poses[b] = in_all_lanes(checker.bodies_[b].placement);
    checker.bound_body(b, *this);
  }
}

std::shared_ptr<CheckerCore::Workspace> CheckerCore::new_workspace() const {
  return std::make_shared<Workspace>(*this);
}

CheckerCounters CheckerCore::take_counters(Workspace& w) { return std::exchange(w.counters, {}); }

Pose CheckerCore::body_pose(std::size_t body, const double* links) const {
  const MountedBody& mounted = bodies_[body];
  if (mounted.link < 0) return mounted.placement;
  Pose out;
  compose(links + at(mounted.link) * kPoseStride, mounted.placement.m, out.m.data());
  return out;
}

void CheckerCore::pose_bodies(Workspace& w) const {
  for (const std::int32_t body : moving_) {
    const MountedBody& mounted = bodies_[at(body)];
    compose(&w.links[at(mounted.link) * 12], mounted.placement.m, w.poses[at(body)].m.data());
    bound_body(at(body), w);
  }
}

void CheckerCore::bound_body(std::size_t body, Workspace& w) const {
  const Body& b = *bodies_[body].body;
  const auto& m = w.poses[body].m;
  const Vec3 c = b.centre;
  const LaneVec3 t{m[3], m[7], m[11]};
  w.centres[body] = {((m[0] * c.x + m[1] * c.y) + m[2] * c.z) + t.x, ((m[4] * c.x + m[5] * c.y) + m[6] * c.z) + t.y,
                     ((m[8] * c.x + m[9] * c.y) + m[10] * c.z) + t.z};
  w.slack[body] = kCentreError * ((norm_1(w.centres[body]) + norm_1(t)) + 2 * b.reach);
  w.grown[body] = (b.radius * kStretch + b.swell * kStretch) + w.slack[body];
}

unsigned CheckerCore::spheres_meet(std::size_t a, std::size_t b, const Workspace& w) const {
  const LaneVec3 &ca = w.centres[a], &cb = w.centres[b];
  const LaneVec3 d{ca.x - cb.x, ca.y - cb.y, ca.z - cb.z};
  const Lanes radii = w.grown[a] + w.grown[b];
  return bits((d.x * d.x + d.y * d.y) + d.z * d.z <= radii * radii * kSquareError);
}

// One body's sphere against the other's box in that body's frame.
unsigned CheckerCore::sphere_meets_box(std::size_t sphere, std::size_t box, const Workspace& w) const {
  const Body& b = *bodies_[box].body;
  const auto& m = w.poses[box].m;
  const LaneVec3& centre = w.centres[sphere];
  const LaneVec3 d{centre.x - m[3], centre.y - m[7], centre.z - m[11]};
  const auto beyond = [&](std::size_t column, double low, double high) {
    const Lanes c = (m[column] * d.x + m[column + 4] * d.y) + m[column + 8] * d.z;
    return larger(Lanes{}, larger(low - c, c - high));
  };
  const Lanes x = beyond(0, b.low.x, b.high.x), y = beyond(1, b.low.y, b.high.y), z = beyond(2, b.low.z, b.high.z);
  const Lanes radius = ((w.grown[sphere] + w.slack[box]) + b.swell * kStretch) + kDefect * norm_1(d);
  return bits((x * x + y * y) + z * z <= radius * radius * kSquareError);
}

unsigned CheckerCore::near(std::size_t pair, unsigned open, Workspace& w) const {
  const std::size_t guest = at(pairs_[pair][0]), host = at(pairs_[pair][1]);
  w.counters.pairs += __builtin_popcount(open);
  unsigned left = open;
  if (options_.spheres) {
    left &= spheres_meet(guest, host, w);
    w.counters.spheres += __builtin_popcount(open & ~left);
    if (left == 0) return 0;
  }
  if (options_.boxes) {
    const unsigned before = left;
    left &= sphere_meets_box(guest, host, w);
    if (left != 0) left &= sphere_meets_box(host, guest, w);
    w.counters.boxes += __builtin_popcount(before & ~left);
  }
  return left;
}

unsigned CheckerCore::collides(std::size_t pair, unsigned open, Workspace& w) const {
  const std::size_t guest = at(pairs_[pair][0]), host = at(pairs_[pair][1]);
  unsigned colliding = 0;
  for (unsigned left = near(pair, open, w); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const PairVerdict verdict = test_pair({bodies_[guest].body.get(), lane_of(w.poses[guest], lane)},
                                          {bodies_[host].body.get(), lane_of(w.poses[host], lane)}, options_.pair,
                                          &w.planes[pair], w.counters.pair);
    ++w.counters.stages[static_cast<std::size_t>(verdict.stage)];
    if (verdict.shared) colliding |= 1U << lane;
  }
  return colliding;
}

void CheckerCore::judge(unsigned open, std::int32_t* first, Workspace& w) const {
  std::fill_n(first, kLanes, -1);
  w.counters.states += __builtin_popcount(open);
  pose_bodies(w);
  for (std::size_t pair = 0; pair < pairs_.size() && open != 0; ++pair) {
    const unsigned colliding = collides(pair, open, w);
    open &= ~colliding;
    for (unsigned left = colliding; left != 0; left &= left - 1) {
      first[__builtin_ctz(left)] = static_cast<std::int32_t>(pair);
    }
  }
}

void CheckerCore::reserve_lanes(const Kinematics& kinematics, Workspace& w) const {
  w.columns.resize(at(kinematics.width()));
  w.scratch.resize(scratch_size(kinematics));
}

void CheckerCore::first_collisions(const Kinematics& kinematics, const double* q, std::size_t n, std::int32_t* first,
                                   Workspace& w) const {
  reserve_lanes(kinematics, w);
  const std::size_t width = w.columns.size();
  for (std::size_t row = 0; row < n; row += kLanes) {
    const std::size_t count = std::min<std::size_t>(kLanes, n - row);
    for (std::size_t c = 0; c < width; ++c) {
      for (std::size_t lane = 0; lane < kLanes; ++lane)
        w.columns[c][lane] = q[(row + std::min(lane, count - 1)) * width + c];
    }
    link_poses(kinematics, w.columns.data(), needed_.data(), w.scratch.data(), w.links.data());
    LaneIndices pairs;
    judge((1U << count) - 1, pairs.data(), w);
    std::copy_n(pairs.begin(), count, first + row);
  }
}

// Up to kLanes configurations' links; lanes beyond n repeat the last one.
void CheckerCore::load_links(const double* links, std::size_t n, Workspace& w) const {
  const std::size_t size = at(links_) * kPoseStride;
  for (std::size_t link = 0; link < at(links_); ++link) {
    for (std::size_t i = 0; i < 12; ++i) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        w.links[link * 12 + i][lane] = links[std::min(lane, n - 1) * size + link * kPoseStride + i];
      }
    }
  }
}

void CheckerCore::first_collisions(const double* links, std::size_t n, std::int32_t* first, Workspace& w) const {
  for (std::size_t row = 0; row < n; row += kLanes) {
    const std::size_t count = std::min<std::size_t>(kLanes, n - row);
    load_links(links + row * at(links_) * kPoseStride, count, w);
    LaneIndices pairs;
    judge((1U << count) - 1, pairs.data(), w);
    std::copy_n(pairs.begin(), count, first + row);
  }
}

void CheckerCore::all_collisions(const double* links, std::size_t n, std::uint8_t* colliding, Workspace& w) const {
  for (std::size_t row = 0; row < n; row += kLanes) {
    const std::size_t count = std::min<std::size_t>(kLanes, n - row);
    load_links(links + row * at(links_) * kPoseStride, count, w);
    w.counters.states += static_cast<long>(count);
    pose_bodies(w);
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
      const unsigned lanes = collides(pair, (1U << count) - 1, w);
      for (std::size_t lane = 0; lane < count; ++lane)
        colliding[(row + lane) * pairs_.size() + pair] = lanes >> lane & 1U;
    }
  }
}

bool CheckerCore::motion_is_free(const Kinematics& kinematics, const double* q0, const double* q1, long steps,
                                 Workspace& w) const {
  reserve_lanes(kinematics, w);
  const auto all_free = [&](long first, long stride, long last) {
    for (long k = first; k <= last; k += stride * kLanes) {
      const long count = std::min<long>(kLanes, (last - k) / stride + 1);
      for (int lane = 0; lane < kLanes; ++lane) {
        const long step = k + stride * std::min<long>(lane, count - 1);
        const double t = static_cast<double>(step) / static_cast<double>(steps);
        for (std::size_t c = 0; c < w.columns.size(); ++c) w.columns[c][lane] = (1 - t) * q0[c] + t * q1[c];
      }
      link_poses(kinematics, w.columns.data(), needed_.data(), w.scratch.data(), w.links.data());
      LaneIndices pairs;
      judge((1U << count) - 1, pairs.data(), w);
      if (std::any_of(pairs.begin(), pairs.end(), [](std::int32_t pair) { return pair >= 0; })) return false;
    }
    return true;
  };
  if (!all_free(0, steps, steps)) return false;
  long stride = 1;
  while (stride < steps) stride *= 2;
  for (; stride > 1; stride /= 2) {
    if (!all_free(stride / 2, stride, steps - 1)) return false;
  }
  return true;
}

}  // namespace plannercheck
