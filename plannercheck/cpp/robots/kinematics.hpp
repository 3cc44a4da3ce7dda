// Forward kinematics of batches of configurations, from a flat table of joints.
//
// In: a table exported from Pinocchio's Model by plannercheck/robots/kinematics.py (joints, parents before children;
// links posed on joints), then group configurations. Out: world poses of the links, row-major 3x4, in m. Idea: links
// that depend on no variable are posed once, at construction, by the very same operations. The other links take one
// pass over the joints that carry some needed link. All operations are elementwise, so a pose has the same bits for
// every lane count, batch size and instruction set. Immutable, so threads may share it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "robots/joints.hpp"

namespace plannercheck {

struct Rigid {
  double m[12];  // row-major 3x4
};

// One number that a joint needs: multiplier * q[column] + offset, or offset alone if column is -1 (held).
struct JointValue {
  int column;
  double multiplier;
  double offset;
};

struct JointSpec {
  int parent;  // index of an earlier joint, or -1 for the world
  JointKind kind;
  double axis[3];
  Rigid placement;  // on the parent joint
  JointValue values[7];
};

struct LinkSpec {
  int joint;        // index of a joint, or -1 for the world
  Rigid placement;  // on that joint
};

// Carries a joint or link: a moving joint; else, if `posed`, something static at `pose`; else the world.
struct Anchor {
  int joint;  // among the moving joints, or -1
  bool posed;
  Rigid pose;
};

// Forms of a placement's rotation that save products with exact zeros and ones; kTurnX, kTurnY, kTurnZ keep that axis.
enum class PlacementForm : int { kTurnX, kTurnY, kTurnZ, kShift, kIdentity, kGeneral };

class Kinematics {
 public:
  Kinematics(int width, const std::vector<JointSpec>& joints, const std::vector<LinkSpec>& links);
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;

  // A number that no other one has or will have, for workspaces that keep what they prepared for it.
  std::uint64_t id() const { return id_; }
  int width() const { return width_; }  // of a group configuration
  int link_count() const { return static_cast<int>(links_.size()); }
  bool link_is_constant(int link) const { return links_[static_cast<std::size_t>(link)].joint < 0; }

  // Poses of the links for n configurations (n, width) in memory order; out (n, links, 4, 4); a link with
  // needed[link] == 0 stays as it was. Allocates its scratch.
  void link_poses_batch(const double* q, long long n, const unsigned char* needed, double* out) const;

  struct Joint {
    int parent;  // among the moving joints, or -1 if `placement` is in the world
    JointKind kind;
    bool held;  // its own values are constants, though its parent moves
    double axis[3];
    Rigid placement;
    PlacementForm form;
    JointValue values[7];
    double held_values[7];  // with cosine and sine in place of an angle
  };

  struct Link {
    int joint;  // among the moving joints, or -1 if `placement` is in the world
    Rigid placement;
    PlacementForm form;
  };

  const std::vector<Joint>& joints() const { return joints_; }  // only those that move
  const std::vector<Link>& links() const { return links_; }

 private:
  Anchor add_joint(const JointSpec& spec, const std::vector<Anchor>& anchors);
  void link_poses_of_state(const double* q, const unsigned char* needed, double* out) const;

  std::uint64_t id_;
  int width_;
  std::vector<Joint> joints_;
  std::vector<Link> links_;
};

}  // namespace plannercheck
