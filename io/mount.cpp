#include "io/mount.h"

#include <fmt/format.h>

#include <optional>
#include <sstream>
#include <vector>

#include "core/directions.h"

namespace stillpoint::io {
namespace {

constexpr double kRounding = 1e-3;

std::optional<Mat3> signed_axes(const std::string& text) {
  std::istringstream words(text);
  Mat3 R = Mat3::Zero();
  std::string word;
  for (Eigen::Index row = 0; row < 3; ++row) {
    if (!(words >> word)) return std::nullopt;
    if (word.size() == 1) word.insert(word.begin(), '+');
    if (word.size() != 2 || (word[0] != '+' && word[0] != '-') || word[1] < 'x' || word[1] > 'z') return std::nullopt;
    R(row, word[1] - 'x') = word[0] == '+' ? 1.0 : -1.0;
  }
  return words >> word ? std::nullopt : std::optional(R);
}

}  // namespace

std::string mount_names(const Mat3& axes) {
  std::string text;
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      if (axes(row, axis) != 0.0)
        text += fmt::format("{}{}{}", row > 0 ? " " : "", axes(row, axis) > 0.0 ? '+' : '-', "xyz"[axis]);
  return text;
}

std::variant<Mount, std::string> mount_of_names(const std::string& text) {
  const auto R = signed_axes(text);
  if (!R) return "must be three signed axes such as \"+x -z +y\", three rows or a quaternion [w, x, y, z]";
  if (R->determinant() == 0.0) return "is not a rotation: it names one axis twice";
  if (R->determinant() > 0.0) return Mount{*R};
  std::string near;
  for (Eigen::Index row = 0; row < 3; ++row) {
    Mat3 turned = *R;
    turned.row(row) *= -1.0;  // the least that can be changed: one sign
    near += fmt::format("{}\"{}\"", row > 0 ? ", " : "", mount_names(turned));
  }
  return "mirrors (left-handed); with one sign changed it would be a rotation: " + near;
}

std::variant<Mount, std::string> mount_of_matrix(const Mat3& M) {
  const Mat3 nearest = nearest_orthogonal(M);
  if ((M - nearest).norm() <= kRounding) return Mount{nearest};
  return fmt::format(
      "{}; the nearest rotation is [[{:.4g}, {:.4g}, {:.4g}], [{:.4g}, {:.4g}, {:.4g}], [{:.4g}, {:.4g}, {:.4g}]]",
      M.determinant() < 0.0 ? "mirrors (left-handed)" : "is not a rotation", nearest(0, 0), nearest(0, 1),
      nearest(0, 2), nearest(1, 0), nearest(1, 1), nearest(1, 2), nearest(2, 0), nearest(2, 1), nearest(2, 2));
}

}  // namespace stillpoint::io
