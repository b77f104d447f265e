/// The first look: the likelihood gain of every law, in every window, from Gram matrices of half-second blocks. A scan
/// over hundreds of windows costs one pass over the samples and many small solves.
#pragma once
#include "diagnosis/reference/laws.h"

namespace stillpoint::diag {

/// Samples [begin, end) where an effect acts; whole recording when local is false.
struct Window {
  bool local = false;
  Eigen::Index begin = 0, end = 0;
  bool operator==(const Window&) const = default;
};

constexpr double kShortestWindow_s = 4.0;  ///< that is believed

/// Zero outside of the window.
[[nodiscard]] Columns in_window(Columns columns, const Window& window);

struct Candidate {
  std::size_t law = 0;
  double shape = 0.0;
  Window window;
  double gain_nats = 0.0;
  Eigen::Index coefficients = 0;
};

/// Where the scan stands: what is already explained, and the noise it whitens with.
class Scan {
 public:
  Scan(const Target& target, const Columns& explained, const NoiseModel& noise);
  /// The best whole-recording and the best local candidate of one law, over its shapes.
  [[nodiscard]] std::vector<Candidate> look(const Law& law, std::size_t index) const;

 private:
  /// Sums over the blocks up to each one, of the columns with themselves, with the base and with the residual.
  struct Sums {
    std::vector<Eigen::MatrixXd> self, base;
    std::vector<Eigen::VectorXd> residual;
  };
  [[nodiscard]] Sums sums_of(const Columns& columns) const;
  [[nodiscard]] double gain(const Sums& sums, Eigen::Index first, Eigen::Index last) const;
  void refine_edges(const Sums& sums, Eigen::Index& first, Eigen::Index& last, double& best) const;

  const Target& target_;
  const NoiseModel& noise_;
  /// What is explained, whitened and orthonormal, of each axis: its own columns (offset, matrix, walk), then the
  /// shared.
  std::array<Eigen::MatrixXd, 3> base_;
  Eigen::Index own_ = 0, shared_ = 0;
  std::array<Series, 3> residual_;        ///< whitened, the base taken out
  Eigen::Index block_ = 25, blocks_ = 0;  ///< half a second
};

}  // namespace stillpoint::diag
