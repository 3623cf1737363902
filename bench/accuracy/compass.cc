// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "bench/accuracy/common.h"
#include "bench/accuracy/panorama_places.h"
#include "bench/accuracy/stopwatch.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/image/decode.h"
#include "core/panorama/visual_compass.h"

namespace waystone::bench {
namespace {

constexpr double kRight_deg = 10;   // a heading closer than this is right
constexpr double kClaimed_deg = 5;  // a sigma below this claims to be right
constexpr int kRuns = 50;           // whose median time is printed
constexpr int kRenderedPlaces = 60;
constexpr uint64_t kSeed = 1;
constexpr uint64_t kFlats = 6;        // made flats, from this seed on: nothing was chosen by
constexpr uint64_t kFirstFlat = 101;  // them, but by seeds below 100

struct Bin {
  double from_m;
  double to_m;
};
constexpr Bin kBins[] = {{0, 1.5}, {1.5, 2.5}, {2.5, 4}};

struct PairResult {
  double distance_m = 0;
  double plain_deg = 0;  // errors
  double phases_deg = 0;
  double error_deg = 0;
  double sigma_deg = 0;
  double motion_error_deg = -1;  // -1: not determined
  double motion_sigma_deg = 0;
  CompassHeading heading;
};

double Error(double angle_rad, double truth_rad) {
  return std::abs(std::remainder(angle_rad - truth_rad, 2 * std::numbers::pi)) * kDegreesPerRadian;
}

// The plain compass to compare with: the middle 28 % of the rows as 50 x 360, row means removed,
// 12 harmonics, peak of the summed cross-spectrum.
constexpr int kPlainHarmonics = 12;
constexpr int kPlainSteps = 3600;

cv::Mat PlainSpectrum(const cv::Mat& grey) {
  const cv::Mat band = grey.rowRange(cvRound(0.36 * grey.rows), cvRound(0.64 * grey.rows));
  cv::Mat small;
  cv::resize(band, small, {360, 50}, 0, 0, cv::INTER_AREA);
  small.convertTo(small, CV_32F);
  cv::Mat spectrum;
  cv::dft(small, spectrum, cv::DFT_ROWS | cv::DFT_COMPLEX_OUTPUT);
  return spectrum.colRange(1, kPlainHarmonics + 1).clone();  // without the row means
}

double PlainHeading(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat product;
  cv::mulSpectrums(a, b, product, 0, true);
  cv::Mat sums;
  cv::reduce(product, sums, 0, cv::REDUCE_SUM);
  double best = -1e300;
  double heading = 0;
  for (int i = 0; i < kPlainSteps; ++i) {
    const double turn = 2 * std::numbers::pi * i / kPlainSteps;
    double score = 0;
    for (int l = 1; l <= kPlainHarmonics; ++l) {
      const auto term = sums.at<cv::Vec2f>(0, l - 1);
      score += (std::complex<double>(term[0], term[1]) * std::polar(1.0, -l * turn)).real();
    }
    if (score > best) {
      best = score;
      heading = turn;
    }
  }
  return heading;
}

PairResult Compare(const PanoramaPlace& a, const PanoramaPlace& b, const FourierSignature& of_a,
                   const FourierSignature& of_b) {
  PairResult result;
  const double truth = TrueHeading(a, b);
  result.distance_m = (a.position_m - b.position_m).norm();
  result.phases_deg = Error(TurnByPhases(of_a, of_b).best.heading_rad, truth);
  result.heading = RelativeHeading(of_a, of_b);
  result.error_deg = Error(result.heading.heading_rad, truth);
  result.sigma_deg = result.heading.sigma_rad * kDegreesPerRadian;
  if (result.heading.motion) {
    result.motion_error_deg = Error(result.heading.motion->direction_rad, TrueDirection(a, b));
    result.motion_sigma_deg = result.heading.motion->sigma_rad * kDegreesPerRadian;
  }
  return result;
}

std::vector<PairResult> ComparePairs(const std::vector<PanoramaPlace>& places) {
  std::vector<FourierSignature> signatures(places.size());
  std::vector<cv::Mat> plain(places.size());
  tbb::parallel_for(size_t{0}, places.size(), [&](size_t i) {
    signatures[i] = Signature(places[i].grey);
    plain[i] = PlainSpectrum(places[i].grey);
  });
  std::vector<std::pair<size_t, size_t>> pairs;
  for (size_t a = 0; a < places.size(); ++a) {
    for (size_t b = a + 1; b < places.size(); ++b) {
      if (!places[a].hidden.empty() && places[a].hidden[b]) continue;
      if ((places[a].position_m - places[b].position_m).norm() < std::end(kBins)[-1].to_m) {
        pairs.emplace_back(a, b);
      }
    }
  }
  std::vector<PairResult> results(pairs.size());
  tbb::parallel_for(size_t{0}, pairs.size(), [&](size_t i) {
    const auto [a, b] = pairs[i];
    results[i] = Compare(places[a], places[b], signatures[a], signatures[b]);
    results[i].plain_deg =
        Error(PlainHeading(plain[a], plain[b]), TrueHeading(places[a], places[b]));
  });
  return results;
}

double ShareRight(const std::vector<double>& errors) {
  const auto right = std::ranges::count_if(errors, [](double e) { return e < kRight_deg; });
  return errors.empty() ? 0 : static_cast<double>(right) / static_cast<double>(errors.size());
}

// Null without errors: nothing was measured, which is neither the best nor the worst.
nlohmann::json MedianJson(const std::vector<double>& errors) {
  return errors.empty() ? nlohmann::json() : nlohmann::json(Quantile(errors, 0.5));
}

nlohmann::json ShareRightJson(const std::vector<double>& errors) {
  return errors.empty() ? nlohmann::json() : nlohmann::json(ShareRight(errors));
}

nlohmann::json ErrorsJson(const std::vector<double>& errors) {
  return {{"median_deg", MedianJson(errors)}, {"within_10_deg", ShareRightJson(errors)}};
}

nlohmann::json BinJson(const std::string& name, const std::vector<PairResult>& results,
                       const Bin& bin) {
  std::vector<double> plain;
  std::vector<double> phases;
  std::vector<double> ours;
  std::vector<double> claimed;
  std::vector<double> motions;
  for (const PairResult& result : results) {
    if (result.distance_m < bin.from_m || result.distance_m >= bin.to_m) continue;
    plain.push_back(result.plain_deg);
    phases.push_back(result.phases_deg);
    ours.push_back(result.error_deg);
    if (result.sigma_deg <= kClaimed_deg) claimed.push_back(result.error_deg);
    if (result.motion_error_deg >= 0) motions.push_back(result.motion_error_deg);
  }
  std::printf(
      "%-8s %3.1f-%3.1f m  %4zu pairs  plain %5.2f deg %4.1f %%  phases %5.2f deg %4.1f %%  "
      "compass %5.2f deg %4.1f %%  claimed %3zu, right %5.1f %%  direction %3zu: %4.1f deg\n",
      name.c_str(), bin.from_m, bin.to_m, ours.size(), Quantile(plain, 0.5),
      100 * ShareRight(plain), Quantile(phases, 0.5), 100 * ShareRight(phases), Quantile(ours, 0.5),
      100 * ShareRight(ours), claimed.size(), 100 * ShareRight(claimed), motions.size(),
      Quantile(motions, 0.5));
  return {{"from_m", bin.from_m},         {"to_m", bin.to_m},
          {"pairs", ours.size()},         {"plain", ErrorsJson(plain)},
          {"phases", ErrorsJson(phases)}, {"compass", ErrorsJson(ours)},
          {"claimed", claimed.size()},    {"claimed_within_10_deg", ShareRightJson(claimed)},
          {"directions", motions.size()}, {"direction_median_deg", MedianJson(motions)}};
}

void WriteCsv(const std::string& path, const std::vector<PairResult>& results) {
  std::ofstream out(path);
  out << "distance_m,error_deg,deviation_deg,sharpness,small_motion,phases_deg,plain_deg,"
         "motion_error_deg,motion_deviation_deg\n";
  for (const PairResult& r : results) {
    out << r.distance_m << ',' << r.error_deg << ',' << r.sigma_deg << ',' << r.heading.sharpness
        << ',' << r.heading.small_motion << ',' << r.phases_deg << ',' << r.plain_deg << ','
        << r.motion_error_deg << ',' << r.motion_sigma_deg << '\n';
  }
  if (!out.flush()) throw MapError(ErrorCode::kFileUnwritable, path + " can't be written");
}

nlohmann::json Accuracy(const std::string& name, const std::vector<PairResult>& results,
                        const std::string& csv) {
  nlohmann::json bins = nlohmann::json::array();
  for (const Bin& bin : kBins) bins.push_back(BinJson(name, results, bin));
  std::vector<double> claimed;
  for (const PairResult& result : results) {
    if (result.sigma_deg <= kClaimed_deg) claimed.push_back(result.error_deg);
  }
  std::printf("%-8s claims of %.0f deg or better: %zu of %zu, %.1f %% within %.0f deg\n",
              name.c_str(), kClaimed_deg, claimed.size(), results.size(), 100 * ShareRight(claimed),
              kRight_deg);
  if (!csv.empty()) WriteCsv(csv + name + ".csv", results);
  return {{"bins", bins},
          {"pairs", results.size()},
          {"claimed", claimed.size()},
          {"claimed_within_10_deg", ShareRightJson(claimed)}};
}

template <typename Work>
double MedianMicroseconds(const Work& work) {
  std::vector<double> times;
  for (int run = 0; run < kRuns; ++run) {
    const Stopwatch watch;
    work();
    times.push_back(1e6 * watch.cpu_s());
  }
  return Quantile(times, 0.5);
}

// Each step beside its floor: the signature beside its DFT, all of a panorama beside its decoding.
nlohmann::json Times(const PanoramaPlace& a, const PanoramaPlace& b) {
  cv::Mat image;
  cv::resize(a.grey, image, {1024, 512}, 0, 0, cv::INTER_LINEAR);
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", image, jpeg);
  const SignatureOptions options;
  const Panorama panorama = {image, {}};
  const cv::Mat band = ExtractBand(panorama, options);
  const FourierSignature of_a = DescribeBand(band, options);
  const FourierSignature of_b = Signature(b.grey, options);
  cv::Mat spectrum;
  nlohmann::json times = {
      {"decode", MedianMicroseconds([&] { DecodeGrey(jpeg); })},
      {"band", MedianMicroseconds([&] { ExtractBand(panorama, options); })},
      {"dft", MedianMicroseconds([&] { cv::dft(band, spectrum, cv::DFT_ROWS); })},
      {"signature_of_band", MedianMicroseconds([&] { DescribeBand(band, options); })},
      {"phase_compass", MedianMicroseconds([&] { TurnByPhases(of_a, of_b); })},
      {"compass", MedianMicroseconds([&] { RelativeHeading(of_a, of_b); })}};
  std::printf("microseconds, 1024x512:");
  for (const auto& [name, value] : times.items()) {
    std::printf("  %s %.0f", name.c_str(), value.get<double>());
  }
  std::printf("\n");
  const auto us = [&](const char* name) { return times[name].get<double>(); };
  times["signature_over_dft"] = us("signature_of_band") / us("dft");
  times["signature_and_band_over_dft"] = (us("signature_of_band") + us("band")) / us("dft");
  times["compass_over_decode"] = us("compass") / us("decode");
  return times;
}

}  // namespace

int RunCompass(const Args& raw) {
  Args args = raw;
  const std::string csv = TakeOption(args, "csv", "");
  if (args.size() > 1) throw MapError(ErrorCode::kUsage, "compass takes one folder at most");
  cv::setNumThreads(1);
  const std::vector<PanoramaPlace> rendered = RenderPlaces(kRenderedPlaces, kSeed);
  std::vector<PairResult> flats;
  for (uint64_t seed = kFirstFlat; seed < kFirstFlat + kFlats; ++seed) {
    std::ranges::move(ComparePairs(RenderFlatPlaces(seed)), std::back_inserter(flats));
  }
  nlohmann::json json = {{"bench", "compass"},
                         {"world", Accuracy("world", ComparePairs(rendered), csv)},
                         {"flats", Accuracy("flats", flats, csv)}};
  if (!args.empty()) json["places"] = Accuracy("places", ComparePairs(ReadPlaces(args[0])), csv);
  json["microseconds"] = Times(rendered[0], rendered[1]);
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
