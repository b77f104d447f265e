/// A discovered law as an engineer looks at it: the residual against each quantity that the law is made of, and against
/// whatever else was recorded.
#pragma once
#include <string>
#include <vector>

#include "diagnosis/reference/columns.h"
#include "diagnosis/result.h"

namespace stillpoint::diag {

/// Of one axis of the residual, before and after the law `effect` ("unknown:TEXT"); empty where that is no law. At most
/// 1000 points and six quantities.
[[nodiscard]] std::vector<AgainstQuantity> against_each(const Signals& s, const std::string& effect, int axis,
                                                        const Series& before, const Series& after,
                                                        const Layout& layout);

}  // namespace stillpoint::diag
