/// The report of a diagnosis as one HTML file that needs no network: verdict first, then what was found with its
/// figures, the ranking with the abstention line, the heat map and what to do next.
#pragma once
#include <string>
#include <vector>

#include "diagnosis/result.h"

namespace stillpoint::diag {

/// A function to paste into another simulator, by the name of its file.
struct CodeBlock {
  std::string title, text;
};

/// What the report says about its input.
struct ReportContext {
  std::string recording, simulation;  ///< file names
  std::string validation;             ///< second recording; empty: none
  std::string blocks_to_paste;        ///< YAML for the simulator and the daemon; empty: none
  std::vector<CodeBlock> code{};      ///< the discovered laws in each language
};

[[nodiscard]] std::string report_html(const Diagnosis& diagnosis, const ReportContext& context);

}  // namespace stillpoint::diag
