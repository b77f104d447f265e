#include "apps/stillpoint/laws_as_code.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "io/text_file.h"
#include "laws/emit.h"
#include "simulation/law_effect.h"

namespace stillpoint::app {

std::vector<diag::CodeBlock> laws_as_code(const std::vector<sim::EffectConfig>& effects) {
  std::vector<diag::CodeBlock> out;
  int count = 0;
  for (const sim::EffectConfig& e : effects) {
    if (!sim::is_law(e)) continue;
    const std::string name = fmt::format("law_{}", ++count);
    for (const auto language : {laws::Language::kPython, laws::Language::kCpp, laws::Language::kMatlab})
      out.push_back({fmt::format("{}.{}", name, laws::suffix(language)), laws::emit(sim::coupled(e), name, language)});
  }
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
