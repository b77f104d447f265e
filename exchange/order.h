/// Readings in the order of their times, before anything is told from them.
#pragma once
#include <string>
#include <vector>

#include "exchange/stream.h"

namespace stillpoint::exchange {

/// Leaves times that advance. A 32-bit counter of ms, us or ns that wraps goes on; a lone stamp far ahead of its
/// neighbours is dropped, then what does not advance. What was done is added to `why`.
void put_in_order(Stream& stream, std::vector<std::string>& why);

}  // namespace stillpoint::exchange
