// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "localizer/index/map_index.h"
#include "localizer/options.h"
#include "localizer/query.h"
#include "localizer/verdict/answer.h"

// The one door to the localizer: command line, server, replay and watch ask through it, so that the
// same query of the same maps gets the same answer from each.
namespace waystone {

// A map that is asked, by the name that answers give it.
struct QueriedMap {
  std::string name;
  std::shared_ptr<const MapIndex> index;
};

// Panoramas of one robot in their order, each asked with what those before it showed.
class Series {
 public:
  // `previous`: what was believed before the first one. The map has an appearance layer (WS_CHECK).
  Series(QueriedMap map, LocalizeOptions options, FilterState previous = {});

  // The next one, with the motion since the one before, in the layer's units, where it is known. An
  // image that can't be decoded or described is answered kBadImage and leaves the belief as it was.
  Answer Ask(const QueryImage& image, const std::optional<Pose2>& odometry = {});

  const FilterState& belief() const { return belief_; }

 private:
  QueriedMap map_;
  LocalizeOptions options_;
  FilterState belief_;
  std::optional<FourierSignature> described_;  // the panorama before
};

// The answers to a request with one or more images, asked of one or more maps.
struct RequestAnswer {
  // For each image in its order the answers of the maps, best first: localized before ambiguous
  // before not in the map, more probable before less.
  std::vector<std::vector<Answer>> images;
  size_t best = 0;  // the image whose answer counts: the one with the best of all, or of a series
                    // the last one
  bool series = false;         // whether the images were one
  bool used_previous = false;  // and began with the request's previous answer
  bool used_camera = false;    // whether anything of the map takes the photo's camera
  // What the maps were asked to require of a panorama's place.
  double min_panorama_probability = PanoramaQueryOptions{}.min_probability;
  // What the next panorama is asked with, rounded as clients keep it; nothing without.
  std::optional<std::vector<NodeBelief>> belief;
};

// The answers of the same images by several lots of maps as one; at least one.
RequestAnswer Joined(std::vector<RequestAnswer> lots);

// The best answer of all, as one map's answer. When several maps recognised the place, the verdict
// is ambiguous, `planes.places` are the keyframes of all of them (a panorama's place has none), and
// what only one of them says of the place is left out. A map that found several places alike
// recognised it where the best of them, taken alone, is as probable as a localized one has to be.
Answer OverallAnswer(const RequestAnswer& answer);

// One request while it is answered. Immutable but for how far it is; one thread asks.
class Session {
 public:
  // Resolves what the request says about the maps. Its deadline counts from when it was received,
  // or from here. Throws MapError: kBadCamera as ResolveCamera, and kBadRequest for a prior
  // keyframe that the map doesn't have. There is a map and an image (WS_CHECK); camera, prior,
  // previous and odometry need a single map. `is_lot`: other maps are asked in other sessions, and
  // a single one isn't the only one.
  Session(QueryRequest request, std::vector<QueriedMap> maps, const LocalizeOptions& options,
          bool is_lot = false);

  const QueryRequest& request() const { return request_; }
  const std::optional<QueryCamera>& camera() const { return camera_; }
  const Deadline& deadline() const { return options_.deadline; }

  // Asks every image of every map. Each image is a query of its own, but for panoramas asked of one
  // map that has an appearance layer: several, or one with a previous answer's belief, are a series
  // of one robot in their order. Several that may be photos as well (MayBePhoto) need odometry or
  // such a belief to be one. A previous answer of another version of the map isn't used. Throws
  // MapError(kBadRequest) for a belief that the map can't have given.
  RequestAnswer Ask() const;

  // What is answered when the deadline passes while the request waits for its turn, or while Ask()
  // is in a stage that can't be interrupted: undecided, with the last stage that was finished. Any
  // thread, also while another one asks.
  RequestAnswer TimeOut() const;

 private:
  bool AsksOnePanoramaMap() const;
  bool HasPhotos() const;  // of one panorama map
  bool MayHavePhotos() const;
  std::vector<Answer> AskMaps(const QueryImage& image) const;
  RequestAnswer AskSeries(const std::optional<FilterState>& previous) const;
  RequestAnswer AskEach() const;

  QueryRequest request_;
  std::vector<QueriedMap> maps_;
  LocalizeOptions options_;
  bool is_lot_;
  std::optional<QueryCamera> camera_;
};

}  // namespace waystone
