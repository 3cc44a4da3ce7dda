// The face's other scenes: an edit is made of what is given, and a checker of its own.
#include <algorithm>
#include <array>
#include <cmath>

#include "library/checker_impl.hpp"
#include "math/box.hpp"

namespace plannercheck {
namespace {

// A hull needs so many points (plannercheck/bodies/shapes.py).
constexpr std::size_t kFewestPoints = 4;

Edit edit_of(Edit::Kind kind, const std::string& name, Checker::Pose pose) {
  Edit edit{kind, name, {}, {}};
  std::copy(pose.begin(), pose.end(), edit.matrix.begin());
  return edit;
}

std::vector<Vec3> points_of(const char* what, std::span<const double> numbers) {
  if (numbers.size() % 3 != 0)
    throw CallError(std::string(what) + " must have shape (n, 3), not (" + std::to_string(numbers.size()) + ",)");
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < numbers.size(); i += 3) points.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  return points;
}

}  // namespace

Result<Checker> Checker::with_box(const std::string& name, std::span<const double, 3> size, Pose pose) const noexcept {
  return guarded<Checker>([&] {
    for (std::size_t k = 0; k < size.size(); ++k) {
      if (!(size[k] >= 0 && std::isfinite(size[k])))
        throw CallError(std::string("box size ") + "xyz"[k] + " must be finite and not negative (m), not " +
                        shown(size[k]));
    }
    Edit edit = edit_of(Edit::Kind::kHull, name, pose);
    const Vec3 half = 0.5 * Vec3{size[0], size[1], size[2]};
    edit.points = Box{-half, half}.corners();
    return Checker(std::make_shared<const Impl>(*impl_, edit));
  });
}

Result<Checker> Checker::with_sphere(const std::string& name, double radius,
                                     std::span<const double, 3> centre) const noexcept {
  return guarded<Checker>([&] {
    const std::array<double, 16> pose{1, 0, 0, centre[0], 0, 1, 0, centre[1], 0, 0, 1, centre[2], 0, 0, 0, 1};
    const Edit edit{Edit::Kind::kHull, name, pose, {{0, 0, 0}}, radius};
    return Checker(std::make_shared<const Impl>(*impl_, edit));
  });
}

Result<Checker> Checker::with_hull(const std::string& name, std::span<const double> points, Pose pose) const noexcept {
  return guarded<Checker>([&] {
    Edit edit = edit_of(Edit::Kind::kHull, name, pose);
    edit.points = points_of("hull vertices", points);
    if (edit.points.size() < kFewestPoints)
      throw CallError("hull vertices: a body needs at least 4 points, here are " + std::to_string(edit.points.size()));
    return Checker(std::make_shared<const Impl>(*impl_, edit));
  });
}

Result<Checker> Checker::with_cloud(const std::string& name, std::span<const double> points, double radius,
                                    Pose pose) const noexcept {
  return guarded<Checker>([&] {
    Edit edit = edit_of(Edit::Kind::kCloud, name, pose);
    edit.points = points_of("points of a cloud", points), edit.radius = radius;
    return Checker(std::make_shared<const Impl>(*impl_, edit));
  });
}

Result<Checker> Checker::with_pose(const std::string& name, Pose pose) const noexcept {
  return guarded<Checker>(
      [&] { return Checker(std::make_shared<const Impl>(*impl_, edit_of(Edit::Kind::kMove, name, pose))); });
}

Result<Checker> Checker::without(const std::string& name) const noexcept {
  return guarded<Checker>(
      [&] { return Checker(std::make_shared<const Impl>(*impl_, Edit{Edit::Kind::kRemove, name, {}, {}})); });
}

}  // namespace plannercheck
