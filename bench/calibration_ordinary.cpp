/// Ordinary use, case by case: how often the truth lies inside what is stated, and what is left at the end.
#include <cstdio>

#include "bench/ordinary_use.h"

namespace stillpoint::bench {

void ordinary_use(unsigned first_seed, unsigned seeds) {
  std::printf(
      "\n== Ordinary use; seeds %u to %u; share of judged values inside 3 stated sd, rms over seeds at the end of the "
      "error and of the stated sd ==\n%-26s %-16s %9s %11s %11s %9s\n",
      first_seed, first_seed + seeds - 1, "case", "quantity", "inside %", "error", "stated", "unstated");
  for (const UseCase& use : use_cases())
    for (const auto& [quantity, s] : score(use, first_seed, seeds))
      std::printf("%-26s %-16s %9.1f %11.5f %11.5f %9d\n", use.name, quantity.c_str(), s.inside_percent, s.error,
                  s.stated, s.judged - s.stated_at_all);
}

}  // namespace stillpoint::bench
