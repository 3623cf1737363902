// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/plane_calibration.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <string>
#include <unordered_set>

#include "builder/calibration/map_parts.h"
#include "builder/calibration/rendered_negatives.h"
#include "core/base/random.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/surroundings.h"

namespace waystone {
namespace {

using Descriptor = std::string;  // its bytes

Descriptor BytesOf(const Features& features, int row) {
  return {reinterpret_cast<const char*>(features.descriptors.row(row)),
          static_cast<size_t>(features.descriptors.bytes())};
}

// The descriptors of all planes. A query with exactly one of these is the image from which it was
// taken: the map doesn't record from which keyframe each is.
std::unordered_set<Descriptor> DescriptorsInMap(const MapIndex& index) {
  std::unordered_set<Descriptor> all;
  for (int p = 0; p < static_cast<int>(index.map().planes.size()); ++p) {
    const Descriptors of_plane = index.DescriptorsOf(p);
    for (int row = 0; row < of_plane.rows(); ++row) {
      all.emplace(reinterpret_cast<const char*>(of_plane.row(row)),
                  static_cast<size_t>(of_plane.bytes()));
    }
  }
  return all;
}

Features WithoutThoseOf(const std::unordered_set<Descriptor>& in_map, const Features& features) {
  Features left = features;
  left.keypoints.clear();
  left.descriptors = Descriptors(features.descriptors.bytes());
  for (int row = 0; row < features.size(); ++row) {
    if (in_map.contains(BytesOf(features, row))) continue;
    left.keypoints.push_back(features.keypoints[row]);
    left.descriptors.Append(features.descriptors.row(row));
  }
  return left;
}

// The same descriptors at other positions: they match as well, but fit only by chance.
Features Scrambled(Features features, Random& random) {
  for (int i = features.size() - 1; i > 0; --i) {
    std::swap(features.keypoints[i], features.keypoints[random.Below(i + 1)]);
  }
  return features;
}

bool Sees(const Plane& plane, KeyframeId keyframe) {
  return std::any_of(plane.views.begin(), plane.views.end(),
                     [&](const PlaneView& view) { return view.keyframe == keyframe; });
}

// Whether a plane is seen in a keyframe or near one that is.
bool IsAt(const MapIndex& index, int plane, KeyframeId keyframe) {
  const std::vector<Plane>& planes = index.map().planes;
  return std::any_of(planes.begin(), planes.end(), [&](const Plane& seen) {
    return Sees(seen, keyframe) && PlanesAreNear(index, seen, planes[plane]);
  });
}

std::vector<VerifiedPlane> TryAll(const MapIndex& index, const Features& query,
                                  const PlaneQueryOptions& options) {
  return TryPlanes(index, query, ShortlistPlanes(index, query, options), options);
}

// The place where the keyframe is, by the planes that are seen there.
void AskRight(const MapIndex& index, const Features& query, KeyframeId keyframe,
              const PlaneQueryOptions& options, std::vector<VerdictSample>& samples) {
  std::vector<VerifiedPlane> planes = TryAll(index, query, options);
  std::erase_if(planes, [&](const VerifiedPlane& plane) {
    return !plane.accepted || !IsAt(index, plane.plane, keyframe);
  });
  const std::vector<Place> places = GroupPlaces(index, std::move(planes), options);
  if (!places.empty()) samples.push_back({places.front().evidence, true});
}

// The place that fits best by chance, even where a gate would stop its planes.
void AskWrong(const MapIndex& index, const Features& query, const PlaneQueryOptions& options,
              std::vector<VerdictSample>& samples) {
  const std::vector<Place> places = GroupPlaces(index, TryAll(index, query, options), options);
  if (!places.empty()) samples.push_back({places.front().evidence, false});
}

std::vector<VerdictSample> Ask(const MapIndex& index, const std::unordered_set<Descriptor>& in_map,
                               const SampledKeyframe& query, const CalibrationOptions& options) {
  std::vector<VerdictSample> samples;
  AskRight(index, WithoutThoseOf(in_map, query.features), query.keyframe, options.localize.planes,
           samples);
  Random random(options.seed ^ static_cast<uint64_t>(query.keyframe.value));
  AskWrong(index, Scrambled(query.features, random), options.localize.planes, samples);
  return samples;
}

// Opens the gates as far as possible: the model has to see what they would stop.
CalibrationOptions WithOpenGates(CalibrationOptions options) {
  constexpr int kFewest = 5;  // four fit any homography
  options.localize.planes.gates.min_inliers = kFewest;
  options.localize.planes.gates.min_inlier_share = 0;
  options.localize.planes.settled_inliers = std::numeric_limits<int>::max();
  return options;
}

}  // namespace

void CalibrationOptions::Check() const {
  CheckFields("calibration", *this);
  localize.Check();
  fit.Check();
}

VerdictModel CalibrateVerdict(const MapIndex& index, const std::vector<SampledKeyframe>& queries,
                              const std::vector<Features>& outside,
                              const CalibrationOptions& given) {
  given.Check();
  const CalibrationOptions options = WithOpenGates(given);
  const std::unordered_set<Descriptor> in_map = DescriptorsInMap(index);
  std::vector<std::vector<VerdictSample>> asked(queries.size());
  tbb::parallel_for(size_t{0}, queries.size(),
                    [&](size_t q) { asked[q] = Ask(index, in_map, queries[q], options); });
  std::vector<std::vector<VerdictSample>> refused(outside.size());
  tbb::parallel_for(size_t{0}, outside.size(), [&](size_t q) {
    AskWrong(index, outside[q], options.localize.planes, refused[q]);
  });
  asked.insert(asked.end(), refused.begin(), refused.end());
  std::vector<VerdictSample> samples;
  for (const auto& of_query : asked)
    samples.insert(samples.end(), of_query.begin(), of_query.end());
  return FitVerdictModel(samples, options.fit);
}

void CalibratePlaneLayer(MapData& map, const std::vector<SampledKeyframe>& samples,
                         const FeatureOptions& features, const CalibrationOptions& options) {
  map.verdict = CalibrateVerdict(*MapIndex::Build(CopyPlanes(map)), samples,
                                 CachedNegatives(options.rendered_negatives, features), options);
}

}  // namespace waystone
