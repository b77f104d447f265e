#include "calib_online/offline/field_again.h"

namespace stillpoint::calib {
namespace {

constexpr int kPasses = 2;  // the misfit of a third is the same to a few percent

}  // namespace

MagLearner learn_field(const MagLearner& at_first, std::span<const FieldTurn> turns, double gyr_matrix_sd,
                       double gyr_bias_sd_radps) {
  std::optional<double> misfit_uT2;
  const auto taught = [&](MagLearner learner) {
    if (misfit_uT2) learner.expect_misfit(*misfit_uT2);
    for (const FieldTurn& t : turns) learner.absorb(t, gyr_matrix_sd, gyr_bias_sd_radps);
    return learner;
  };
  MagLearner closest = at_first;  // what the closest fit leaves is the misfit; how sure it is is another matter
  closest.count_each_turn();
  for (int pass = 0; pass < kPasses; ++pass)
    misfit_uT2 = taught(closest).misfit_uT2(turns, gyr_matrix_sd, gyr_bias_sd_radps);
  return taught(at_first);
}

}  // namespace stillpoint::calib
