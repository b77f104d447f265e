#include "calib_online/offline/field_again.h"

namespace stillpoint::calib {
namespace {

constexpr int kPasses = 3;  // the misfit of the third is that of the second to a few percent

}  // namespace

MagLearner learn_field(const MagLearner& at_first, std::span<const FieldTurn> turns, double gyr_matrix_sd,
                       double gyr_bias_sd_radps) {
  MagLearner learnt = at_first;
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto misfit_uT2 = pass > 0 ? learnt.misfit_uT2(turns, gyr_matrix_sd, gyr_bias_sd_radps) : std::nullopt;
    learnt = at_first;
    if (misfit_uT2) learnt.expect_misfit(*misfit_uT2);
    for (const FieldTurn& t : turns) learnt.absorb(t, gyr_matrix_sd, gyr_bias_sd_radps);
  }
  return learnt;
}

}  // namespace stillpoint::calib
