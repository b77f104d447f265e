/// `stillpoint diagnose`: locates, names and models the physics that a simulation left out of a recording.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <functional>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/diagnose_campaign.h"
#include "apps/stillpoint/laws_as_code.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/plausible.h"
#include "apps/stillpoint/progress.h"
#include "apps/stillpoint/simulated_log.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/foreign/foreign.h"
#include "diagnosis/forensics/forensics.h"
#include "diagnosis/heap.h"
#include "diagnosis/improved.h"
#include "diagnosis/report/report.h"
#include "diagnosis/summary.h"
#include "diagnosis/validation.h"
#include "io/config.h"
#include "io/recording.h"
#include "io/simulation_yaml.h"
#include "io/text_file.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::app {
namespace {

struct Options {
  std::string simulation, simulated, map, report, improved, validate, code;
  std::vector<std::string> recordings;
  JsonOption json;
  std::vector<std::string> without;
  std::size_t twins = 0;
  bool fail_on_mismatch = false;
};

/// Bias and matrix that were set right, as the effects were found beside them.
std::string numbers_to_paste(const diag::Answer& answer) {
  std::string out;
  for (std::size_t k = 0; k < diag::kSensorWord.size(); ++k)
    if (const auto& numbers = answer.numbers[k])
      out += fmt::format("{}: {{{}}}\n", diag::kSensorWord[k], io::format_numbers(*numbers));
  return out;
}

/// The found physics as blocks to paste: for the simulation, and for the daemon what it can take out in real time.
std::string blocks_to_paste(const diag::Answer& answer) {
  std::string simulation, daemon;
  for (const auto& e : answer.effects) {
    const std::string line = "  - " + io::format_effect(e) + "\n";
    simulation += line;
    if (io::can_be_compensated(e)) daemon += line;
  }
  std::string out;
  if (!simulation.empty()) out += "# into the simulation\neffects:\n" + simulation;
  if (const std::string numbers = numbers_to_paste(answer); !simulation.empty() && !numbers.empty())
    out += "# they belong to these numbers: the sensor reads matrix^-1 (truth + effects) + bias\n" + numbers;
  if (!daemon.empty()) out += "# into the daemon's configuration\ncompensate:\n" + daemon;
  return out;
}

void add(std::vector<std::string>& notices, const std::vector<std::string>& more) {
  notices.insert(notices.end(), more.begin(), more.end());
}

diag::Answer with_progress(const std::string& what, const io::Recording& recording,
                           const sim::SimulationConfig& simulation, const std::vector<std::string>& without,
                           std::size_t twins) {
  Progress progress(what);
  return diag::diagnose(recording, simulation, without, twins, [&progress](double share) { progress.at(share); });
}

/// Puts the shares that the findings remove on another recording into the answer. What makes a sensor worse there is
/// told, and does not go into the improved simulation.
void validate_on(const std::string& file, const io::Recording& other, const sim::SimulationConfig& simulation,
                 diag::Answer& answer) {
  answer.diagnosis.validation = diag::validate(file, other, simulation, diag::improved_by(answer, simulation));
  for (const diag::Validation& v : answer.diagnosis.validation) {
    if (!(v.ci95[1] < 0.0)) continue;
    std::erase_if(answer.effects, [&](const sim::EffectConfig& e) { return diag::acts_on(e.id, v.sensor); });
    answer.diagnosis.notices.push_back(fmt::format(
        "{}: what was found makes it worse on {}; it is not written into the improved simulation", v.sensor, file));
  }
}

/// Writes the answer wherever it is asked for. `improve` writes the improved simulation or log.
int give_answer(const Options& o, bool quiet, diag::Answer answer, const std::function<Result<void>()>& improve) {
  if (!o.code.empty()) add(answer.diagnosis.notices, without_code(answer));
  const std::string blocks = blocks_to_paste(answer), json = o.json.file();
  if (!quiet) std::fputs(diag::to_text(answer.diagnosis).c_str(), stdout);
  if (!quiet && !blocks.empty()) std::printf("\nNEXT     put the physics where it is missing:\n%s", blocks.c_str());
  const std::vector<diag::CodeBlock> code = laws_as_code(answer);
  const diag::ReportContext context{o.recordings.front(), o.simulation + o.simulated, o.validate, blocks, code};
  if (!o.improved.empty())
    if (const auto done = improve(); !done) return report(done.error());
  if (!o.report.empty())
    if (const auto done = io::write_text_file(o.report, diag::report_html(answer.diagnosis, context)); !done)
      return report(done.error());
  if (!json.empty())
    if (const auto done = io::write_text_file(json, diag::to_json(answer.diagnosis)); !done)
      return report(done.error());
  if (!o.code.empty())
    if (const auto done = write_code(code, o.code); !done) return report(done.error());
  const bool mismatch = !answer.diagnosis.findings.empty() || !answer.diagnosis.surplus.empty() ||
                        answer.diagnosis.verdict == diag::Verdict::kWrongNumbers;
  return o.fail_on_mismatch && mismatch ? static_cast<int>(ErrorKind::kThreshold) : 0;
}

int diagnose_simulated_log(const Options& o, bool quiet, const io::Recording& recording) {
  const auto log = read_simulated_log(o.simulated, o.map);
  if (!log) return report(log.error());
  Progress progress("diagnosing");
  auto found = diag::diagnose_log(*log, recording, o.without, [&progress](double share) { progress.at(share); });
  if (!found) return report({found.error().kind, o.simulated + ": " + found.error().message});
  auto& notices = found->answer.diagnosis.notices;
  add(notices, io::describe(recording.issues));
  for (const auto& line : io::describe(log->issues)) notices.push_back(o.simulated + ": " + line);
  if (!o.improved.empty()) add(notices, found->not_improved);
  return give_answer(o, quiet, found->answer, [&] { return io::write_recording(found->improved, o.improved); });
}

int diagnose_simulation(const Options& o, bool quiet, const io::Recording& recording) {
  const auto simulation = io::read_simulation(o.simulation);
  if (!simulation) return report(simulation.error());
  const auto other = o.validate.empty() ? io::Recording{} : io::read_recording(o.validate, io::OnMalformedRow::kCount);
  if (!other) return report(other.error());
  diag::Answer answer = with_progress("diagnosing", recording, *simulation, o.without, o.twins);
  add(answer.diagnosis.notices, io::describe(recording.issues));
  if (!o.validate.empty()) validate_on(o.validate, *other, *simulation, answer);
  const sim::SimulationConfig improved = diag::improved_by(answer, *simulation);
  return give_answer(o, quiet, answer, [&] { return io::write_simulation(improved, o.improved); });
}

int run_diagnose(const Options& o) {
  if (o.simulation.empty() && o.simulated.empty())
    return report({ErrorKind::kUsage,
                   "diagnose: --simulation is required: the baseline (YAML); or --simulated LOG.csv of any simulator"});
  const std::string json = o.json.file();
  const auto quiet = is_standard_output({json, o.report, o.improved});
  if (!quiet) return report(quiet.error());
  for (const auto& path : {json, o.report, o.improved})
    if (const auto writable = io::expect_writable(path); !writable) return report(writable.error());
  diag::keep_freed_memory();
  if (o.recordings.size() > 1) {
    for (const auto& [given, option] : {std::pair{!o.simulated.empty(), "--simulated"},
                                        {!o.report.empty(), "--report"},
                                        {!o.validate.empty(), "--validate"},
                                        {!o.code.empty(), "--code"},
                                        {o.twins > 0, "--twins"}})
      if (given)
        return report({ErrorKind::kUsage, fmt::format("diagnose: {} goes with one --recording; several are judged by "
                                                      "each other already",
                                                      option)});
    return diagnose_campaign({o.recordings, o.without, o.simulation, json, o.improved, *quiet, o.fail_on_mismatch});
  }
  const auto recording = io::read_recording(o.recordings.front(), io::OnMalformedRow::kCount);
  if (!recording) return report(recording.error());
  warn_if_implausible(*recording, o.recordings.front());
  return o.simulated.empty() ? diagnose_simulation(o, *quiet, *recording)
                             : diagnose_simulated_log(o, *quiet, *recording);
}

}  // namespace

void add_diagnose(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("diagnose", "Name the physics that a simulation left out of a recording");
  static Options o;
  auto* simulation = add_file(*command, "--simulation", o.simulation, "the baseline (YAML)");
  auto* log = add_file(*command, "--simulated", o.simulated, "or: what any simulator says of the same motion (CSV)");
  log->excludes(simulation);
  add_file(*command, "--map", o.map, "which columns of the simulated log are what (YAML; docs/import.md)")->needs(log);
  command
      ->add_option("--recording", o.recordings,
                   "the recording to explain (CSV); several, of one sensor on other days and in other motions, are "
                   "explained together")
      ->type_name(kFileType)
      ->required();
  o.json.add(*command, "write the answer");
  add_file(*command, "--report", o.report, "write the report (HTML, one file)");
  add_file(*command, "--improved", o.improved,
           "write the simulation (YAML) or the simulated log (CSV) with the found physics in it");
  command->add_option("--code", o.code, "write what was found as functions in Python, C++ and MATLAB into this folder")
      ->type_name("DIR");
  add_file(*command, "--validate", o.validate, "judge the improved simulation on another recording (CSV)")
      ->excludes(log);
  command
      ->add_option("--twins", o.twins,
                   "repeat the search on so many resimulations without what was found; state only what none of them "
                   "scores as high as")
      ->check(CLI::Range(1, 1000));
  command
      ->add_option("--without-law", o.without,
                   "take this law (an ID of `stillpoint effects`) out of the library, to see what is said when it is "
                   "not known; may be repeated")
      ->check([](const std::string& id) {
        return sim::find_effect(id) != nullptr ? std::string() : id + ": no such effect; see stillpoint effects";
      });
  command->add_flag("--fail-on-mismatch", o.fail_on_mismatch, "exit with 1 when something is found");
  command->callback([&run] { run = [] { return run_diagnose(o); }; });
}

}  // namespace stillpoint::app
