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

// The single entry point to the localizer: command line, server, replay and watch use it, so that
// the same query of the same maps gets the same answer from each.
namespace waystone {

// A map that is queried, with its name in answers.
struct QueriedMap {
  std::string name;
  std::shared_ptr<const MapIndex> index;
};

// Localizes the panoramas of one robot in their order, each with what those before it showed. Not
// thread-safe.
class Series {
 public:
  // `previous`: the belief before the first one. The map has an appearance layer (WS_CHECK).
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

// The answers of one or more maps to a request with one or more images.
struct RequestAnswer {
  // For each image, in order, the answers of the maps, best first: localized before ambiguous
  // before not in the map, more probable before less.
  std::vector<std::vector<Answer>> images;
  size_t best = 0;  // the image whose answer counts: the one with the best of all, or of a series
                    // the last one
  bool series = false;         // whether the images were answered as a series
  bool used_previous = false;  // whether it began with the request's previous answer
  bool used_camera = false;    // whether any part of the map uses the photo's camera
  // The probability required of a panorama's place.
  double min_panorama_probability = PanoramaQueryOptions{}.min_probability;
  // The belief for the next panorama, rounded as clients keep it; nothing where there is none.
  std::optional<std::vector<NodeBelief>> belief;
};

// Joins the answers of several lots of maps (at least one) to the same images. Thread-safe.
RequestAnswer Joined(std::vector<RequestAnswer> lots);

// The best answer of all, as one map's answer. When several maps recognised the place, the verdict
// is ambiguous, `planes.places` are the keyframes of all of them (a panorama's place has none), and
// what holds for only one of them is left out. A map with several similar places counts as
// recognising where its best place by itself is as probable as a localized one has to be.
// Thread-safe.
Answer OverallAnswer(const RequestAnswer& answer);

// One request while it is answered. Immutable except for its progress; one thread calls Ask().
class Session {
 public:
  // Resolves what the request refers to in the maps. Its deadline counts from when it was received,
  // or from here. Throws MapError: kBadCamera as ResolveCamera, and kBadRequest for a prior
  // keyframe that the map doesn't have. There is at least one map and one image (WS_CHECK); camera,
  // prior, previous and odometry need a single map. `is_lot`: other maps are queried in other
  // sessions, so a single one isn't the only one.
  Session(QueryRequest request, std::vector<QueriedMap> maps, const LocalizeOptions& options,
          bool is_lot = false);

  const QueryRequest& request() const { return request_; }
  const std::optional<QueryCamera>& camera() const { return camera_; }
  const Deadline& deadline() const { return options_.deadline; }

  // Queries every map with every image. Each image is a query of its own, except for panoramas with
  // a single map that has an appearance layer: several, or one with a previous answer's belief,
  // form a series of one robot in their order. Several that may also be photos (MayBePhoto) form
  // one only with odometry or such a belief. A previous answer of another version of the map isn't
  // used. Throws MapError(kBadRequest) for a belief that can't come from the map.
  RequestAnswer Ask() const;

  // The answer for a deadline that passes while the request waits for its turn, or while Ask() is
  // in a stage that can't be interrupted: undecided, with the last finished stage. Any thread, also
  // while another one is in Ask().
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
