#include "apps/stillpoint/laws_as_code.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "diagnosis/finding_effect.h"
#include "io/text_file.h"
#include "laws/emit.h"
#include "simulation/effect_as_law.h"
#include "simulation/effect_catalogue.h"
#include "simulation/law_effect.h"

namespace stillpoint::app {
namespace {

std::vector<sim::EffectConfig> laws_of(const sim::EffectConfig& e) {
  return sim::is_law(e) || sim::is_table(e) ? std::vector{e} : sim::as_laws(e);
}

/// The numbers that belong to the law: it acts on the truth, before them.
std::vector<std::string> numbers_beside(const sim::TriadConfig& triad) {
  const Mat3 M = triad.matrix.inverse();
  return {"Found beside these numbers of the sensor: it reads M (truth + this) + b,",
          fmt::format("  M = [[{:.6g}, {:.6g}, {:.6g}], [{:.6g}, {:.6g}, {:.6g}], [{:.6g}, {:.6g}, {:.6g}]]", M(0, 0),
                      M(0, 1), M(0, 2), M(1, 0), M(1, 1), M(1, 2), M(2, 0), M(2, 1), M(2, 2)),
          fmt::format("  b = [{:.6g}, {:.6g}, {:.6g}]", triad.bias.x(), triad.bias.y(), triad.bias.z())};
}

laws::Coupled with_numbers(const sim::EffectConfig& law, const diag::Answer& answer) {
  laws::Coupled out = sim::coupled(law);
  if (const auto& numbers = answer.numbers[static_cast<std::size_t>(law.sensors.front())])
    out.beside = numbers_beside(*numbers);
  return out;
}

std::string why_no_code(const diag::Answer& answer, const diag::Finding& f) {
  const auto entry = std::find_if(answer.effects.begin(), answer.effects.end(),
                                  [&f](const sim::EffectConfig& e) { return diag::is_entry_of(e, f); });
  if (entry == answer.effects.end()) return "no law of it is known";
  return laws_of(*entry).empty() ? "the grammar of laws has no words for " + sim::find_effect(entry->id)->equation : "";
}

}  // namespace

std::vector<diag::CodeBlock> laws_as_code(const diag::Answer& answer) {
  std::vector<diag::CodeBlock> out;
  int count = 0;
  for (const sim::EffectConfig& e : answer.effects)
    for (const sim::EffectConfig& law : laws_of(e)) {
      const laws::Coupled coupled = with_numbers(law, answer);
      const std::string name = fmt::format("law_{}", ++count);
      for (const auto language : {laws::Language::kPython, laws::Language::kCpp, laws::Language::kMatlab})
        out.push_back({fmt::format("{}.{}", name, laws::suffix(language)), laws::emit(coupled, name, language)});
    }
  return out;
}

std::vector<std::string> without_code(const diag::Answer& answer) {
  std::vector<std::string> out;
  for (const diag::Finding& f : answer.diagnosis.findings)
    if (const std::string why = why_no_code(answer, f); !why.empty())
      out.push_back(fmt::format("no code for {}: {}", f.effect, why));
  return out;
}

Result<void> write_code(const std::vector<diag::CodeBlock>& code, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(ErrorKind::kCannotCreate, fmt::format("{}: cannot be made: {}", folder, error.message()));
  for (const diag::CodeBlock& c : code)
    if (auto done = io::write_text_file(folder + "/" + c.title, c.text); !done) return done;
  return {};
}

}  // namespace stillpoint::app
