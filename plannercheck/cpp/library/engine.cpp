// The engine of one level: a cell's pairs compiled twice, those that can meet within the limits and all of them
// (plannercheck/checking/compiled_tables.py), the latter when first needed.
#include "library/engine.hpp"

#include <algorithm>
#include <array>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "checking/checker.hpp"
#include "motions/motion_certifier.hpp"
#include "narrow_phase/shared_point.hpp"

namespace plannercheck {
namespace {

// Some of a cell's pairs, their bodies, and the place of each of the cell's bodies among these.
struct CellPairs {
  std::vector<GeometryObject> objects;
  std::vector<std::int32_t> place;
  std::vector<std::array<std::int32_t, 2>> pairs;
  std::int32_t link_count;

  CellPairs(const PreparedCell& cell, const std::vector<std::int32_t>& rows)
      : link_count(static_cast<std::int32_t>(cell.links.size())) {
    std::vector<bool> used(cell.bodies.size(), false);
    for (const std::int32_t row : rows) {
      for (const std::int32_t body : cell.pairs[at(row)]) used[at(body)] = true;
    }
    for (std::size_t k = 0; k < used.size(); ++k) {
      place.push_back(used[k] ? static_cast<std::int32_t>(objects.size()) : -1);
      if (used[k]) objects.push_back(cell.bodies[k]);
    }
    for (const std::int32_t row : rows) {
      const auto& [a, b] = cell.pairs[at(row)];
      pairs.push_back({place[at(a)], place[at(b)]});
    }
  }
};

// Made when first asked for; what `make` throws is thrown by each call.
template <class T>
class Lazily {
 public:
  template <class Make>
  const T& get(Make make) const {
    std::call_once(once_, [&] { made_ = make(); });
    return *made_;
  }

 private:
  mutable std::once_flag once_;
  mutable std::shared_ptr<const T> made_;
};

class CompiledTable {
 public:
  CompiledTable(std::shared_ptr<const PreparedCell> cell, Table table)
      : cell_(std::move(cell)),
        chained_(cell_->chained(table)),
        rows_(rows_of(*cell_, table)),
        is_within_limits_(table == Table::kWithinLimits) {}

  const ChainedTable& chained() const { return chained_; }

  const CheckerCore& checker() const { return *shared_checker(); }

  const MotionCertifier& certifier() const {
    return certifier_.get([this] {
      MotionModel model = cell_->motion;
      const CellPairs bodies(*cell_, rows_);
      model.bodies = bodies.objects, model.chains = chained_.chains, model.pairs = chained_.pairs;
      for (CertifiedPair& pair : model.pairs) pair.a = bodies.place[at(pair.a)], pair.b = bodies.place[at(pair.b)];
      return std::make_shared<const MotionCertifier>(std::move(model), Tuning(), shared_checker());
    });
  }

 private:
  std::shared_ptr<const PreparedCell> cell_;
  const ChainedTable& chained_;
  std::vector<std::int32_t> rows_;
  bool is_within_limits_;
  Lazily<std::shared_ptr<const CheckerCore>> checker_;
  Lazily<MotionCertifier> certifier_;

  const std::shared_ptr<const CheckerCore>& shared_checker() const {
    return checker_.get([this] {
      const CellPairs some(*cell_, rows_);
      using Cells = std::vector<PairsInCells>;
      return std::make_shared<std::shared_ptr<const CheckerCore>>(
          std::make_shared<const CheckerCore>(some.objects, some.pairs, some.link_count, Tuning(), cell_->sampled,
                                              is_within_limits_ ? cell_->in_cells : Cells()));
    });
  }
};

struct TableScratch {
  std::shared_ptr<CheckerCore::Workspace> states;
  std::shared_ptr<MotionCertifier::Workspace> motions;
};

// What measures distances up to a limit, which takes a while to prepare.
struct PreparedLimit {
  std::shared_ptr<const DistanceCore> core;
  double limit = 0;
};

struct Measuring {
  PreparedLimit prepared;
  std::shared_ptr<DistanceCore::Workspace> workspace;
};

struct LevelScratch final : Engine::Scratch {
  TableScratch within_limits, all;
  Measuring measuring;
  std::vector<double> poses;
};

class LevelEngine final : public Engine {
 public:
  explicit LevelEngine(std::shared_ptr<const PreparedCell> cell)
      : cell_(std::move(cell)),
        kinematics_(static_cast<int>(cell_->width()), cell_->joints, cell_->links),
        within_limits_(cell_, Table::kWithinLimits),
        all_(cell_, Table::kAll) {
    static_cast<void>(within_limits_.checker());
  }

  const PreparedCell& cell() const override { return *cell_; }

  std::unique_ptr<Engine> edited(const Edit& edit) const override {
    return std::make_unique<LevelEngine>(std::make_shared<const PreparedCell>(plannercheck::edited(*cell_, edit)));
  }

  std::unique_ptr<Scratch> new_scratch() const override { return std::make_unique<LevelScratch>(); }

  void check_states(Table table, const double* q, std::size_t n, std::uint8_t* valid, Scratch& scratch) const override {
    const CompiledTable& pairs = compiled(table);
    pairs.checker().check_states(kinematics_, q, n, valid, states(pairs, scratch));
  }

  Explained explain(const double* q, bool planes, Scratch& scratch) const override {
    const CompiledTable& pairs = compiled(Table::kAll);
    constexpr std::size_t kPoseNumbers = 16;
    std::vector<double>& poses = static_cast<LevelScratch&>(scratch).poses;
    poses.assign(kPoseNumbers * cell_->links.size(), 0);
    const std::vector<unsigned char> needed(cell_->links.size(), 1);
    kinematics_.link_poses_batch(q, 1, needed.data(), poses.data());
    std::vector<std::uint8_t> colliding(cell_->pairs.size());
    pairs.checker().all_collisions(poses.data(), 1, colliding.data(), states(pairs, scratch));
    const auto posed = [&](std::int32_t body) -> PosedPolytope {
      const GeometryObject& object = cell_->bodies[at(body)];
      if (object.link < 0) return {object.body.get(), object.placement};
      std::array<double, 12> link;
      std::copy_n(poses.data() + kPoseNumbers * at(object.link), link.size(), link.begin());
      return {object.body.get(), placed_on(link, object.placement)};
    };
    Explained out;
    PairCounters counters;
    for (std::size_t row = 0; row < colliding.size(); ++row) {
      const auto [a, b] = cell_->pairs[row];
      if (colliding[row] != 0) {
        out.contacts.push_back({row, shared_point(posed(a), posed(b), counters)});
      } else if (planes) {
        out.apart.push_back({row, separating_plane(posed(a), posed(b), counters)});
      }
    }
    return out;
  }

  void check_motions(Table table, const Segments& motions, std::size_t n, double tolerance, std::uint8_t* answers,
                     Scratch& scratch) const override {
    const CompiledTable& pairs = compiled(table);
    const PoseRange range{cell_->usual_low.data(), cell_->usual_high.data()};
    pairs.certifier().check_pieces(kinematics_, motions, n, tolerance, cell_->kinematic_error, range, answers,
                                   certifying(pairs, scratch));
  }

  MotionReport explain_motion(Table table, const Segment& motion, double tolerance, Scratch& scratch) const override {
    const CompiledTable& pairs = compiled(table);
    MotionReport report = pairs.certifier().explain(kinematics_, motion, tolerance, cell_->kinematic_error, nullptr,
                                                    certifying(pairs, scratch));
    if (report.answer == MotionAnswer::kRefused) report.pair = pairs.chained().rows[at(report.pair)];
    return report;
  }

  DistanceTable distances(const double* q, std::size_t n, double limit, std::size_t nearest,
                          Scratch& scratch) const override {
    Measuring& own = static_cast<LevelScratch&>(scratch).measuring;
    if (own.prepared.core == nullptr || own.prepared.limit != limit) {
      own.prepared = prepared_for(limit);
      own.workspace = own.prepared.core->new_workspace();
    }
    const GivenStates states{&kinematics_, q, 0, n};
    std::vector<DistanceTable> table(1);
    if (nearest > 0) {
      own.prepared.core->nearest(states, &cell_->tangent, nearest, 0, table[0], *own.workspace);
    } else {
      own.prepared.core->measure(states, &cell_->tangent, table[0], *own.workspace);
    }
    return in_order(table, cell_->tangent.width);
  }

 private:
  std::shared_ptr<const PreparedCell> cell_;
  Kinematics kinematics_;
  CompiledTable within_limits_, all_;
  mutable std::mutex measuring_;
  mutable PreparedLimit last_limit_;

  PreparedLimit prepared_for(double limit) const {
    const std::lock_guard lock(measuring_);
    if (last_limit_.core == nullptr || last_limit_.limit != limit) {
      const CellPairs all(*cell_, rows_of(*cell_, Table::kAll));
      std::vector<double> paddings;
      for (std::size_t k = 0; k < all.place.size(); ++k) {
        if (all.place[k] >= 0) paddings.push_back(cell_->paddings[k]);
      }
      last_limit_ = {std::make_shared<const DistanceCore>(without_padding(all.objects, paddings), all.pairs,
                                                          all.link_count, limit, Tuning(), cell_->sampled),
                     limit};
    }
    return last_limit_;
  }

  // The compiled table: one serves for both if no pair is left out within the limits.
  const CompiledTable& compiled(Table table) const {
    return table == Table::kAll && cell_->has_limits ? all_ : within_limits_;
  }

  TableScratch& of_table(const CompiledTable& pairs, Scratch& scratch) const {
    auto& own = static_cast<LevelScratch&>(scratch);
    return &pairs == &all_ ? own.all : own.within_limits;
  }

  CheckerCore::Workspace& states(const CompiledTable& pairs, Scratch& scratch) const {
    TableScratch& own = of_table(pairs, scratch);
    if (own.states == nullptr) own.states = pairs.checker().new_workspace();
    return *own.states;
  }

  MotionCertifier::Workspace& certifying(const CompiledTable& pairs, Scratch& scratch) const {
    TableScratch& own = of_table(pairs, scratch);
    if (own.motions == nullptr) own.motions = pairs.certifier().new_workspace();
    return *own.motions;
  }
};

std::shared_ptr<const PreparedCell> cell_of(std::span<const std::byte> bytes, const std::string& name) {
  try {
    CellFile file(bytes);
    return std::make_shared<const PreparedCell>(read_cell(file));
  } catch (const CellError& error) {
    throw std::runtime_error(name + " " + error.what());
  } catch (const HullError& error) {
    throw std::runtime_error(name + " is damaged: a body: " + error.what());
  } catch (const PartSetError& error) {
    throw std::runtime_error(name + " is damaged: a body: " + error.what());
  }
}

}  // namespace
}  // namespace plannercheck

// The one symbol of a level that others see (EngineMaker). The caller owns the engine.
extern "C" plannercheck::Engine* PLANNERCHECK_ENGINE(std::span<const std::byte> file, const std::string& name) {
  return new plannercheck::LevelEngine(plannercheck::cell_of(file, name));
}
