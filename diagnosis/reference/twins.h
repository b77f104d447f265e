/// Null twins: the search repeated on residuals drawn from the recording's own noise, with the found physics not in
/// them. What the whole search - names, windows, time constants, the choice among them - makes of nothing is the only
/// gate that needs no assumption about how its parts depend on one another.
#pragma once
#include <cstdint>

#include "diagnosis/reference/engine.h"

namespace stillpoint::diag {

/// Best net gain, nats, that the search reaches on each of `count` twins of one sensor; 0 where it states nothing. A
/// twin has the noise (its colour, its unevenness in time, its random walk) that the finished model leaves, on the same
/// motion and drivers; bias and matrix are fitted anew. The same seed gives the same twins.
[[nodiscard]] std::vector<double> null_twins(const Signals& s, const SensorSearch& search, std::size_t count,
                                             std::uint64_t seed);

/// Drops every effect that a twin of its sensor scores as high as. Says for each sensor with findings what its twins
/// scored.
[[nodiscard]] std::vector<std::string> gate_by_twins(const Signals& s, EngineResult& result, std::size_t count);

}  // namespace stillpoint::diag
