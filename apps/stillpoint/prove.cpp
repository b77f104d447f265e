/// `stillpoint prove`: draws sealed cases, has them solved by a process that never sees the truth, opens and scores
/// them.
#include <fmt/format.h>

#include <atomic>
#include <filesystem>

#include "apps/stillpoint/at_once.h"
#include "apps/stillpoint/child_process.h"
#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/progress.h"
#include "apps/stillpoint/prove_invented.h"
#include "diagnosis/prove/prove.h"
#include "diagnosis/prove/sha256.h"
#include "io/simulation_yaml.h"
#include "io/text_file.h"
#include "report/document.h"

namespace stillpoint::app {
namespace {

namespace fs = std::filesystem;

struct ProveOptions {
  std::size_t cases = 60;
  std::string salt = "stillpoint", folder, report, only;
  bool quick = false, limits = false, real_parts = false;
};

/// One case as it lies before the solver: files and hash. The truth stays in this process until all answers are in.
struct Posed {
  std::string id, hash;
  diag::CaseTruth truth;
  std::string nonce;
  fs::path recording, simulation, answer;
  std::vector<std::string> without;  ///< laws that the referee takes out of the solver's library
};

/// The folder of the solver's files, which goes with the object.
struct Room {
  explicit Room(fs::path folder) : path(std::move(folder)) {}
  ~Room() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Room(const Room&) = delete;
  Room& operator=(const Room&) = delete;
  const fs::path path;
};

/// Runs `diagnose` of this very program as a process of its own, with its words going nowhere. A run that fails leaves
/// no answer, which is scored as one.
void solve(const Posed& posed) {
  std::vector<std::string> command{fs::read_symlink("/proc/self/exe").string(),
                                   "diagnose",
                                   "--simulation",
                                   posed.simulation.string(),
                                   "--recording",
                                   posed.recording.string(),
                                   "--json",
                                   posed.answer.string()};
  for (const auto& id : posed.without) command.insert(command.end(), {"--without-law", id});
  auto child = ChildProcess::start(command, "/dev/null");
  if (child) child->wait();
}

/// As many solvers beside one another as there are processors.
void solve_all(const std::vector<Posed>& posed) {
  std::atomic<std::size_t> done{0};
  Progress progress("solving");
  at_once(posed.size(), processors(), [&](std::size_t i) {
    solve(posed[i]);
    progress.at(static_cast<double>(++done) / static_cast<double>(posed.size()));
  });
}

Result<std::vector<Posed>> draw(const ProveOptions& o, const fs::path& room) {
  std::vector<Posed> all;
  const auto parts = o.real_parts ? diag::Parts::kReal : diag::Parts::kIdeal;
  for (std::size_t i = 0; i < o.cases; ++i) {
    diag::SealedCase c = o.limits         ? diag::draw_limit_case(o.salt, i, o.quick, parts)
                         : o.only.empty() ? diag::draw_case(o.salt, i, o.quick, parts)
                                          : diag::draw_case_of(o.only, o.salt, i, o.quick, parts);
    Posed p{.id = c.id,
            .hash = diag::seal(c.id, c.truth, c.nonce),
            .truth = std::move(c.truth),
            .nonce = std::move(c.nonce),
            .recording = room / (c.id + ".csv"),
            .simulation = room / (c.id + ".yaml"),
            .answer = room / (c.id + ".json"),
            .without = std::move(c.without)};
    c.baseline.motion.reset();  // the solver gets the baseline of the sensor, nothing of how the body was moved
    c.baseline.environment = {};
    c.baseline.reference = {};
    if (const auto done = io::write_recording(c.recording, p.recording.string()); !done)
      return tl::unexpected(done.error());
    if (const auto done = io::write_simulation(c.baseline, p.simulation.string()); !done)
      return tl::unexpected(done.error());
    std::printf("%s  %s\n", p.id.c_str(), p.hash.c_str());
    all.push_back(std::move(p));
  }
  return all;
}

Result<std::vector<Posed>> collect(const ProveOptions& o, const fs::path& room) {
  const fs::path cases = fs::path(o.folder) / "cases", truths = fs::path(o.folder) / "truth";
  if (!fs::is_directory(cases) || !fs::is_directory(truths))
    return fail(ErrorKind::kNoInput, o.folder + ": has no folders cases/ and truth/");
  std::vector<Posed> all;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(cases))
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const std::string id = file.stem().string();
    const fs::path truth_file = truths / (id + ".json");
    const auto text = io::read_text_file(truth_file.string(), "the truth of a case (.json)");
    if (!text) return tl::unexpected(text.error());
    const auto truth = diag::parse_truth(*text, truth_file.string());
    if (!truth) return tl::unexpected(truth.error());
    all.push_back({.id = id,
                   .hash = diag::sha256(fmt::format("{}\n{}", id, *text)),
                   .truth = *truth,
                   .nonce = "",
                   .recording = file,
                   .simulation = cases / (id + ".yaml"),
                   .answer = room / (id + ".json"),
                   .without = {}});
    std::printf("%s  %s\n", id.c_str(), all.back().hash.c_str());
  }
  if (all.empty()) return fail(ErrorKind::kNoInput, cases.string() + ": no recordings (*.csv)");
  return all;
}

Result<void> write_proof(const ProveOptions& o, const std::string& text, const std::vector<Posed>& posed) {
  std::string page =
      "<div class=\"verdict\"><div class=\"label\">Proof</div><h1>Proof on concealed data</h1><p class=\"small\">Each "
      "case was sealed by the hash below before it was solved by a process that had the recording and the baseline "
      "only. All cases count.</p></div><pre>" +
      report::escaped(text) + "</pre><h2>Seals</h2><p>SHA-256 of case, truth and nonce, a newline between.</p><pre>";
  for (const auto& p : posed)
    page += fmt::format("{}  {}  nonce {}  {}\n", report::escaped(p.id), p.hash, p.nonce.empty() ? "none" : p.nonce,
                        report::escaped(diag::to_json(p.truth).dump()));
  return io::write_text_file(o.report, report::document_html("Proof on concealed data", page + "</pre>", {}));
}

int prove(const ProveOptions& o) {
  if (o.only == kInvented && (!o.report.empty() || !o.folder.empty() || o.limits || o.real_parts))
    return report(
        {ErrorKind::kUsage, "--only invented takes --cases, --salt and --quick alone: it prints all it knows"});
  if (const auto writable = io::expect_writable(o.report); !writable) return report(writable.error());
  std::string room_name = (fs::temp_directory_path() / "stillpoint-prove-XXXXXX").string();
  if (mkdtemp(room_name.data()) == nullptr)
    return report({ErrorKind::kCannotCreate, room_name + ": cannot be created"});
  const Room room(room_name);
  std::printf("seals (SHA-256 of case, truth, nonce), printed before solving; salt \"%s\"\n", o.salt.c_str());
  if (o.only == kInvented) return prove_invented(o.salt, o.cases, o.quick, room.path);
  const auto posed = o.folder.empty() ? draw(o, room.path) : collect(o, room.path);
  if (!posed) return report(posed.error());
  std::fflush(stdout);
  solve_all(*posed);
  std::vector<diag::CaseScore> scores;
  bool sealed = true;
  for (const auto& p : *posed) {
    sealed = sealed && (p.nonce.empty() || diag::seal(p.id, p.truth, p.nonce) == p.hash);
    const std::string answer = io::read_text_file(p.answer.string(), "an answer (.json)").value_or("");
    scores.push_back(diag::score_case(p.id, p.truth, nlohmann::json::parse(answer, nullptr, false)));
  }
  const std::string text = o.limits ? diag::limit_tables(scores) : diag::tables(scores);
  std::printf("\n%s\n%s", sealed ? "opened: every truth matches its seal" : "a truth does not match its seal",
              text.c_str());
  if (!o.report.empty())
    if (const auto done = write_proof(o, text, *posed); !done) return report(done.error());
  return sealed ? 0 : static_cast<int>(ErrorKind::kThreshold);
}

}  // namespace

void add_prove(CLI::App& app, Run& run) {
  auto* command =
      app.add_subcommand("prove", "Prove the diagnosis on sealed cases: draw, seal, solve unseen, open, score");
  static ProveOptions o;
  command->add_option("--cases", o.cases, "how many cases to draw; 60 unless given")->check(CLI::Range(1, 100000));
  command->add_option("--salt", o.salt, "the same salt draws the same cases");
  std::vector<std::string> kinds = diag::kinds_of_cases();
  kinds.emplace_back(kInvented);
  command->add_option("--only", o.only, "draw cases of this kind alone")->check(CLI::IsMember(kinds));
  command->add_option("--folder", o.folder,
                      "take cases made elsewhere: FOLDER/cases/NNN.csv, NNN.yaml and FOLDER/truth/NNN.json");
  add_file(*command, "--report", o.report, "write the tables, seals and truths as a page (.html)");
  command->add_flag(
      "--limits", o.limits,
      "draw weak effects and measure from which size on they are found, against the test that knows the law");
  command->add_flag("--real-parts", o.real_parts,
                    "noise with flicker of which the simulation says nothing; 50, 100 and 200 Hz");
  command->add_flag("--quick", o.quick, "recordings of one minute instead of two");
  command->callback([&run] { run = [] { return prove(o); }; });
}

}  // namespace stillpoint::app
