#include "calib_online/offline/axis_maps.h"

#include <Eigen/LU>
#include <array>

namespace stillpoint::calib {
namespace {

std::array<Mat3, 24> make_axis_maps() {
  std::array<Mat3, 24> maps;
  std::size_t made = 0;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int signs = 0; signs < 4 && x != y; ++signs) {
        Mat3 map = Mat3::Zero();
        map(0, x) = (signs & 1) != 0 ? -1.0 : 1.0;
        map(1, y) = (signs & 2) != 0 ? -1.0 : 1.0;
        map.row(2) = map.row(0).cross(map.row(1));
        maps[made++] = map;
      }
  return maps;
}

}  // namespace

std::span<const Mat3> axis_maps() noexcept {
  static const std::array<Mat3, 24> maps = make_axis_maps();
  return maps;
}

Mat3 nearest_axis_map(const Mat3& orthogonal) noexcept {
  const double sign = orthogonal.determinant() < 0.0 ? -1.0 : 1.0;
  Mat3 nearest = Mat3::Identity();
  double most = -4.0;
  for (const Mat3& map : axis_maps())
    if (const double alike = sign * map.cwiseProduct(orthogonal).sum(); alike > most) {
      most = alike;
      nearest = sign * map;
    }
  return nearest;
}

Unmirrored unmirrored(const Mat3& mirroring) noexcept {
  Unmirrored best;
  const Mat3 map = nearest_axis_map(mirroring);
  double most = -4.0;
  for (int axis = 0; axis < 3; ++axis) {
    Mat3 turned = map;
    turned.col(axis) *= -1.0;
    if (turned.trace() <= most) continue;
    most = turned.trace();
    best = {axis, turned, mirroring};
    best.turn.col(axis) *= -1.0;
  }
  return best;
}

}  // namespace stillpoint::calib
