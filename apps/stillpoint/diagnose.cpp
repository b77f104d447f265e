/// `stillpoint diagnose`: locates, names and models the physics that a simulation left out of a recording.
#include <fmt/format.h>

#include <cstdio>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/progress.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/report/report.h"
#include "diagnosis/summary.h"
#include "io/config.h"
#include "io/recording.h"
#include "io/simulation_yaml.h"
#include "io/text_file.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::app {
namespace {

struct Options {
  std::string simulation, recording, report, improved, validate;
  JsonOption json;
  std::vector<std::string> without;
  std::size_t twins = 0;
  bool fail_on_mismatch = false;
};

/// The found physics as blocks to paste: for the simulation, and for the daemon what it can take out in real time.
std::string blocks_to_paste(const std::vector<sim::EffectConfig>& effects) {
  std::string simulation, daemon;
  for (const auto& e : effects) {
    const std::string line = "  - " + io::format_effect(e) + "\n";
    simulation += line;
    if (io::can_be_compensated(e)) daemon += line;
  }
  std::string out;
  if (!simulation.empty()) out += "# into the simulation\neffects:\n" + simulation;
  if (!daemon.empty()) out += "# into the daemon's configuration\ncompensate:\n" + daemon;
  return out;
}

diag::Answer with_progress(const std::string& what, const io::Recording& recording,
                           const sim::SimulationConfig& simulation, const std::vector<std::string>& without,
                           std::size_t twins) {
  Progress progress(what);
  return diag::diagnose(recording, simulation, without, twins, [&progress](double share) { progress.at(share); });
}

/// How the baseline and the improved simulation stand to a recording that the diagnosis has not seen.
std::string validation(const std::string& name, const io::Recording& other, const sim::SimulationConfig& baseline,
                       const sim::SimulationConfig& improved) {
  const diag::Answer before = with_progress("validating, before", other, baseline, {}, 0),
                     after = with_progress("validating, after", other, improved, {}, 0);
  return fmt::format("\nVALIDATE {}: before: {}  after: {}\n", name, before.diagnosis.summary, after.diagnosis.summary);
}

int run_diagnose(const Options& o) {
  const std::string json = o.json.file();
  const auto quiet = is_standard_output({json, o.report, o.improved});
  if (!quiet) return report(quiet.error());
  for (const auto& path : {json, o.report, o.improved})
    if (const auto writable = io::expect_writable(path); !writable) return report(writable.error());
  const auto simulation = io::read_simulation(o.simulation);
  if (!simulation) return report(simulation.error());
  const auto recording = io::read_recording(o.recording, io::OnMalformedRow::kCount);
  if (!recording) return report(recording.error());
  const auto other = o.validate.empty() ? io::Recording{} : io::read_recording(o.validate, io::OnMalformedRow::kCount);
  if (!other) return report(other.error());

  diag::Answer answer = with_progress("diagnosing", *recording, *simulation, o.without, o.twins);
  for (const auto& line : io::describe(recording->issues)) answer.diagnosis.notices.push_back(line);
  sim::SimulationConfig improved = *simulation;
  improved.effects.insert(improved.effects.end(), answer.effects.begin(), answer.effects.end());
  const std::string blocks = blocks_to_paste(answer.effects);
  if (!*quiet) std::fputs(diag::to_text(answer.diagnosis).c_str(), stdout);
  if (!*quiet && !blocks.empty()) std::printf("\nNEXT     put the physics where it is missing:\n%s", blocks.c_str());

  const diag::ReportContext context{o.recording, o.simulation, o.validate, blocks};
  if (!o.improved.empty())
    if (const auto done = io::write_simulation(improved, o.improved); !done) return report(done.error());
  if (!o.report.empty())
    if (const auto done = io::write_text_file(o.report, diag::report_html(answer.diagnosis, context)); !done)
      return report(done.error());
  if (!json.empty())
    if (const auto done = io::write_text_file(json, diag::to_json(answer.diagnosis)); !done)
      return report(done.error());
  if (!o.validate.empty())
    std::fputs(validation(o.validate, *other, *simulation, improved).c_str(), *quiet ? stderr : stdout);
  return o.fail_on_mismatch && !answer.diagnosis.findings.empty() ? static_cast<int>(ErrorKind::kThreshold) : 0;
}

}  // namespace

void add_diagnose(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("diagnose", "Name the physics that a simulation left out of a recording");
  static Options o;
  add_file(*command, "--simulation", o.simulation, "the baseline (YAML)")->required();
  add_file(*command, "--recording", o.recording, "the recording to explain (CSV)")->required();
  o.json.add(*command, "write the answer");
  add_file(*command, "--report", o.report, "write the report (HTML, one file)");
  add_file(*command, "--improved", o.improved, "write the simulation with the found physics in it (YAML)");
  add_file(*command, "--validate", o.validate, "judge the improved simulation on another recording (CSV)");
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
