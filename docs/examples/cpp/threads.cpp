// Judges random configurations on four threads, each with a workspace of its own: ./threads cell.plannercheck
#include <cstdio>
#include <plannercheck/checker.hpp>
#include <random>
#include <string>
#include <thread>
#include <vector>

int main(int count, char** arguments) {
  const auto loaded = plannercheck::Checker::load(count > 1 ? arguments[1] : "cell.plannercheck");
  if (!loaded.ok()) {
    std::fprintf(stderr, "%s\n", std::string(loaded.error()).c_str());
    return 1;
  }
  constexpr std::size_t kThreads = 4, kStates = 5000;
  std::vector<std::size_t> valid(kThreads);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&valid, t, checker = loaded.value()] {
      std::mt19937_64 random(t);
      std::vector<double> q;
      for (std::size_t i = 0; i < kStates * checker.nq(); ++i) {
        const std::size_t k = i % checker.nq();
        q.push_back(std::uniform_real_distribution<>(checker.lower()[k], checker.upper()[k])(random));
      }
      plannercheck::Workspace workspace;
      std::vector<std::uint8_t> is_valid(kStates);
      valid[t] = checker.check_states(q, is_valid, workspace).value();
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t t = 0; t < kThreads; ++t) std::printf("thread %zu: %zu of %zu are valid\n", t, valid[t], kStates);
  return 0;
}
