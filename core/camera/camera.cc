// SPDX-License-Identifier: Apache-2.0
#include "core/camera/camera.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/geometry/angle.h"

namespace waystone {
namespace {

constexpr int kMaxSide = 100'000;      // px
constexpr double kMaxParameter = 1e9;  // of either sign; beyond it pixels overflow
constexpr double kMinFocal_px = 1e-6;  // below it rays overflow

struct ModelRow {
  CameraModel model;
  std::string_view name;
  int parameters;
  int focal_lengths;
  std::string_view parameter_names;
};

constexpr std::array kModels{
    ModelRow{CameraModel::kSimplePinhole, "SIMPLE_PINHOLE", 3, 1, "f cx cy"},
    ModelRow{CameraModel::kPinhole, "PINHOLE", 4, 2, "fx fy cx cy"},
    ModelRow{CameraModel::kSimpleRadial, "SIMPLE_RADIAL", 4, 1, "f cx cy k"},
    ModelRow{CameraModel::kRadial, "RADIAL", 5, 1, "f cx cy k1 k2"},
    ModelRow{CameraModel::kOpenCv, "OPENCV", 8, 2, "fx fy cx cy k1 k2 p1 p2"},
    ModelRow{CameraModel::kOpenCvFisheye, "OPENCV_FISHEYE", 8, 2, "fx fy cx cy k1 k2 k3 k4"},
    ModelRow{CameraModel::kFullOpenCv, "FULL_OPENCV", 12, 2, "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"},
    ModelRow{CameraModel::kEquirectangular, "EQUIRECTANGULAR", 0, 0, ""},
};

const ModelRow& RowOf(CameraModel model) {
  const auto row = std::ranges::find(kModels, model, &ModelRow::model);
  WS_CHECK(row != kModels.end(), "camera model " + std::to_string(static_cast<int>(model)));
  return *row;
}

// Every model but the equirectangular one, written as one: the affine part and the coefficients
// (radial k1..k6, tangential p; for the fisheye only k1..k4).
struct Lens {
  Eigen::Vector2d focal;
  Eigen::Vector2d centre;
  std::array<double, 6> k{};
  double p1 = 0;
  double p2 = 0;
};

Lens LensOf(const Camera& camera) {
  const ModelRow& row = RowOf(camera.model);
  const std::vector<double>& p = camera.params;
  WS_CHECK(static_cast<int>(p.size()) == row.parameters, "parameters of an unchecked camera");
  const size_t n = row.focal_lengths;
  Lens lens{.focal = {p[0], p[n - 1]}, .centre = {p[n], p[n + 1]}};
  switch (camera.model) {
    case CameraModel::kSimpleRadial:
      lens.k[0] = p[3];
      break;
    case CameraModel::kRadial:
      lens.k = {p[3], p[4]};
      break;
    case CameraModel::kOpenCvFisheye:
      lens.k = {p[4], p[5], p[6], p[7]};
      break;
    case CameraModel::kFullOpenCv:
      lens.k = {p[4], p[5], p[8], p[9], p[10], p[11]};
      lens.p1 = p[6];
      lens.p2 = p[7];
      break;
    case CameraModel::kOpenCv:
      lens.k = {p[4], p[5]};
      lens.p1 = p[6];
      lens.p2 = p[7];
      break;
    default:
      break;
  }
  return lens;
}

struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
  bool one_to_one = false;  // here the distortion keeps orientation: it has not folded over
};

// The radial and tangential distortion of a point in the plane Z = 1, with its derivative.
Distorted Distort(const Lens& lens, const Eigen::Vector2d& point) {
  const auto& [k1, k2, k3, k4, k5, k6] = lens.k;
  const double x = point.x();
  const double y = point.y();
  const double s = point.squaredNorm();
  const double above = 1 + s * (k1 + s * (k2 + s * k3));
  const double below = 1 + s * (k4 + s * (k5 + s * k6));
  const double above_slope = k1 + s * (2 * k2 + s * 3 * k3);
  const double below_slope = k4 + s * (2 * k5 + s * 3 * k6);
  const double radial = above / below;
  const double slope = (above_slope * below - above * below_slope) / (below * below);
  Distorted out;
  out.point = {x * radial + 2 * lens.p1 * x * y + lens.p2 * (s + 2 * x * x),
               y * radial + lens.p1 * (s + 2 * y * y) + 2 * lens.p2 * x * y};
  const double mixed = 2 * x * y * slope + 2 * lens.p1 * x + 2 * lens.p2 * y;
  out.jacobian << radial + 2 * x * x * slope + 2 * lens.p1 * y + 6 * lens.p2 * x, mixed, mixed,
      radial + 2 * y * y * slope + 6 * lens.p1 * y + 2 * lens.p2 * x;
  out.one_to_one =
      below > 0 && radial > 0 && out.jacobian.trace() > 0 && out.jacobian.determinant() > 0;
  return out;
}

bool IsPinhole(const Lens& lens) {
  return lens.p1 == 0 && lens.p2 == 0 &&
         std::ranges::all_of(lens.k, [](double k) { return k == 0; });
}

// Whether the distortion is one-to-one all the way from the optical axis to the point: beyond a
// fold it may look sound again, although another point has the same pixel.
bool InDomain(const Lens& lens, const Eigen::Vector2d& point) {
  constexpr int kSteps = 16;
  for (int i = 1; i <= kSteps; ++i) {
    if (!Distort(lens, point * (static_cast<double>(i) / kSteps)).one_to_one) return false;
  }
  return true;
}

std::optional<Eigen::Vector2d> ProjectPerspective(const Lens& lens, const Eigen::Vector3d& x) {
  if (!(x.z() > 0)) return std::nullopt;
  const Eigen::Vector2d flat = x.head<2>() / x.z();
  if (!flat.allFinite()) return std::nullopt;
  if (IsPinhole(lens)) return lens.focal.cwiseProduct(flat) + lens.centre;
  if (!InDomain(lens, flat)) return std::nullopt;
  return lens.focal.cwiseProduct(Distort(lens, flat).point) + lens.centre;
}

// Newton's method from the undistorted guess; a step that would leave the domain or make things
// worse is halved.
Eigen::Vector3d UnprojectPerspective(const Lens& lens, const Eigen::Vector2d& target) {
  constexpr int kMaxSteps = 50;
  constexpr int kMaxHalvings = 30;
  constexpr double kTolerance = 1e-14;  // of the plane Z = 1: far below 1e-6 px
  if (IsPinhole(lens)) return target.homogeneous().normalized();
  Eigen::Vector2d guess = InDomain(lens, target) ? target : Eigen::Vector2d::Zero();
  Distorted now = Distort(lens, guess);
  for (int i = 0; i < kMaxSteps && (target - now.point).norm() > kTolerance; ++i) {
    Eigen::Vector2d step = now.jacobian.inverse() * (target - now.point);
    bool better = false;
    for (int halving = 0; halving < kMaxHalvings && !better; ++halving, step /= 2) {
      const Distorted next = Distort(lens, guess + step);
      better = (target - next.point).norm() < (target - now.point).norm() &&
               InDomain(lens, guess + step);
      if (!better) continue;
      guess += step;
      now = next;
      break;
    }
    if (!better) break;
  }
  return guess.homogeneous().normalized();
}

double FisheyeRadius(const Lens& lens, double angle) {
  const double s = angle * angle;
  return angle * (1 + s * (lens.k[0] + s * (lens.k[1] + s * (lens.k[2] + s * lens.k[3]))));
}

double FisheyeSlope(const Lens& lens, double angle) {
  const double s = angle * angle;
  return 1 + s * (3 * lens.k[0] + s * (5 * lens.k[1] + s * (7 * lens.k[2] + s * 9 * lens.k[3])));
}

// The largest angle up to which the radius grows, in [0, pi].
double FisheyeLimit(const Lens& lens) {
  constexpr int kSteps = 64;
  constexpr int kHalvings = 40;
  double low = 0;
  double high = 0;
  for (int i = 1; i <= kSteps; ++i) {
    low = high;
    high = kPi * i / kSteps;
    if (FisheyeSlope(lens, high) <= 0) break;
    if (i == kSteps) return kPi;
  }
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (FisheyeSlope(lens, middle) > 0 ? low : high) = middle;
  }
  return low;
}

std::optional<Eigen::Vector2d> ProjectFisheye(const Lens& lens, const Eigen::Vector3d& x) {
  const double side = x.head<2>().norm();
  const double angle = std::atan2(side, x.z());
  if (x.squaredNorm() == 0 || angle > FisheyeLimit(lens)) return std::nullopt;
  if (side == 0 && x.z() < 0) return std::nullopt;  // straight behind: every direction at once
  if (side == 0) return lens.centre;
  return lens.focal.cwiseProduct(x.head<2>() * (FisheyeRadius(lens, angle) / side)) + lens.centre;
}

Eigen::Vector3d UnprojectFisheye(const Lens& lens, const Eigen::Vector2d& target) {
  constexpr int kHalvings = 60;
  const double radius = target.norm();
  if (radius == 0) return Eigen::Vector3d::UnitZ();
  double low = 0;
  double high = FisheyeLimit(lens);
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (FisheyeRadius(lens, middle) < radius ? low : high) = middle;
  }
  const double angle = (low + high) / 2;
  const Eigen::Vector2d side = target / radius * std::sin(angle);
  return {side.x(), side.y(), std::cos(angle)};
}

std::optional<Eigen::Vector2d> ProjectEquirectangular(const Camera& camera,
                                                      const Eigen::Vector3d& x) {
  if (x.squaredNorm() == 0) return std::nullopt;
  const double azimuth = std::atan2(x.x(), x.z());
  const double elevation = std::atan2(x.y(), std::hypot(x.x(), x.z()));
  return Eigen::Vector2d((azimuth / (2 * kPi) + 0.5) * camera.width - 0.5,
                         (elevation / kPi + 0.5) * camera.height - 0.5);
}

Eigen::Vector3d UnprojectEquirectangular(const Camera& camera, const Eigen::Vector2d& pixel) {
  const double azimuth = ((pixel.x() + 0.5) / camera.width - 0.5) * 2 * kPi;
  const double elevation = ((pixel.y() + 0.5) / camera.height - 0.5) * kPi;
  return {std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
          std::cos(elevation) * std::cos(azimuth)};
}

[[noreturn]] void Refuse(const std::string& cause) { throw MapError(ErrorCode::kBadCamera, cause); }

}  // namespace

std::string_view NameOf(CameraModel model) { return RowOf(model).name; }

std::optional<CameraModel> CameraModelByName(std::string_view name) {
  const auto row = std::ranges::find(kModels, name, &ModelRow::name);
  return row == kModels.end() ? std::nullopt : std::optional(row->model);
}

int ParameterCount(CameraModel model) { return RowOf(model).parameters; }

std::string_view ParameterNames(CameraModel model) { return RowOf(model).parameter_names; }

void MovePrincipalPoint(Camera& camera, double px) {
  const std::vector<std::string> names = Words(ParameterNames(camera.model));
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i] == "cx" || names[i] == "cy") camera.params[i] += px;
  }
}

void CheckCamera(const Camera& camera) {
  const auto row = std::ranges::find(kModels, camera.model, &ModelRow::model);
  if (row == kModels.end()) {
    Refuse("camera model " + std::to_string(static_cast<int>(camera.model)) +
           " is unknown; use a COLMAP model name such as PINHOLE or OPENCV");
  }
  const auto fits = [](int side) { return side >= 1 && side <= kMaxSide; };
  if (!fits(camera.width) || !fits(camera.height)) {
    Refuse("a camera of " + std::to_string(camera.width) + "x" + std::to_string(camera.height) +
           " pixels; each side must be between 1 and " + std::to_string(kMaxSide));
  }
  const std::string name(row->name);
  if (static_cast<int>(camera.params.size()) != row->parameters) {
    Refuse(name + " has " + std::to_string(row->parameters) + " parameters, not " +
           std::to_string(camera.params.size()));
  }
  for (size_t i = 0; i < camera.params.size(); ++i) {
    const double value = camera.params[i];
    const bool focal = static_cast<int>(i) < row->focal_lengths;
    const bool sensible = std::abs(value) <= kMaxParameter;  // false for NaN
    if (!sensible || (focal && value < kMinFocal_px)) {
      std::ostringstream error;
      error << "parameter " << i + 1 << " of " << name << " is " << value
            << (focal ? "; it must be from 1e-6 to 1e9" : "; it must be from -1e9 to 1e9");
      Refuse(error.str());
    }
  }
}

std::optional<Eigen::Vector2d> Project(const Camera& camera, const Eigen::Vector3d& x_camera) {
  if (!x_camera.allFinite()) return std::nullopt;
  if (camera.model == CameraModel::kEquirectangular) {
    return ProjectEquirectangular(camera, x_camera);
  }
  const Lens lens = LensOf(camera);
  return camera.model == CameraModel::kOpenCvFisheye ? ProjectFisheye(lens, x_camera)
                                                     : ProjectPerspective(lens, x_camera);
}

Eigen::Vector3d Unproject(const Camera& camera, const Eigen::Vector2d& pixel) {
  if (camera.model == CameraModel::kEquirectangular) {
    return UnprojectEquirectangular(camera, pixel);
  }
  const Lens lens = LensOf(camera);
  const Eigen::Vector2d target = (pixel - lens.centre).cwiseQuotient(lens.focal);
  return camera.model == CameraModel::kOpenCvFisheye ? UnprojectFisheye(lens, target)
                                                     : UnprojectPerspective(lens, target);
}

}  // namespace waystone
