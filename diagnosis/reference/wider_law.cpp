#include "diagnosis/reference/wider_law.h"

#include <algorithm>

#include "diagnosis/reference/evidence.h"
#include "diagnosis/reference/refine.h"

namespace stillpoint::diag {
namespace {

/// A law that vanishes beside the further terms is not the one to be stated with bounds: either could be the cause.
constexpr double kShown_sd = 3.0;

bool begins_with(const Columns& wider, const Columns& narrow) {
  return wider.size() > narrow.size() &&
         std::equal(narrow.begin(), narrow.end(), wider.begin(),
                    [](const Column& a, const Column& b) { return a.axis == b.axis && a.x == b.x; });
}

}  // namespace

std::optional<WiderLaw> wider_law(const SensorSearch& search, std::size_t index) {
  const Found& narrow = search.found[index];
  if (narrow.window.local || !narrow.shape_name.empty()) return std::nullopt;
  for (const Law& law : search.laws) {
    if (!law.shape_name.empty() || law.coefficients.size() <= narrow.columns.size()) continue;
    Columns columns = law.columns(law.shapes.front());
    if (!begins_with(columns, narrow.columns)) continue;
    SensorSearch with = search;
    with.found[index] = found_from(law, {}, std::move(columns));
    const Found& found = with.found[index];
    const Finished finished = finish(with);
    const Eigen::Index first = first_column(with, index);
    const auto kept = static_cast<Eigen::Index>(narrow.columns.size());
    const auto share = finished.values.segment(first, kept).cwiseAbs().cwiseQuotient(finished.sd.segment(first, kept));
    if (!(share.maxCoeff() > kShown_sd)) return std::nullopt;
    WiderLaw out{law.id, {}};
    for (std::size_t j = narrow.columns.size(); j < found.names.size(); ++j)
      out.further.push_back(number_of(finished, first + static_cast<Eigen::Index>(j), found.names[j], found.units[j]));
    return out;
  }
  return std::nullopt;
}

}  // namespace stillpoint::diag
