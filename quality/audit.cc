// SPDX-License-Identifier: Apache-2.0
#include "quality/audit.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <set>

#include "core/base/error.h"
#include "core/homography/homography.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/surroundings.h"
#include "localizer/planes/verify.h"
#include "quality/audit_ties.h"
#include "quality/audit_views.h"

namespace waystone {
namespace {

// A plane's features as in a photo taken at its reference keyframe, those with most votes first.
Features AsQuery(const MapIndex& index, int plane_index, int max_voters) {
  const Plane& plane = index.map().planes[plane_index];
  const Keyframe& reference = *index.FindKeyframe(plane.reference);
  std::vector<int> rows(plane.features.size());
  std::iota(rows.begin(), rows.end(), 0);
  std::stable_sort(rows.begin(), rows.end(),
                   [&](int i, int j) { return plane.features[i].votes > plane.features[j].votes; });
  if (static_cast<int>(rows.size()) > max_voters) rows.resize(max_voters);
  const Descriptors descriptors = index.DescriptorsOf(plane_index);
  Features query;
  query.type = index.map().info.feature_type;
  query.width = reference.width;
  query.height = reference.height;
  query.descriptors = Descriptors(DescriptorBytes(query.type));
  for (const int row : rows) {
    query.keypoints.push_back(plane.features[row].reference);
    query.descriptors.Append(descriptors.row(row));
  }
  return query;
}

// Planes elsewhere in the map that a plane's features vote for.
std::vector<ShortlistedPlane> ShortlistElsewhere(const MapIndex& index, int plane,
                                                 const Features& query,
                                                 const AuditOptions& options) {
  const std::vector<Plane>& planes = index.map().planes;
  PlaneQueryOptions all = options.query;
  all.votes_per_feature = options.votes_per_feature;
  all.max_candidates = std::max(1, static_cast<int>(planes.size()));
  std::vector<ShortlistedPlane> shortlist = ShortlistPlanes(index, query, all);
  std::erase_if(shortlist, [&](const ShortlistedPlane& candidate) {
    return candidate.plane == plane || PlanesAreNear(index, planes[plane], planes[candidate.plane]);
  });
  if (static_cast<int>(shortlist.size()) > options.max_candidates) {
    shortlist.resize(options.max_candidates);
  }
  return shortlist;
}

// A pair of planes by their index in the map.
struct AlikePlanes {
  int a = 0;
  int b = 0;
  int inliers = 0;
  double shared = 0;
};

std::vector<cv::Point2f> ToPolygon(const std::vector<Eigen::Vector2d>& outline) {
  std::vector<cv::Point2f> polygon;
  for (const Eigen::Vector2d& x : outline) polygon.emplace_back(x.x(), x.y());
  return polygon;
}

// Features of a plane that lie inside the outline of another one, seen through a homography;
// `inside` is a point of the first plane that is certainly in front.
int CountWithin(const Plane& plane, const Plane& other, const Eigen::Matrix3d& other_from_plane,
                const Eigen::Vector2d& inside) {
  const std::vector<cv::Point2f> outline = ToPolygon(other.outline);
  if (outline.size() < 3) return 0;
  return static_cast<int>(
      std::count_if(plane.features.begin(), plane.features.end(), [&](const PlaneFeature& feature) {
        const Eigen::Vector2d x(feature.reference.x_px, feature.reference.y_px);
        if (!OnSameSide(other_from_plane, x, inside)) return false;
        const Eigen::Vector2d y = Apply(other_from_plane, x);
        return cv::pointPolygonTest(outline, cv::Point2f(y.x(), y.y()), false) >= 0;
      }));
}

double SharedPart(const Plane& plane, const Plane& other, const Features& query,
                  const VerifiedPlane& verified) {
  const Match& match = verified.inliers.front();
  const Eigen::Matrix3d& other_from_plane = verified.reference_from_query.b_from_a;
  const int within =
      CountWithin(plane, other, other_from_plane, PositionOf(query.keypoints[match.a]));
  const int within_other = CountWithin(other, plane, other_from_plane.inverse(),
                                       PositionOf(other.features[match.b].reference));
  const int both = std::max(1, std::min(within, within_other));
  return std::min(1.0, static_cast<double>(verified.inliers.size()) / both);
}

std::vector<AlikePlanes> FindAlike(const MapIndex& index, int plane, const AuditOptions& options) {
  const Features query = AsQuery(index, plane, options.max_voters);
  if (query.size() < options.query.gates.min_inliers) return {};
  const PackedFeatures packed(query);
  const std::vector<Plane>& planes = index.map().planes;
  std::vector<AlikePlanes> alike;
  for (const ShortlistedPlane& candidate : ShortlistElsewhere(index, plane, query, options)) {
    const auto verified = VerifyPlane(index, packed, candidate.plane, options.query);
    if (!verified || !verified->accepted) continue;
    alike.push_back({std::min(plane, candidate.plane), std::max(plane, candidate.plane),
                     verified->distinct,
                     SharedPart(planes[plane], planes[candidate.plane], query, *verified)});
  }
  return alike;
}

// All pairs once, most inliers first. Of a pair that was found from both sides the better match
// counts.
std::vector<AlikePlanes> FindAllAlike(const MapIndex& index, const AuditOptions& options) {
  const size_t count = index.map().planes.size();
  std::vector<std::vector<AlikePlanes>> of_plane(count);
  tbb::parallel_for(size_t{0}, count, [&](size_t plane) {
    of_plane[plane] = FindAlike(index, static_cast<int>(plane), options);
  });
  std::map<std::pair<int, int>, AlikePlanes> best;
  for (const auto& pairs : of_plane) {
    for (const AlikePlanes& pair : pairs) {
      AlikePlanes& known = best[{pair.a, pair.b}];
      if (pair.inliers > known.inliers) known = pair;
    }
  }
  std::vector<AlikePlanes> all;
  for (const auto& [ids, pair] : best) all.push_back(pair);
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& x, const auto& y) { return x.inliers > y.inliers; });
  return all;
}

// Pairs of planes that support the same pair of places; the first one is the best.
using Group = std::vector<AlikePlanes>;

std::vector<Group> GroupAlike(const MapIndex& index, const std::vector<AlikePlanes>& alike) {
  const std::vector<Plane>& planes = index.map().planes;
  const auto near = [&](int p, int q) {
    return p == q || PlanesAreNear(index, planes[p], planes[q]);
  };
  std::vector<Group> groups;
  for (const AlikePlanes& pair : alike) {
    const auto home = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
      const AlikePlanes& best = group.front();
      return (near(pair.a, best.a) && near(pair.b, best.b)) ||
             (near(pair.a, best.b) && near(pair.b, best.a));
    });
    Group& group = home == groups.end() ? groups.emplace_back() : *home;
    const bool turned = !(near(pair.a, group.empty() ? pair.a : group.front().a) &&
                          near(pair.b, group.empty() ? pair.b : group.front().b));
    group.push_back(turned ? AlikePlanes{pair.b, pair.a, pair.inliers, pair.shared} : pair);
  }
  return groups;
}

// Inliers of pairs that have no plane in common with a better one.
int SumInliers(const Group& group) {
  std::set<int> counted;
  int inliers = 0;
  for (const AlikePlanes& pair : group) {
    if (counted.contains(pair.a) || counted.contains(pair.b)) continue;
    counted.insert({pair.a, pair.b});
    inliers += pair.inliers;
  }
  return inliers;
}

double MeanShared(const std::vector<AliasPlanes>& planes) {
  double sum = 0;
  double weights = 0;
  for (const AliasPlanes& pair : planes) {
    sum += pair.inliers * pair.shared;
    weights += pair.inliers;
  }
  return sum / weights;
}

AliasPair Described(const MapIndex& index, const Group& group,
                    const std::vector<KeyframeView>& views, const AuditOptions& options) {
  const std::vector<Plane>& planes = index.map().planes;
  AliasPair alias;
  alias.a = planes[group.front().a].reference;
  alias.b = planes[group.front().b].reference;
  const bool turned = alias.b < alias.a;
  if (turned) std::swap(alias.a, alias.b);
  for (const AlikePlanes& pair : group) {
    const Plane& a = planes[turned ? pair.b : pair.a];
    const Plane& b = planes[turned ? pair.a : pair.b];
    alias.planes.push_back({a.id, b.id, pair.inliers, pair.shared});
  }
  alias.inliers = SumInliers(group);
  const int in_view = std::min(FeaturesInView(views, alias.a), FeaturesInView(views, alias.b));
  alias.of_view = std::min(1.0, static_cast<double>(alias.inliers) / std::max(1, in_view));
  alias.shared = MeanShared(alias.planes);
  alias.remedy = alias.shared >= options.same_surface_share ? Remedy::kJoin : Remedy::kMarker;
  return alias;
}

std::vector<AliasPair> FindAliases(const MapIndex& index, const std::vector<KeyframeView>& views,
                                   const AuditOptions& options) {
  std::vector<AliasPair> aliases;
  for (const Group& group : GroupAlike(index, FindAllAlike(index, options))) {
    if (SumInliers(group) < options.min_alias_inliers) continue;
    aliases.push_back(Described(index, group, views, options));
  }
  std::stable_sort(aliases.begin(), aliases.end(),
                   [](const auto& x, const auto& y) { return x.inliers > y.inliers; });
  return aliases;
}

}  // namespace

const char* NameOf(Remedy remedy) {
  switch (remedy) {
    case Remedy::kMarker:
      return "marker";
    case Remedy::kJoin:
      return "join";
    case Remedy::kMoreViews:
      return "more_views";
    case Remedy::kSlowerPass:
      return "slower_pass";
  }
  WS_CHECK(false, "unknown remedy");
}

const char* NameOf(Weakness weakness) {
  switch (weakness) {
    case Weakness::kSeesNoPlane:
      return "no_plane";
    case Weakness::kFewFeatures:
      return "few_features";
    case Weakness::kFewPlanes:
      return "few_planes";
  }
  WS_CHECK(false, "unknown weakness");
}

void AuditOptions::Check() const {
  CheckFields("audit", *this);
  query.Check();
}

AuditReport AuditMap(const MapIndex& index, const AuditOptions& options) {
  options.Check();
  const std::vector<KeyframeView> views = CollectViews(index.map());
  return {FindAliases(index, views, options), FindLoneTies(index, views),
          FindWeakRuns(index.map(), views, options)};
}

}  // namespace waystone
