// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <vector>

#include "bench/accuracy/common.h"
#include "bench/accuracy/settings.h"
#include "core/base/error.h"
#include "core/features/match.h"
#include "core/homography/find_plane.h"
#include "core/image/decode.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kFound_px = 5;  // mean error of the four corners
constexpr double kBaselineError_px = 2;

Eigen::Matrix3d ReadHomography(const fs::path& path) {
  std::ifstream in(path);
  Eigen::Matrix3d h;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      if (!(in >> h(row, column))) {
        throw MapError(ErrorCode::kFileUnreadable, path.string() + ": wants nine numbers");
      }
    }
  }
  return h;
}

// Mean distance, px in the second image, of where two homographies put the first one's corners.
double CornerError(const Eigen::Matrix3d& found, const Eigen::Matrix3d& truth, cv::Size image) {
  double sum = 0;
  for (const double x : {0.0, image.width - 1.0}) {
    for (const double y : {0.0, image.height - 1.0}) {
      const Eigen::Vector3d corner(x, y, 1);
      sum += ((found * corner).hnormalized() - (truth * corner).hnormalized()).norm() / 4;
    }
  }
  return sum;
}

// What plain RANSAC makes of the same matches.
std::optional<Eigen::Matrix3d> BaselineHomography(const MatchedPoints& points) {
  if (points.size() < 4) return {};
  std::vector<cv::Point2d> from;
  std::vector<cv::Point2d> to;
  for (int i = 0; i < points.size(); ++i) {
    from.emplace_back(points.from[i].x(), points.from[i].y());
    to.emplace_back(points.to[i].x(), points.to[i].y());
  }
  const cv::Mat h = cv::findHomography(from, to, cv::USAC_MAGSAC, kBaselineError_px);
  if (h.empty()) return {};
  return Eigen::Matrix3d(Eigen::Map<const Eigen::Matrix3d>(h.ptr<double>()).transpose());
}

struct PairErrors {
  std::string name;
  int matches = 0;
  double planes_px = std::numeric_limits<double>::infinity();
  double baseline_px = std::numeric_limits<double>::infinity();
};

PairErrors Measure(const Features& a, const Features& b, const Eigen::Matrix3d& truth,
                   const PlaneLayerOptions& options) {
  MatchedPoints points;
  for (const Match& match : MatchDescriptors(a.descriptors, b.descriptors, a.type, options.match)) {
    points.from.push_back(PositionOf(a.keypoints[match.a]));
    points.to.push_back(PositionOf(b.keypoints[match.b]));
  }
  const auto error = [&](const Eigen::Matrix3d& to_from) {
    return CornerError(ImageFromWorking(b) * to_from * ImageFromWorking(a).inverse(), truth,
                       ImageSize(a));
  };
  PairErrors errors;
  errors.matches = points.size();
  if (const auto fit = FindPlane(points, options.segmentation.ransac, options.seed)) {
    errors.planes_px = error(fit->model.to_from);
  }
  if (const auto h = BaselineHomography(points)) errors.baseline_px = error(*h);
  return errors;
}

double FoundShare(const std::vector<PairErrors>& pairs, double PairErrors::*error) {
  const auto found =
      std::ranges::count_if(pairs, [&](const PairErrors& p) { return p.*error <= kFound_px; });
  return static_cast<double>(found) / pairs.size();
}

double MedianError(const std::vector<PairErrors>& pairs, double PairErrors::*error) {
  std::vector<double> errors;
  for (const PairErrors& pair : pairs) errors.push_back(std::min(pair.*error, 1e6));
  return Quantile(errors, 0.5);
}

}  // namespace

int RunHomographies(const Args& raw) {
  Args args = raw;
  const BuildOptions options = TakeBuildSettings(args);
  std::vector<PairErrors> pairs;
  for (const std::string& folder : args) {
    const Features first =
        ExtractFeatures(DecodeGrey(ReadBytes(fs::path(folder) / "1.jpg")), options.features);
    for (int k = 2; fs::exists(fs::path(folder) / (std::to_string(k) + ".jpg")); ++k) {
      const fs::path truth = fs::path(folder) / ("H_1_" + std::to_string(k) + ".txt");
      if (!fs::exists(truth)) continue;
      const fs::path image = fs::path(folder) / (std::to_string(k) + ".jpg");
      const Features other = ExtractFeatures(DecodeGrey(ReadBytes(image)), options.features);
      PairErrors pair = Measure(first, other, ReadHomography(truth), options.planes);
      pair.name = fs::canonical(folder).filename().string() + " 1-" + std::to_string(k);
      std::printf("%-22s %4d matches, corner error %9.1f px, MAGSAC %9.1f px\n", pair.name.c_str(),
                  pair.matches, pair.planes_px, pair.baseline_px);
      pairs.push_back(std::move(pair));
    }
  }
  if (pairs.empty()) throw MapError(ErrorCode::kUsage, "homographies wants folders with H_1_2.txt");
  const nlohmann::ordered_json json = {
      {"bench", "homographies"},
      {"pairs", pairs.size()},
      {"found_share", FoundShare(pairs, &PairErrors::planes_px)},
      {"error_median_px", MedianError(pairs, &PairErrors::planes_px)},
      {"magsac_found_share", FoundShare(pairs, &PairErrors::baseline_px)},
      {"magsac_error_median_px", MedianError(pairs, &PairErrors::baseline_px)}};
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
