/// What `stillpoint page` serves as data; docs/page.md lists the fields.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "apps/stillpoint/page_model.h"
#include "apps/stillpoint/watch_model.h"
#include "io/dds_params.h"

namespace stillpoint::app {

/// Schema stillpoint.page/1: how the daemon is now. `publishers`: how many are matched.
[[nodiscard]] nlohmann::json page_json(const WatchState& state, const PageModel& model, const io::DdsParams& dds,
                                       int publishers, double t_s);
/// Schema stillpoint.page.history/1: the curves so far, null where no attitude was fresh.
[[nodiscard]] nlohmann::json history_json(const PageModel& model);

}  // namespace stillpoint::app
