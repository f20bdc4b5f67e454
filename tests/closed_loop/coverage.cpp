// How often the 95 % intervals of an identification hold the truth, term by term and pooled:
//   identify_coverage [SEEDS [SAMPLES]]
// Ends with 1 if the pooled share is outside 94 to 96 % or that of a term outside 92 to 98 % (for 1000
// seeds).

#include <fmt/core.h>

#include <cstdlib>
#include <map>
#include <string>

#include "test_hidden_machine.h"

int main(int argc, char** argv) {
  using namespace abbe;
  const long seeds = argc > 1 ? std::atol(argv[1]) : 1000;
  const int samples = argc > 2 ? std::atoi(argv[2]) : 120;
  const Machine machine = test::machine_of(test::kChain + test::kHiddenErrors),
                known = test::machine_of(test::kChain);
  IdentifyOptions options;
  options.noise = 0.1 * um;
  SimulationSettings settings = test::quiet();
  settings.noise = 0;
  const Identification truth = identify_jointly(known, test::measure(machine, settings, samples), options);
  settings = test::quiet();
  std::map<std::string, long> covered;
  long pooled = 0, trusted = 0;
  for (long seed = 1; seed <= seeds; ++seed) {
    settings.seed = static_cast<std::uint64_t>(seed);
    const Identification found = identify_jointly(known, test::measure(machine, settings, samples), options);
    trusted += found.trusted ? 1 : 0;
    for (std::size_t k = 0; k < found.terms.size(); ++k) {
      if (!found.terms[k].identifiable) continue;
      const bool holds =
          std::abs(found.terms[k].value - truth.terms[k].value) <= 1.96 * found.terms[k].uncertainty;
      covered[to_string(found.terms[k].term, known)] += holds ? 1 : 0;
      pooled += holds ? 1 : 0;
    }
  }
  bool good = !covered.empty();
  for (const auto& [term, count] : covered) {
    const double share = 100.0 * static_cast<double>(count) / static_cast<double>(seeds);
    fmt::print("{:<18}{:>7.1f} %\n", term, share);
    good = good && share >= 92 && share <= 98;
  }
  const double share =
      100.0 * static_cast<double>(pooled) / static_cast<double>(seeds * static_cast<long>(covered.size()));
  fmt::print("{:<18}{:>7.2f} %   trusted {} of {}\n", "pooled", share, trusted, seeds);
  return good && share >= 94 && share <= 96 ? 0 : 1;
}
