/// The diagnosis as text for a person and as JSON for a program (docs/formats.md, stillpoint.diagnosis/1).
#pragma once
#include <string>

#include "diagnosis/result.h"

namespace stillpoint::diag {

[[nodiscard]] const char* verdict_word(Verdict verdict);
[[nodiscard]] std::string summarise(const Diagnosis& d);  ///< one sentence
[[nodiscard]] std::string to_text(const Diagnosis& d);
/// Lines that fit a terminal of 80 columns, what follows set in under the text of the first.
[[nodiscard]] std::string wrapped(const std::string& text);
[[nodiscard]] std::string to_json(const Diagnosis& d);

}  // namespace stillpoint::diag
