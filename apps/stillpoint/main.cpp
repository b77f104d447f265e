/// `stillpoint`: the command line tool. `stillpoint --help` lists the commands.
#include <fmt/format.h>

#include <filesystem>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "io/quote.h"
#include "io/yaml.h"

namespace {

/// Whether there is a command of this name; if not, it is said with the nearest that there is.
bool is_command(const CLI::App& cli, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::App* command : cli.get_subcommands(nullptr)) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), word) != names.end()) return true;
  stillpoint::app::tell(fmt::format("stillpoint: no command '{}'{}", word, stillpoint::io::suggestion(word, names)));
  return false;
}

/// Whether the command knows all the options that are given it; the first it does not is said with the nearest it does.
bool are_options(const CLI::App& command, int argc, char** argv) {
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (int i = 2; i < argc; ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string(argv[i]).find('='));
    if (word.size() < 3 || word.rfind("--", 0) != 0) continue;
    if (std::find(known.begin(), known.end(), word) != known.end()) continue;
    stillpoint::app::tell(fmt::format("stillpoint {}: no option {}{}", command.get_name(), stillpoint::io::quote(word),
                                      stillpoint::io::suggestion(word, known)));
    return false;
  }
  return true;
}

/// Fails (64) when two options name one file: what is to be read, or was just written, would be overwritten.
stillpoint::Result<void> expect_files_apart(const CLI::App& command) {
  namespace fs = std::filesystem;
  std::vector<std::pair<std::string, fs::path>> named;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_type_name() != stillpoint::app::kFileType) continue;
    for (const std::string& value : option->results()) {
      std::error_code unknown;
      const bool no_file = fs::exists(value, unknown) && !fs::is_regular_file(value, unknown);  // such as /dev/null
      if (value.empty() || value == "-" || no_file) continue;
      const fs::path file = fs::weakly_canonical(fs::absolute(value, unknown), unknown);
      for (const auto& [other, taken] : named)
        if ((!file.empty() && file == taken) || fs::equivalent(file, taken, unknown))
          return stillpoint::fail(
              stillpoint::ErrorKind::kUsage,
              fmt::format("{} and {} name the same file, {}; give each its own", other, option->get_name(), value));
      named.emplace_back(option->get_name(), file);
    }
  }
  return {};
}

int parse_and_run(CLI::App& cli, const stillpoint::app::Run& run, int argc, char** argv) {
  using stillpoint::ErrorKind;
  try {
    cli.parse(argc, argv);
    for (const CLI::App* command : cli.get_subcommands())
      if (const auto apart = expect_files_apart(*command); !apart) return stillpoint::app::report(apart.error());
    return run();
  } catch (const CLI::ParseError& e) {
    return cli.exit(e) == 0 ? 0 : static_cast<int>(ErrorKind::kUsage);
  } catch (const std::system_error& e) {  // of fmt::print where standard output is full, or of a folder's listing
    return stillpoint::app::report({ErrorKind::kCannotCreate, e.what()});
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace stillpoint;
  CLI::App cli{"Self-calibrating attitude, and the physics a simulation left out.", "stillpoint"};
  cli.set_version_flag("--version", "stillpoint " STILLPOINT_VERSION);
  cli.require_subcommand(1);
  app::Run run;
  app::add_calibrate(cli, run);
  app::add_check(cli, run);
  app::add_convert(cli, run);
  app::add_demo(cli, run);
  app::add_devices(cli, run);
  app::add_diagnose(cli, run);
  app::add_effects(cli, run);
  app::add_estimate(cli, run);
  app::add_import(cli, run);
  app::add_merge(cli, run);
  app::add_noise(cli, run);
  app::add_page(cli, run);
  app::add_prove(cli, run);
  app::add_record(cli, run);
  app::add_simulate(cli, run);
  app::add_status(cli, run);
  app::add_watch(cli, run);
  if (argc < 2) {
    app::tell(cli.help());
    return static_cast<int>(ErrorKind::kUsage);
  }
  if (argv[1][0] != '-' && !is_command(cli, argv[1])) return static_cast<int>(ErrorKind::kUsage);
  if (argv[1][0] != '-' && !are_options(*cli.get_subcommand(argv[1]), argc, argv))
    return static_cast<int>(ErrorKind::kUsage);
  const int code = parse_and_run(cli, run, argc, argv);
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  const int lost = app::report({ErrorKind::kCannotCreate, "standard output: cannot be written; is the disk full?"});
  return code != 0 ? code : lost;
}
