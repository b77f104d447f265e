/// The effects as functions to paste into another simulator.
#pragma once
#include <string>
#include <vector>

#include "core/result.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/report/report.h"

namespace stillpoint::app {

/// law_1.py, law_1.h, law_1.m, law_2.py, ...: every law in every language, those of the catalogue too where the grammar
/// has words for them.
[[nodiscard]] std::vector<diag::CodeBlock> laws_as_code(const diag::Answer& answer);

/// The findings that have no code, a line each, with the reason.
[[nodiscard]] std::vector<std::string> without_code(const diag::Answer& answer);

/// Each as a file of the folder, which is made where it is absent. Fails with 73.
[[nodiscard]] Result<void> write_code(const std::vector<diag::CodeBlock>& code, const std::string& folder);

}  // namespace stillpoint::app
