// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/appearance_calibration.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <set>

#include "builder/calibration/map_parts.h"
#include "builder/calibration/rendered_negatives.h"
#include "core/base/check.h"
#include "localizer/appearance/appearance_match.h"
#include "localizer/index/node_bearings.h"

namespace waystone {
namespace {

// Places of the map by its graph: nodes that follow each other, or that a loop joins, are
// neighbours however far the odometry drifted between them. Floors lie above each other.
class Surroundings {
 public:
  explicit Surroundings(const MapIndex& index)
      : layer_(*index.map().appearance),
        distances_(index.appearance().distances()),
        floor_height_(kSameFloorSpacings * index.appearance().spacing()),
        joined_(layer_.nodes.size()) {
    std::map<AppearanceNodeId, int> at;
    for (size_t i = 0; i < layer_.nodes.size(); ++i) at[layer_.nodes[i].id] = static_cast<int>(i);
    for (const AppearanceEdge& edge : layer_.edges) {
      joined_[at.at(edge.a)].push_back(at.at(edge.b));
      joined_[at.at(edge.b)].push_back(at.at(edge.a));
    }
  }

  // Which nodes are within `radius` of where the query was taken, on its floor, or within `steps`
  // edges of its own node.
  std::vector<bool> Within(const AppearanceCalibrationQuery& query, double radius,
                           int steps) const {
    std::vector<bool> within;
    for (int i = 0; i < static_cast<int>(layer_.nodes.size()); ++i) {
      const bool same_floor =
          query.beside < 0 || distances_.Height(i, query.beside) <= floor_height_;
      within.push_back(same_floor && Apart(layer_.nodes[i].pose, query.truth) <= radius);
    }
    if (query.node >= 0) Walk(query.node, steps, within);
    return within;
  }

 private:
  void Walk(int node, int steps, std::vector<bool>& within) const {
    std::set<int> reached{node};
    for (int step = 0; step < steps; ++step) {
      std::set<int> next = reached;
      for (const int at : reached) next.insert(joined_[at].begin(), joined_[at].end());
      reached = std::move(next);
    }
    for (const int at : reached) within[at] = true;
  }

  const AppearanceLayer& layer_;
  const NodeDistances& distances_;
  double floor_height_;
  std::vector<std::vector<int>> joined_;
};

// The evidence for the best answer; nothing where no node is left.
struct BestAnswer {
  AppearanceEvidence evidence;
  int node = -1;
};

std::optional<BestAnswer> AskBest(const MapIndex& index, const PanoramaQuery& query,
                                  const std::vector<bool>& left_out,
                                  const PanoramaQueryOptions& options) {
  const std::vector<ComparedNode> nodes = CompareQuery(index, query, options, left_out);
  if (nodes.empty()) return std::nullopt;
  BestAnswer best{CollectEvidence(index, nodes, 0, options), nodes.front().node};
  best.evidence.verified = query.features.has_value();
  return best;
}

// The answer to a panorama of the map without the nodes within `blank` spacings: right near where
// it was taken, wrong elsewhere. Nothing in between, where it is neither.
std::optional<AppearanceSample> AskWithout(const MapIndex& index, const Surroundings& surroundings,
                                           const AppearanceCalibrationQuery& query, double blank,
                                           const AppearanceCalibrationOptions& options) {
  const auto within = [&](double spacings) {
    return surroundings.Within(query, spacings * index.appearance().spacing(),
                               static_cast<int>(spacings));
  };
  const auto best = AskBest(index, query.query, within(blank), options.query);
  if (!best) return std::nullopt;
  const bool right = within(options.right_spacings)[best->node];
  if (!right && within(options.query.elsewhere_spacings)[best->node]) return std::nullopt;
  return AppearanceSample{best->evidence, right};
}

std::optional<AppearanceSample> AskOutside(const MapIndex& index, const PanoramaQuery& query,
                                           const AppearanceCalibrationOptions& options) {
  const auto best = AskBest(index, query, {}, options.query);
  if (!best) return std::nullopt;
  return AppearanceSample{best->evidence, false};
}

// Whether answers of which any map would be sure are right by this map's poses; `samples` are those
// for panoramas whose neighbours are in the map. Otherwise its trajectory is too wrong to
// distinguish right from wrong answers.
bool PosesTellWhatIsRight(const std::vector<AppearanceSample>& samples, bool verified,
                          const AppearanceCalibrationOptions& options) {
  const AppearanceVerdict model = DefaultVerdict(verified);
  int sure = 0;
  int right = 0;
  for (const AppearanceSample& sample : samples) {
    if (EstimateProbability(sample.evidence, model) < options.query.min_probability) continue;
    ++sure;
    right += sample.right;
  }
  return right >= options.min_right_share * sure;
}

std::vector<PanoramaQuery> DescribeNegatives(const MapIndex& index,
                                             const AppearanceCalibrationOptions& options) {
  const SignatureOptions& described = index.map().appearance->described;
  const int width_px = std::max(512, 2 * std::max(described.k1, described.k2));
  const auto pictures = RenderedPanoramas(options.rendered_negatives, width_px);
  std::vector<PanoramaQuery> queries(pictures.size());
  tbb::parallel_for(size_t{0}, pictures.size(), [&](size_t i) {
    queries[i] = DescribeQuery(index, pictures[i], options.query);
  });
  return queries;
}

}  // namespace

void AppearanceCalibrationOptions::Check() const {
  CheckFields("appearance_calibration", *this);
  for (const double blank : blank_spacings) {
    if (blank >= 0 && blank <= 1000) continue;
    throw MapError(ErrorCode::kBadOptions, "appearance_calibration.blank_spacings has " +
                                               std::to_string(blank) +
                                               "; each must be between 0 and 1000");
  }
  query.Check();
  fit.Check();
}

AppearanceVerdict CalibrateAppearance(const MapIndex& index,
                                      const std::vector<AppearanceCalibrationQuery>& queries,
                                      const std::vector<PanoramaQuery>& outside, bool verified,
                                      const AppearanceCalibrationOptions& options,
                                      const std::function<void()>& before_each) {
  options.Check();
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const Surroundings surroundings(index);
  const size_t blanks = options.blank_spacings.size();
  const size_t asked = queries.size() * blanks;
  std::vector<std::optional<AppearanceSample>> found(asked + outside.size());
  tbb::parallel_for(size_t{0}, found.size(), [&](size_t i) {
    if (before_each) before_each();
    found[i] = i < asked ? AskWithout(index, surroundings, queries[i / blanks],
                                      options.blank_spacings[i % blanks], options)
                         : AskOutside(index, outside[i - asked], options);
  });
  std::vector<AppearanceSample> samples;
  std::vector<AppearanceSample> beside_neighbours;
  for (size_t i = 0; i < found.size(); ++i) {
    if (!found[i] || found[i]->evidence.verified != verified) continue;
    samples.push_back(*found[i]);
    const bool has_neighbours = i < asked && options.blank_spacings[i % blanks] == 0;
    if (has_neighbours) beside_neighbours.push_back(*found[i]);
  }
  if (!PosesTellWhatIsRight(beside_neighbours, verified, options)) return DefaultVerdict(verified);
  return FitAppearanceVerdict(samples, verified, options.fit);
}

namespace {

// The sample's own node, or the one of its sequence that was taken nearest to it; -1 for none.
int NodeBeside(const AppearanceLayer& layer, const AppearanceSampleFrame& sample) {
  if (sample.node >= 0) return sample.node;
  int beside = -1;
  int least = std::numeric_limits<int>::max();
  for (int i = 0; i < static_cast<int>(layer.nodes.size()); ++i) {
    const int apart = std::abs(layer.nodes[i].frame - sample.info.number);
    if (layer.nodes[i].sequence != sample.sequence || apart >= least) continue;
    beside = i;
    least = apart;
  }
  return beside;
}

void FitAppearanceVerdicts(MapData& map, const std::vector<AppearanceSampleFrame>& samples,
                           const AppearanceCalibrationOptions& options,
                           ProgressReporter& progress) {
  const auto report = [&] { progress.Report("calibration", 0, 1); };
  const auto index = MapIndex::Build(CopyPanoramas(map));
  const std::vector<PanoramaQuery> outside = DescribeNegatives(*index, options);
  std::vector<AppearanceCalibrationQuery> verified;
  std::vector<AppearanceCalibrationQuery> alone;
  for (const AppearanceSampleFrame& sample : samples) {
    const int beside = NodeBeside(*map.appearance, sample);
    alone.push_back({{sample.signature, std::nullopt}, sample.pose, sample.node, beside});
    if (sample.features.size() == 0) continue;
    verified.push_back({{sample.signature, sample.features}, sample.pose, sample.node, beside});
  }
  std::vector<PanoramaQuery> outside_alone;
  for (const PanoramaQuery& query : outside) {
    outside_alone.push_back({query.signature, std::nullopt});
  }
  map.appearance->verdict =
      CalibrateAppearance(*index, alone, outside_alone, false, options, report);
  if (verified.empty()) return;
  map.appearance->verified_verdict =
      CalibrateAppearance(*index, verified, outside, true, options, report);
}

}  // namespace

OwnImages CalibrateAppearanceLayer(MapData& map, const std::vector<AppearanceSampleFrame>& samples,
                                   const AppearanceCalibrationOptions& options,
                                   ProgressReporter& progress) {
  FitAppearanceVerdicts(map, samples, options, progress);
  const OwnImages own = FindOwnPanoramas(map, samples, options.query);
  if (own.AreFound()) return own;
  map.appearance->verdict = DefaultVerdict(false);
  if (map.appearance->verified_verdict) map.appearance->verified_verdict = DefaultVerdict(true);
  return FindOwnPanoramas(map, samples, options.query);
}

}  // namespace waystone
