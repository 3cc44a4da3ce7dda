#include "checker.hpp"

#include <algorithm>

namespace plannercheck {
namespace {

std::size_t at(std::int32_t index) { return static_cast<std::size_t>(index); }

// Poses stretch by 1e-6 at most, and posing a centre errs by about 10u of its distance: this covers both.
constexpr double kStretch = 1 + 2e-6;
constexpr double kCentreError = 64 * 0x1p-53;
constexpr double kDefect = 2e-6;  // twice what a pose may be off rigid

}  // namespace

CheckerCore::CheckerCore(std::vector<MountedBody> bodies, std::vector<std::array<std::int32_t, 2>> pairs,
                         std::int32_t links, CheckerOptions options)
    : bodies_(std::move(bodies)), pairs_(std::move(pairs)), links_(links), needed_(at(links), 0), options_(options) {
  for (auto& pair : pairs_) {
    if (choose_host(*bodies_[at(pair[0])].body, *bodies_[at(pair[1])].body) == 0) std::swap(pair[0], pair[1]);
    for (const std::int32_t body : pair) {
      if (bodies_[at(body)].link >= 0) needed_[at(bodies_[at(body)].link)] = 1;
    }
  }
}

CheckerCore::Workspace::Workspace(const CheckerCore& checker)
    : poses(checker.body_count()),
      centres(checker.body_count()),
      posed_for(checker.body_count(), -1),
      planes(checker.pair_count()) {
  for (std::size_t b = 0; b < checker.body_count(); ++b) {
    if (checker.bodies_[b].link >= 0) continue;
    poses[b] = checker.bodies_[b].placement;
    centres[b] = poses[b].apply(checker.bodies_[b].body->centre);
  }
}

Pose CheckerCore::body_pose(std::size_t body, const double* links, std::size_t stride) const {
  const MountedBody& mounted = bodies_[body];
  if (mounted.link < 0) return mounted.placement;
  const double* l = links + at(mounted.link) * stride;
  const auto& p = mounted.placement.m;
  Pose out;
  for (std::size_t i = 0; i < 12; i += 4) {
    for (std::size_t j = 0; j < 4; ++j) {
      const double sum = (l[i] * p[j] + l[i + 1] * p[j + 4]) + l[i + 2] * p[j + 8];
      out.m[i + j] = j == 3 ? sum + l[i + 3] : sum;
    }
  }
  return out;
}

void CheckerCore::pose_for(std::int32_t body, const double* links, std::size_t stride, Workspace& w) const {
  const std::int32_t link = bodies_[at(body)].link;
  if (link < 0 || w.posed_for[at(body)] == w.state) return;
  w.posed_for[at(body)] = w.state;
  w.poses[at(body)] = body_pose(at(body), links, stride);
  w.centres[at(body)] = w.poses[at(body)].apply(bodies_[at(body)].body->centre);
}

bool CheckerCore::spheres_apart(std::int32_t a, std::int32_t b, const Workspace& w) const {
  const Vec3 ca = w.centres[at(a)], cb = w.centres[at(b)], d = ca - cb;
  const double radii = (bodies_[at(a)].body->radius + bodies_[at(b)].body->radius) * kStretch;
  const double reaches = bodies_[at(a)].body->reach + bodies_[at(b)].body->reach;
  const double apart = radii + kCentreError * (norm_1(ca) + norm_1(cb) + reaches);
  return dot(d, d) > apart * apart * (1 + 1e-12);
}

// One body's sphere against the other's box in that body's frame. The transpose stands for the inverse of the pose,
// which displaces the centre by at most kDefect of its distance; the sphere is enlarged by that.
bool CheckerCore::sphere_misses_box(std::int32_t sphere, std::int32_t box, const Workspace& w) const {
  const Body& b = *bodies_[at(box)].body;
  const Pose& pose = w.poses[at(box)];
  const Vec3 centre = w.centres[at(sphere)], from = centre - pose.translation();
  const Vec3 c = pose.rotate_back(from);
  const Vec3 beyond{larger(0, larger(b.low.x - c.x, c.x - b.high.x)), larger(0, larger(b.low.y - c.y, c.y - b.high.y)),
                    larger(0, larger(b.low.z - c.z, c.z - b.high.z))};
  const double radius = bodies_[at(sphere)].body->radius * kStretch + kDefect * norm_1(from) +
                        kCentreError * (norm_1(centre) + norm_1(pose.translation()) + bodies_[at(sphere)].body->reach + b.reach);
  return dot(beyond, beyond) > radius * radius * (1 + 1e-12);
}

bool CheckerCore::collides(std::size_t pair, const double* links, std::size_t stride, Workspace& w) const {
  const auto [guest, host] = pairs_[pair];
  pose_for(guest, links, stride, w);
  pose_for(host, links, stride, w);
  ++w.counters.pairs;
  if (options_.spheres && spheres_apart(guest, host, w)) {
    ++w.counters.spheres;
    return false;
  }
  if (options_.boxes && (sphere_misses_box(guest, host, w) || sphere_misses_box(host, guest, w))) {
    ++w.counters.boxes;
    return false;
  }
  const PairVerdict verdict = test_pair({bodies_[at(guest)].body.get(), w.poses[at(guest)]},
                                        {bodies_[at(host)].body.get(), w.poses[at(host)]}, options_.pair, &w.planes[pair],
                                        w.counters.pair);
  ++w.counters.stages[static_cast<std::size_t>(verdict.stage)];
  return verdict.shared;
}

std::int32_t CheckerCore::first_collision(const double* links, std::size_t stride, Workspace& w) const {
  ++w.state, ++w.counters.states;
  for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
    if (collides(pair, links, stride, w)) return static_cast<std::int32_t>(pair);
  }
  return -1;
}

void CheckerCore::all_collisions(const double* links, std::size_t stride, Workspace& w, bool* colliding) const {
  ++w.state, ++w.counters.states;
  for (std::size_t pair = 0; pair < pairs_.size(); ++pair) colliding[pair] = collides(pair, links, stride, w);
}

PairVerdict CheckerCore::explain_pair(std::size_t pair, const double* links, std::size_t stride, Workspace& w,
                                      PosedBody* guest, PosedBody* host) const {
  ++w.state;
  const auto [g, h] = pairs_[pair];
  pose_for(g, links, stride, w);
  pose_for(h, links, stride, w);
  *guest = {bodies_[at(g)].body.get(), w.poses[at(g)]};
  *host = {bodies_[at(h)].body.get(), w.poses[at(h)]};
  return test_pair(*guest, *host, options_.pair, nullptr, w.counters.pair);
}

void CheckerCore::check(const Kinematics& kinematics, const double* q, std::size_t n, std::int32_t* first,
                        Workspace& w) const {
  const auto width = static_cast<std::size_t>(kinematics.width());
  const std::size_t links = at(links_);
  w.links.resize(links * 12);
  w.scratch.resize(at(kinematics.scratch_size()));
  std::vector<Lanes> columns(width);
  std::vector<double> poses(links * 12 * kLanes);
  for (std::size_t row = 0; row < n; row += kLanes) {
    const std::size_t count = std::min<std::size_t>(kLanes, n - row);
    for (std::size_t c = 0; c < width; ++c) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) columns[c][lane] = q[(row + std::min(lane, count - 1)) * width + c];
    }
    kinematics.link_poses(columns.data(), needed_.data(), w.scratch.data(), w.links.data());
    for (std::size_t entry = 0; entry < links * 12; ++entry) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) poses[lane * links * 12 + entry] = w.links[entry][lane];
    }
    for (std::size_t lane = 0; lane < count; ++lane) {
      first[row + lane] = first_collision(&poses[lane * links * 12], 12, w);
    }
  }
}

}  // namespace plannercheck
