// Which pairs of bodies may touch, for a block of states at once or for one state. A search (candidate_search.hpp)
// brings the pairs whose bounding balls meet; of these, balls and boxes inside bodies prove collisions, and boxes
// around bodies prove others apart (body_bounds.hpp).
//
// In: links' poses in floats. Out: the states that surely collide, if only that counts, and for every other state the
// pairs that no filter decides. No filter changes a verdict. Immutable; the workspace is the caller's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "broad_phase/body_bounds.hpp"
#include "broad_phase/candidate_search.hpp"
#include "broad_phase/likely_overlaps.hpp"
#include "broad_phase/near_pairs.hpp"
#include "broad_phase/poses.hpp"

namespace plannercheck {

class BroadPhase {
 public:
  // `permanent`: for each pair, whether both bodies stand still and share a point. Other such pairs are apart.
  // `in_cells`: pairs of moving bodies that are looked up by the configuration first.
  BroadPhase(const std::vector<GeometryObject>& bodies, const std::vector<std::array<std::int32_t, 2>>& pairs,
             const std::vector<bool>& permanent, std::shared_ptr<const SampledPoses> sampled,
             const std::vector<PairsInCells>& in_cells);

  // A pair, and the number of states in which it was found to overlap.
  struct Overlap {
    std::size_t pair = 0;
    int states = 0;
  };

  struct Workspace {
    CandidateSearch::Workspace search;
    BodyBounds::Posed<FloatBlock> in_block;
    BodyBounds::Posed<SingleState> in_state;
    LikelyOverlaps likely;  // learnt from all calls
    Overlap overlap;        // the largest one found by the last call of `find`
    Found found;            // what that call has found

    auto& posed(const FloatBlock&) { return in_block; }
    auto& posed(const SingleState&) { return in_state; }
  };
  Workspace new_workspace() const;

  // Filters in use.
  struct Filters {
    bool bounds;    // without them, all pairs are near
    bool overlaps;  // finds states that surely collide, whose other pairs are then skipped
    bool boxes;     // of blocks: for one state, those in doubles are better (pair_frame.hpp)
    bool learning;  // with overlaps: pairs that overlapped lately are tried first
  };

  // Poses: FloatBlock or SingleState.
  template <class Poses>
  void find(Poses& poses, Filters filters, Workspace& workspace) const;

 private:
  std::size_t pairs_;                          // how many
  std::vector<std::int32_t> permanent_pairs_;  // these collide in every state
  CandidateSearch search_;
  BodyBounds bounds_;

  void take_all(unsigned states, Found& found) const;
  void take_overlapping(unsigned states, Found& found) const;
  template <class Poses>
  void find_by_bounds(Poses& poses, Filters filters, Workspace& workspace) const;
  template <class Poses>
  void try_likely(Poses& poses, Workspace& workspace) const;
  static void take_overlap(std::size_t pair, unsigned states, Workspace& workspace);
  template <class Poses>
  void filter(Candidate& candidate, Poses& poses, Filters filters, Workspace& workspace) const;
  static void drop(Candidate& candidate, unsigned apart, Found& found);
  template <class Poses>
  void sort_by_state(Poses& poses, Filters filters, Workspace& workspace) const;
};

}  // namespace plannercheck
