// The data of one thread that checks motions: the grid, its open pairs, and memory of the screens before it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "math/recent_rate.hpp"
#include "motions/adaptive_subdivision.hpp"
#include "motions/motion_certifier.hpp"
#include "motions/motion_collisions.hpp"
#include "motions/motion_filters.hpp"
#include "motions/motion_screen.hpp"

namespace plannercheck {

// So many motions at once have states judged: whole blocks of them, also of what a first look leaves.
inline constexpr std::size_t kMotionsAtOnce = 128;

// How often states collide, by the places where motions are looked at; all of these are tried again now and then.
inline constexpr std::size_t kLooks = 3;
inline constexpr RecentRate kUnknownLook{64, 512, 8, 1};
using LookRates = std::array<RecentRate, kLooks>;

// The Space of adaptive_subdivision.hpp.
struct SpatialMotions {
  using Pair = CertifiedPair;
  using Poses = PosedPair;
  using Direction = Vec3;
  using Grid = MotionGrid;
  using Open = DirectedPair;
  using Counters = MotionCounters;
  using Workspace = MotionCertifier::Workspace;
};

struct MotionCertifier::Workspace : SubdivisionWorkspace<SpatialMotions> {
  explicit Workspace(const MotionModel& model)
      : SubdivisionWorkspace(MotionGrid(model.bodies, at(model.width), at(model.links)), model.pairs.size()),
        path(at(model.width), model.parts) {}

  Path path;
  Rates rates, tube_rates;
  ChainBounds bounds, tube_bounds;
  MotionGrid::Choice all, chosen;  // what the first grids and those inside them pose
  std::uint64_t prepared_for = 0;  // the kinematics by which `all` poses
  MotionScreen::Workspace screen;
  MotionCollisions::Workspace collisions;
  std::vector<std::int32_t> candidates, bodies, frames;
  std::shared_ptr<CheckerCore::Workspace> states;
  PieceCovers covers;
  std::vector<std::uint8_t> cover_answers;
  std::array<std::uint8_t, kMotionsAtOnce>
      is_free{};                                     // of the motions at once: no state of it that was judged collides
  std::array<std::uint8_t, kMotionsAtOnce> found{};  // verdicts of `rows`
  std::array<std::size_t, kMotionsAtOnce> motion_of_row{};
  std::vector<double> rows;                                        // configurations that are judged together
  LookRates looks{kUnknownLook, kUnknownLook, kUnknownLook};       // of all motions
  std::array<LookRates, kLooks> later_looks{looks, looks, looks};  // by a place where the motions were found free
};

}  // namespace plannercheck
