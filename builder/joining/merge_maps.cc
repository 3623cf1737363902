// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/merge_maps.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "builder/joining/append_map.h"
#include "builder/joining/join_appearance.h"
#include "builder/joining/join_frames.h"
#include "builder/joining/join_orientation.h"
#include "builder/joining/joinable.h"
#include "builder/joining/kept_looks.h"
#include "builder/joining/kept_poses.h"
#include "builder/joining/look_again.h"
#include "builder/joining/recognise_keyframes.h"
#include "builder/joining/recognise_nodes.h"
#include "builder/planes/fusion.h"
#include "builder/planes/outline.h"
#include "builder/planes/plane_features.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/sessions.h"

namespace waystone {
namespace {

// Which of the joined maps each plane is from, by the first plane of each: planes of one map are
// consecutive.
class MapOfPlane {
 public:
  void StartMap(PlaneId first) { firsts_.push_back(first); }
  bool AreApart(PlaneId a, PlaneId b) const { return NumberOf(a) != NumberOf(b); }

 private:
  std::ptrdiff_t NumberOf(PlaneId id) const {
    return std::ranges::upper_bound(firsts_, id) - firsts_.begin();
  }

  std::vector<PlaneId> firsts_;
};

std::string_view BytesOf(const std::vector<uint8_t>& picture) {
  return {reinterpret_cast<const char*>(picture.data()), picture.size()};
}

// The pictures of keyframes and panoramas that a map keeps.
template <class Use>
void ForEachPicture(const MapData& map, const Use& use) {
  for (const Keyframe& keyframe : map.keyframes) {
    if (!keyframe.picture.empty()) use(keyframe.sequence, keyframe.picture);
  }
  if (!map.appearance) return;
  for (const AppearanceNode& node : map.appearance->nodes) {
    if (!node.picture.empty()) use(node.sequence, node.picture);
  }
}

// Sessions of the map whose pictures are all in `known` came of images that another map has.
void CheckNotKnown(const MapData& map, const std::set<std::string_view>& known,
                   const std::string& holder) {
  for (const MapSession& session : SessionsOf(map)) {
    int pictures = 0;
    int seen = 0;
    ForEachPicture(map, [&](SequenceId sequence, const std::vector<uint8_t>& picture) {
      if (!std::ranges::binary_search(session.sequences, sequence)) return;
      ++pictures;
      seen += known.contains(BytesOf(picture));
    });
    if (pictures == 0 || seen < pictures) continue;
    throw MapError(ErrorCode::kBadRequest, "session '" + Printable(session.name) +
                                               "' has the same " + std::to_string(pictures) +
                                               " pictures as " + holder + "; give each walk once");
  }
}

// Refuses maps that were built from the same images.
void CheckPictures(const std::vector<MapData>& maps) {
  for (size_t i = 0; i < maps.size(); ++i) {
    std::set<std::string_view> known;
    ForEachPicture(maps[i], [&](SequenceId, const std::vector<uint8_t>& picture) {
      known.insert(BytesOf(picture));
    });
    for (size_t j = 0; j < maps.size(); ++j) {
      if (i != j) CheckNotKnown(maps[j], known, Named(maps[i]));
    }
  }
}

void CheckJoinable(const std::vector<MapData>& maps) {
  if (maps.size() < 2) {
    throw MapError(ErrorCode::kBadRequest,
                   std::to_string(maps.size()) + " map given; joining takes two or more");
  }
  const FeatureType type = maps.front().info.feature_type;
  std::map<std::string, std::string> named;  // sessions by their versions: the map they came in
  for (const MapData& map : maps) {
    if (map.info.feature_type != type) {
      throw MapError(ErrorCode::kBadRequest,
                     Named(maps.front()) + " has " + std::string(NameOf(type)) + " features and " +
                         Named(map) + " has " + std::string(NameOf(map.info.feature_type)) +
                         "; build them with the same --features");
    }
    for (const MapSession& session : SessionsOf(map)) {
      if (session.version.empty()) continue;
      const auto [known, added] = named.emplace(session.version, Named(map));
      if (added) continue;
      throw MapError(ErrorCode::kBadRequest, "session '" + Printable(session.name) + "' is in " +
                                                 known->second + " and again in " + Named(map) +
                                                 "; give each session once");
    }
  }
  CheckLayersAreJoinable(maps);
  CheckPictures(maps);
}

// Fuses planes of different maps, and counts what it does.
void Fuse(const MapOfPlane& origin, const PlaneLayerOptions& options, MapData& map,
          JoinReport& report) {
  std::vector<FusionCandidate> pairs =
      ProposeFusions(map.planes, map.edges, map.info.feature_type, options.fusion);
  std::erase_if(pairs,
                [&](const FusionCandidate& pair) { return !origin.AreApart(pair.m, pair.n); });
  std::map<PlaneId, size_t> feature_count;
  for (const Plane& plane : map.planes) feature_count[plane.id] = plane.features.size();
  const NamedBefore named(map);
  const LooksBefore looks(map);
  const PosesBefore poses(map);
  FusionResult fused = FusePairs(std::move(map.planes), map.edges, map.keyframes, pairs,
                                 map.info.feature_type, options);
  map.planes = std::move(fused.planes);
  map.edges = std::move(fused.edges);
  named.KeepNames(map, fused.merged_into);
  report.planes_fused = fused.fused;
  report.surfaces_joined = fused.joined;
  for (Plane& plane : map.planes) {
    if (plane.features.size() == feature_count.at(plane.id)) continue;
    DropSparseFeatures(options.plenty_of_features, options.votes_in_plenty, plane);
  }
  OutlinePlanes(map);
  looks.KeepLooks(map, fused.merged_into);
  poses.KeepPoses(map);
}

FeatureOptions PictureFeatures(const std::vector<MapData>& maps, const BuildOptions& options) {
  FeatureOptions features = options.features;
  features.type = maps.front().info.feature_type;
  return features;
}

// Recognitions of maps[asking] by the maps with these indices; `answering` are the same maps.
std::vector<Recognition> Recognise(const std::vector<MapData>& maps,
                                   const std::vector<size_t>& asked, size_t asking,
                                   const std::vector<AskedMap>& answering,
                                   const std::vector<WalkImage>& images,
                                   const BuildOptions& options) {
  std::vector<Recognition> recognitions;
  std::vector<const AskedMap*> with_keyframes;
  std::vector<size_t> places;  // of their recognitions
  for (const size_t i : asked) {
    Recognition& one = recognitions.emplace_back();
    one.asked = i;
    one.asking = asking;
    if (!maps[i].keyframes.empty()) {
      with_keyframes.push_back(&answering[i]);
      places.push_back(recognitions.size() - 1);
    }
    if (maps[i].appearance && maps[asking].appearance) {
      one.nodes = RecogniseNodes(maps[i], maps[asking], options.appearance.loops,
                                 options.appearance_calibration.query);
    }
  }
  if (with_keyframes.empty() || maps[asking].keyframes.empty()) return recognitions;
  std::vector<std::vector<RecognisedKeyframe>> found =
      RecogniseKeyframes(with_keyframes, maps[asking], images, PictureFeatures(maps, options));
  for (size_t i = 0; i < places.size(); ++i) {
    recognitions[places[i]].keyframes = std::move(found[i]);
  }
  return recognitions;
}

// Describing a picture takes as long as querying a map, so all maps are queried for each picture:
// they are all indexed, in as much memory as the joined map takes when it is calibrated.
std::vector<Recognition> RecogniseEachOther(const std::vector<MapData>& maps,
                                            const BuildOptions& options) {
  std::vector<AskedMap> answering;
  for (const MapData& map : maps) {
    answering.push_back(AskMap(map, {}, {}, options.calibration.localize));
  }
  std::vector<Recognition> recognitions;
  for (size_t asking = 0; asking < maps.size(); ++asking) {
    std::vector<size_t> others;
    for (size_t i = 0; i < maps.size(); ++i) {
      if (i != asking) others.push_back(i);
    }
    std::ranges::move(Recognise(maps, others, asking, answering, {}, options),
                      std::back_inserter(recognitions));
  }
  std::ranges::stable_sort(recognitions, {}, &Recognition::asked);
  return recognitions;
}

// Links recognised keyframes with the nearest ones. `firsts` are the places of the maps' first
// keyframes in the joined map. Returns how many were recognised.
int Link(const std::vector<Recognition>& recognitions, const std::vector<size_t>& firsts,
         MapData& map) {
  std::set<size_t> recognised;
  std::set<KeyframeLink> links(map.links.begin(), map.links.end());
  for (const Recognition& recognition : recognitions) {
    for (const RecognisedKeyframe& one : recognition.keyframes) {
      const size_t asking = firsts[recognition.asking] + one.asking;
      const size_t found = firsts[recognition.asked] + one.found;
      recognised.insert(asking);
      const auto [a, b] = std::minmax(map.keyframes[asking].id, map.keyframes[found].id);
      links.insert({a, b});
    }
  }
  map.links.assign(links.begin(), links.end());
  return static_cast<int>(recognised.size());
}

// Plans are anchored in the frame of their map: those of maps whose frame isn't kept are removed.
// Returns their names.
std::vector<std::string> LeavePlansOut(size_t kept, std::vector<MapData>& maps) {
  std::vector<std::string> left_out;
  for (size_t i = 0; i < maps.size(); ++i) {
    if (i == kept) continue;
    for (const FloorPlanImage& plan : maps[i].floor_plans) left_out.push_back(plan.name);
    maps[i].floor_plans.clear();
  }
  return left_out;
}

// Where the contents of each map begin in the joined map.
struct Firsts {
  std::vector<size_t> keyframes;
  std::vector<size_t> nodes;
  std::vector<SequenceId> sequences;
};

int CountRecognisedNodes(const std::vector<Recognition>& recognitions) {
  std::set<std::pair<size_t, size_t>> recognised;
  for (const Recognition& recognition : recognitions) {
    for (const RecognisedNode& one : recognition.nodes) {
      recognised.emplace(recognition.asking, one.asking);
    }
  }
  return static_cast<int>(recognised.size());
}

// Appends all maps to the first.
MapData AppendAll(std::vector<MapData> maps, MapOfPlane& origin, Firsts& firsts) {
  MapData map;
  for (size_t i = 0; i < maps.size(); ++i) {
    const size_t sequences = map.sequences.size();
    const size_t planes = map.planes.size();
    firsts.keyframes.push_back(map.keyframes.size());
    firsts.nodes.push_back(map.appearance ? map.appearance->nodes.size() : 0);
    if (i == 0) {
      map = std::move(maps.front());
    } else {
      AppendMap(std::move(maps[i]), map);
      if (planes < map.planes.size()) origin.StartMap(map.planes[planes].id);
    }
    if (sequences < map.sequences.size()) firsts.sequences.push_back(map.sequences[sequences].id);
  }
  return map;
}

// Whether `has` is true for several maps.
template <class Has>
bool SeveralHave(const std::vector<MapData>& maps, const Has& has) {
  return std::ranges::count_if(maps, has) > 1;
}

// One after the other.
JoinResult Join(std::vector<MapData> maps, std::vector<Recognition> recognitions,
                const std::string& name, bool keep_first, const BuildOptions& options) {
  const std::optional<size_t> frame_of = JoinFrames(recognitions, keep_first, maps);
  JoinResult result;
  JoinReport& report = result.report;
  if (frame_of) report.floor_plans = LeavePlansOut(*frame_of, maps);
  const std::vector<NodeTie> ties = JoinAppearance(recognitions, options.appearance, maps);
  const ChangedLayers changed{
      SeveralHave(maps, [](const MapData& map) { return !map.keyframes.empty(); }),
      SeveralHave(maps, [](const MapData& map) { return map.appearance.has_value(); })};
  const bool join_orientation =
      SeveralHave(maps, [](const MapData& map) { return map.orientation.has_value(); });
  MapOfPlane origin;
  Firsts firsts;
  result.map = AppendAll(std::move(maps), origin, firsts);
  result.map.info.name = name;
  report.keyframes_recognised = Link(recognitions, firsts.keyframes, result.map);
  report.panoramas_recognised = CountRecognisedNodes(recognitions);
  report.loops = static_cast<int>(ties.size());
  AddTies(ties, firsts.nodes, result.map);
  if (join_orientation) {
    const OrientationJoin joined = JoinOrientation(recognitions, firsts.nodes, firsts.sequences,
                                                   options.orientation, result.map);
    report.orientation_loops = joined.loops;
    report.sequences_turned = joined.sequences_turned;
  }
  Fuse(origin, options.planes, result.map, report);
  CompleteJoined(options, changed, result.map);
  report.sessions = static_cast<int>(SessionsOf(result.map).size());
  return result;
}

}  // namespace

JoinResult MergeMaps(std::vector<MapData> maps, const std::string& name,
                     const BuildOptions& options) {
  options.Check();
  CheckJoinable(maps);
  std::ranges::stable_sort(maps, {}, [](const MapData& map) { return map.info.version; });
  std::vector<Recognition> recognitions = RecogniseEachOther(maps, options);
  return Join(std::move(maps), std::move(recognitions), name, false, options);
}

JoinResult AddToMap(MapData map, MapData added, const BuildOptions& options,
                    const std::vector<WalkImage>& images) {
  options.Check();
  const std::string name = map.info.name;
  std::vector<MapData> maps;
  maps.push_back(std::move(map));
  maps.push_back(std::move(added));
  CheckJoinable(maps);
  std::vector<Recognition> recognitions;
  LookCounts looked;
  {
    const std::vector<AskedMap> asked{
        AskMap(maps[0], maps[1], images, options.calibration.localize)};
    recognitions = Recognise(maps, {0}, 1, asked, images, options);
    looked = LookAgain(asked.front(), maps[1], images, maps[0]);
  }
  JoinResult result = Join(std::move(maps), std::move(recognitions), name, true, options);
  result.report.features_looked_for = looked.looked;
  result.report.features_found = looked.found;
  return result;
}

}  // namespace waystone
