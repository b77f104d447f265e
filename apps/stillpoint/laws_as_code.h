/// Laws among the effects as functions to paste into another simulator.
#pragma once
#include <string>
#include <vector>

#include "core/result.h"
#include "diagnosis/report/report.h"
#include "simulation/config.h"

namespace stillpoint::app {

/// law_1.py, law_1.h, law_1.m, law_2.py, ...: every law in every language.
[[nodiscard]] std::vector<diag::CodeBlock> laws_as_code(const std::vector<sim::EffectConfig>& effects);

/// Each as a file of the folder, which is made where it is absent. Fails with 73.
[[nodiscard]] Result<void> write_code(const std::vector<diag::CodeBlock>& code, const std::string& folder);

}  // namespace stillpoint::app
