#include "motions/link_bounds.hpp"

#include <algorithm>
#include <span>

#include "motions/motion_filters.hpp"

namespace plannercheck {
namespace {

// Whether each bound of a chain is at most that of another one, on any motion.
bool is_bounded_by(const MotionChains& chains, std::int32_t chain, std::int32_t other) {
  if (chain < 0 || other < 0) return chain < 0;
  const auto entries = [&](std::int32_t k) {
    return std::span(chains.entries)
        .subspan(at(chains.first_entry[at(k)]), at(chains.first_entry[at(k) + 1] - chains.first_entry[at(k)]));
  };
  const auto is_no_longer = [&](const ChainJoint& x, const ChainJoint& y) {
    const auto slides = [&](const ChainJoint& e) {
      return std::span(chains.slides).subspan(at(e.first_slide), at(e.past_slides - e.first_slide));
    };
    return x.joint == y.joint && x.arm <= y.arm && std::ranges::equal(slides(x), slides(y));
  };
  return std::ranges::equal(entries(chain), entries(other), is_no_longer);
}

}  // namespace

std::vector<LinkBound> link_bounds(const MotionModel& model, const std::vector<std::int32_t>& movers,
                                   std::vector<std::size_t>& bound_of) {
  const std::size_t none = model.bodies.size();
  std::vector<std::size_t> of_link(at(model.links), none), count;
  std::vector<LinkBound> bounds;
  bound_of.assign(model.bodies.size(), none);
  const auto centre = [&](std::int32_t body) {
    const GeometryObject& object = model.bodies[at(body)];
    return object.placement.apply(object.body->centre);
  };
  for (const std::int32_t body : movers) {
    const std::int32_t link = model.bodies[at(body)].link;
    if (of_link[at(link)] == none) {
      of_link[at(link)] = bounds.size();
      bounds.push_back({at(link), {}, 0, {{}, link}, 0}), count.push_back(0);
    }
    const std::size_t place = bound_of[at(body)] = of_link[at(link)];
    bounds[place].centre = bounds[place].centre + centre(body), ++count[place];
  }
  for (std::size_t k = 0; k < bounds.size(); ++k) {
    if (count[k] > 1) bounds[k].centre = (1 / static_cast<double>(count[k])) * bounds[k].centre;
  }
  for (const std::int32_t body : movers) {
    LinkBound& bound = bounds[bound_of[at(body)]];
    const GeometryObject& object = model.bodies[at(body)];
    const double way = norm(centre(body) - bound.centre) * kStretch;
    bound.radius = larger(bound.radius, way + sphere_radius(*object.body));
    bound.inflation_radius = larger(bound.inflation_radius, object.body->inflation_radius * kStretch);
    bound.box.add(box_around_hull(object));
  }
  return bounds;
}

std::vector<std::int32_t> longest_chains(const MotionChains& chains, std::vector<std::int32_t> some) {
  std::sort(some.begin(), some.end());
  some.erase(std::unique(some.begin(), some.end()), some.end());
  std::vector<std::int32_t> out;
  for (const std::int32_t chain : some) {
    const auto is_longer = [&](std::int32_t other) {
      return other != chain && is_bounded_by(chains, chain, other) &&
             (other < chain || !is_bounded_by(chains, other, chain));
    };
    if (std::none_of(some.begin(), some.end(), is_longer)) out.push_back(chain);
  }
  return out;
}

}  // namespace plannercheck
