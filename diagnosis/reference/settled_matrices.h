/// The matrices of the simulation, set right where a law is seen through them.
#pragma once
#include "diagnosis/reference/engine.h"

namespace stillpoint::diag {

/// A sensor whose matrix is wrong reads A (true + what a law adds), not A true + what it adds: of a law that acts on
/// the whole vector (a delay, a lever, a field) the difference is A - 1 times the law, and a product outside the
/// catalogue fits it. Corrects each reading by the matrix that fits beside what was found, where that difference would
/// be seen. Changes `triad`, the readings, residuals and what is made of them; `given` stays. True where it did: the
/// search then has to start anew.
[[nodiscard]] bool settle_matrices(Signals& s, const EngineResult& found);

/// The same where laws outside the catalogue brought a wrong matrix to light, which no search begins anew for: what
/// they are fitted to follows the readings, so that their numbers are those before the matrix, too. Not where the
/// sensor's own reading stands for the truth in the laws.
void settle_beside_laws(Signals& s, EngineResult& found);

}  // namespace stillpoint::diag
