// Threads that share a checker, each with a workspace of its own: share CELL. All ask for everything, distances up to
// limits that take turns, and scenes of their own; all have to get the same answers. For TSan.
#include <array>
#include <cstdio>
#include <plannercheck/checker.hpp>
#include <random>
#include <thread>
#include <vector>

namespace {

using plannercheck::Checker;

constexpr std::size_t kThreads = 4, kRounds = 20, kStates = 16;

std::vector<double> configurations(const Checker& checker, std::mt19937_64& random, std::size_t count) {
  std::vector<double> q;
  for (std::size_t i = 0; i < count * checker.nq(); ++i) {
    const std::size_t k = i % checker.nq();
    q.push_back(std::uniform_real_distribution<>(checker.lower()[k], checker.upper()[k])(random));
  }
  return q;
}

// Numbers of all answers for some configurations.
void ask(const Checker& checker, const std::vector<double>& q, std::size_t round, plannercheck::Workspace& workspace,
         std::vector<double>& out) {
  const std::size_t nq = checker.nq();
  std::vector<std::uint8_t> valid(kStates), free(kStates / 2);
  const std::span<const double> all(q), starts = all.first(nq * free.size()), ends = all.last(nq * free.size());
  static_cast<void>(checker.check_states(q, valid, workspace).value());
  static_cast<void>(checker.check_motions(starts, ends, free, workspace).value());
  out.insert(out.end(), valid.begin(), valid.end());
  out.insert(out.end(), free.begin(), free.end());
  out.push_back(static_cast<double>(checker.explain(all.first(nq), workspace).value().collisions.size()));
  for (const auto& row : checker.distances(q, workspace, round % 2 == 0 ? 0.1 : 0.05).value())
    out.push_back(row.distance);
  const std::array<double, 2> times{0, 1};
  const auto executed = plannercheck::Trajectory::executed(times, all.first(2 * nq)).value();
  out.push_back(checker.explain_trajectory(executed, workspace).value().free_until);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const Checker checker = Checker::load(arguments[1]).value();
  std::vector<std::vector<double>> answers(kThreads);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&checker, &mine = answers[t]] {
      std::mt19937_64 random(1);
      plannercheck::Workspace workspace, other;
      for (std::size_t round = 0; round < kRounds; ++round) {
        const std::vector<double> q = configurations(checker, random, kStates);
        ask(checker, q, round, workspace, mine);
        const std::array<double, 3> centre{0.5, 0.03125 * static_cast<double>(round), 0.5};
        ask(checker.with_sphere("ball", 0.125, centre).value(), q, round, other, mine);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& each : answers) {
    if (each != answers[0]) return std::fprintf(stderr, "threads disagree\n"), 1;
  }
  std::printf("%zu threads agree in %zu answers\n", kThreads, answers[0].size());
  return 0;
}
