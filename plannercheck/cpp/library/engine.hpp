// What a level of instructions does for the library: the checkers and certifiers of one cell, behind a table of virtual
// functions, since of each level the library knows one function only (library.cmake).
//
// In: a prepared cell's file; configurations and motions that are finite and of the right width. Out: the core's
// answers. This header is free of lanes. What is thrown ends at the face (checker.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "distances/distance_core.hpp"
#include "library/cell_edits.hpp"
#include "library/prepared_cell.hpp"
#include "motions/motion_report.hpp"
#include "narrow_phase/separating_plane.hpp"

namespace plannercheck {

class Engine {
 public:
  // The scratch of one thread.
  struct Scratch {
    virtual ~Scratch() = default;
  };

  virtual ~Engine() = default;
  virtual const PreparedCell& cell() const = 0;
  // For the scene that an edit makes; throws std::runtime_error.
  virtual std::unique_ptr<Engine> edited(const Edit& edit) const = 0;
  virtual std::unique_ptr<Scratch> new_scratch() const = 0;

  // Whether each of n configurations is free, by the pairs of a table.
  virtual void check_states(Table table, const double* q, std::size_t n, std::uint8_t* valid,
                            Scratch& scratch) const = 0;
  // The pairs that collide at a configuration, by the cell's rows, and a point that each shares; if `planes`, all
  // others as well, with the plane between both bodies, if there is one.
  struct Contact {
    std::size_t row;
    Vec3 point;
  };
  struct Apart {
    std::size_t row;
    std::optional<SeparatingPlane> plane;
  };
  struct Explained {
    std::vector<Contact> contacts;
    std::vector<Apart> apart;
  };
  virtual Explained explain(const double* q, bool planes, Scratch& scratch) const = 0;
  // The MotionAnswer of each of n motions.
  virtual void check_motions(Table table, const Segments& motions, std::size_t n, double tolerance,
                             std::uint8_t* answers, Scratch& scratch) const = 0;
  // Its pair is a row of the cell's.
  virtual MotionReport explain_motion(Table table, const Segment& motion, double tolerance, Scratch& scratch) const = 0;
  // The pairs that are nearer than the limit at n configurations, by the cell's rows; if `nearest` is not 0, so many of
  // each.
  virtual DistanceTable distances(const double* q, std::size_t n, double limit, std::size_t nearest,
                                  Scratch& scratch) const = 0;
};

// Makes the engine of a file's content; `name` is the file's in errors. Throws std::runtime_error.
using EngineMaker = Engine*(std::span<const std::byte> file, const std::string& name);

// The best level that the library has and this processor runs, or the one that PLANNERCHECK_LEVEL names; throws
// std::runtime_error if there is none.
struct Level {
  const char* name;
  bool (*runs)();
  EngineMaker* make;
};
const Level& chosen_level();

}  // namespace plannercheck
