/// Runs a harness where the compiler has no libFuzzer: replays inputs, then damages them at random, without looking at
/// what the program does with them. Options and last line are libFuzzer's.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>

#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/kept_input.h"
#include "tests/fuzz/mutator.h"

#define STILLPOINT_HARNESS(name) extern "C" int fuzz_##name(const std::uint8_t* data, std::size_t size);
#include "harnesses.inc"
#undef STILLPOINT_HARNESS

namespace stillpoint::fuzz {
namespace {

constexpr const char* kUsage =
    "usage: test_fuzz HARNESS [-runs=N] [-max_total_time=S] [-seed=N] [-max_len=N] [-timeout=S] [-dict=FILE]\n"
    "                         [-artifact_prefix=FOLDER/] [FOLDER_OR_FILE...]\n"
    "Replays the inputs; with a folder among them it goes on with damaged ones, without end unless an option says so.\n"
    "Harnesses:";

struct Harness {
  std::string_view name;
  int (*run)(const std::uint8_t*, std::size_t);
};
constexpr Harness kHarnesses[] = {
#define STILLPOINT_HARNESS(name) {#name, fuzz_##name},
#include "harnesses.inc"
#undef STILLPOINT_HARNESS
};

struct Options {
  std::int64_t runs = -1;           ///< the replayed ones included; below 0: no limit
  std::int64_t max_total_time = 0;  ///< s; 0: no limit
  std::int64_t seed = 1;
  std::int64_t max_len = 0;   ///< 0: 4096, or the longest of the inputs
  std::int64_t timeout = 60;  ///< s, of one run
  std::string dict, artifact_prefix;
  std::vector<std::string> paths;
};

/// False: not one of ours.
bool take_option(std::string_view argument, Options& o) {
  const auto equals = argument.find('=');
  if (argument.empty() || argument[0] != '-' || equals == std::string_view::npos) return false;
  const std::string_view name = argument.substr(1, equals - 1), value = argument.substr(equals + 1);
  if (name == "dict") return o.dict = value, true;
  if (name == "artifact_prefix") return o.artifact_prefix = value, true;
  for (const auto& [known, to] : {std::pair<std::string_view, std::int64_t*>{"runs", &o.runs},
                                  {"max_total_time", &o.max_total_time},
                                  {"seed", &o.seed},
                                  {"max_len", &o.max_len},
                                  {"timeout", &o.timeout}})
    if (name == known) {
      const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), *to);
      return error == std::errc{} && end == value.data() + value.size();
    }
  return false;
}

class Run {
 public:
  Run(const Harness& harness, Options options) : harness_(harness), options_(std::move(options)) {}

  int all() {
    keep_fatal_inputs(options_.artifact_prefix, static_cast<unsigned>(options_.timeout));
    const Inputs inputs = read_inputs(options_.paths);
    for (const std::string& input : inputs.texts) one(input);
    if (inputs.any_folder && inputs_taken == 0) {
      fmt::print(stderr, "not one of the inputs is taken: nothing is tried behind the first check\n");
      return 1;
    }
    if (inputs.any_folder) mutants(inputs.texts.empty() ? std::vector<std::string>{""} : inputs.texts);
    fmt::print("{} times more than a refusal\nDone {} runs in {} second(s)\n", inputs_taken, runs_, seconds());
    return 0;
  }

 private:
  void mutants(const std::vector<std::string>& inputs) {
    auto most_bytes = static_cast<std::size_t>(options_.max_len);
    if (most_bytes == 0) {
      most_bytes = 4096;
      for (const std::string& input : inputs) most_bytes = std::max(most_bytes, input.size());
    }
    Mutator mutator(read_dictionary(options_.dict), static_cast<std::uint64_t>(options_.seed), most_bytes);
    const auto has_time = [this] { return options_.max_total_time <= 0 || seconds() < options_.max_total_time; };
    while ((options_.runs < 0 || runs_ < options_.runs) && has_time()) one(mutator.mutant(inputs));
  }
  void one(const std::string& input) {
    // Its end is the end of an allocation, so that a sanitizer sees who reads on.
    const std::vector<std::uint8_t> exact(input.begin(), input.end());
    now_running(exact);
    harness_.run(exact.data(), exact.size());
    nothing_running();
    ++runs_;
  }
  [[nodiscard]] std::int64_t seconds() const {
    return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - start_).count();
  }

  const Harness& harness_;
  Options options_;
  std::int64_t runs_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

int usage() {
  fmt::print(stderr, "{}", kUsage);
  for (const Harness& h : kHarnesses) fmt::print(stderr, " {}", h.name);
  fmt::print(stderr, "\n");
  return 64;
}

}  // namespace
}  // namespace stillpoint::fuzz

int main(int argc, char** argv) {
  using namespace stillpoint::fuzz;
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty()) return usage();
  Options options;
  for (std::size_t i = 1; i < arguments.size(); ++i)
    if (!take_option(arguments[i], options)) {
      if (arguments[i].starts_with('-')) return usage();
      options.paths.push_back(arguments[i]);
    }
  for (const Harness& h : kHarnesses)
    if (h.name == arguments[0]) return Run(h, std::move(options)).all();
  return usage();
}
