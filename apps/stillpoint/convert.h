/// `stillpoint convert`.
#pragma once
#include "apps/stillpoint/commands.h"

namespace stillpoint::app {

void add_convert(CLI::App& app, Run& run);

}  // namespace stillpoint::app
