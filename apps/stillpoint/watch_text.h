/// What `stillpoint watch` and `stillpoint demo` show of a daemon: 24 lines of 80 columns.
#pragma once
#include <deque>
#include <string>

#include "apps/stillpoint/page_model.h"

namespace stillpoint::app {

/// For a person, in degrees; empty before the first attitude. `curve` is the attitude's way of late, for the trend.
[[nodiscard]] std::string text_view(const WatchState& state, const std::deque<CurvePoint>& curve = {},
                                    bool in_colour = false);

}  // namespace stillpoint::app
