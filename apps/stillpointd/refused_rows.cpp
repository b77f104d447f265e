#include "apps/stillpointd/refused_rows.h"

#include <fmt/format.h>

namespace stillpoint::app {
namespace {

/// A clock that is set back costs seven rows: no more than 7 % of these.
constexpr std::uint64_t kLeastRows = 100;
constexpr double kBegins = 0.1, kEnds = 0.05;

}  // namespace

std::string RefusedRows::news(const pipeline::GuardCounts& counts) {
  if (counts.rows - rows_ < kLeastRows) return {};
  share_ = static_cast<double>(counts.out_of_time - refused_) / static_cast<double>(counts.rows - rows_);
  rows_ = counts.rows;
  refused_ = counts.out_of_time;
  const bool was_told = !trouble_.empty();
  if (share_ < (was_told ? kEnds : kBegins)) {
    trouble_.clear();
    return was_told ? "the rows' stamps advance again" : "";
  }
  trouble_ = fmt::format(
      "{:.0f} % of the rows are refused, as their stamps do not advance: coarser than the rows, repeated or running "
      "back; send finer ones, or rows without a time, and that of arrival serves",
      100.0 * share_);
  return was_told ? "" : trouble_;
}

}  // namespace stillpoint::app
