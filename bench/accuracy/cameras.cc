// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <iterator>
#include <sstream>

#include "bench/accuracy/common.h"
#include "bench/accuracy/image_changes.h"
#include "bench/accuracy/recall_sets.h"
#include "bench/accuracy/world_source.h"
#include "bench/baseline/vote_search.h"
#include "core/base/error.h"
#include "core/image/decode.h"
#include "localizer/planes/locate.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct CameraArgs {
  fs::path data;
  std::string only;  // part of the sets' names
  int foreign = 20;  // photos of other places asked of each map, with each change
};

// A map, and plain image search over the same keyframes.
struct CameraPeers {
  std::shared_ptr<const MapIndex> index;
  std::vector<int> frames;  // of the images that are searched
  std::unique_ptr<VoteSearch> search;
};

// The map's frame that a method named for each query, or nothing.
struct Named {
  std::vector<std::optional<int>> waystone;
  std::vector<std::optional<int>> search;
};

using IsRight = std::function<bool(int query, int frame)>;

CameraPeers BuildPeers(std::unique_ptr<Source> source,
                       const std::function<cv::Mat(int frame)>& image_of) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::move(source));
  BuildOptions options;
  options.images = false;
  CameraPeers peers;
  peers.index = MapIndex::Build(BuildMap(sources, options, {}).map);
  for (const Keyframe& keyframe : peers.index->map().keyframes) {
    peers.frames.push_back(keyframe.frame);
  }
  std::vector<Features> images(peers.frames.size());
  tbb::parallel_for(size_t{0}, images.size(), [&](size_t i) {
    images[i] = ExtractFeatures(image_of(peers.frames[i]), options.features);
  });
  peers.search = std::make_unique<VoteSearch>(std::move(images), 0);
  return peers;
}

Named AskBoth(const CameraPeers& peers, const std::vector<cv::Mat>& photos,
              const ImageChange& change) {
  Named named{std::vector<std::optional<int>>(photos.size()),
              std::vector<std::optional<int>>(photos.size())};
  const FeatureOptions features = QueryFeatureOptions(*peers.index, {});
  tbb::parallel_for(size_t{0}, photos.size(), [&](size_t q) {
    Random random(q + 1);
    const cv::Mat photo = change.apply(photos[q], random);
    const Answer answer = LocalizeImage(*peers.index, photo, {});
    if (answer.verdict == Verdict::kLocalized) {
      named.waystone[q] = peers.index->FindKeyframe(answer.planes.keyframe->id)->frame;
    }
    if (const auto found = peers.search->Find(ExtractFeatures(photo, features))) {
      named.search[q] = peers.frames[found->image];
    }
  });
  return named;
}

int CountNamed(const std::vector<std::optional<int>>& named) {
  return static_cast<int>(
      std::ranges::count_if(named, [](const auto& n) { return n.has_value(); }));
}

int CountRight(const std::vector<std::optional<int>>& named, const IsRight& is_right) {
  int right = 0;
  for (size_t q = 0; q < named.size(); ++q) {
    right += named[q] && is_right(static_cast<int>(q), *named[q]);
  }
  return right;
}

// One row: how many of a map's own photos both found after a change, and how many foreign ones.
Json MakeRow(const std::string& change, const Named& own, const Named& others,
             const IsRight& is_right) {
  const size_t asked = own.waystone.size();
  const size_t foreign = others.waystone.size();
  Json row{{"name", change},
           {"asked", asked},
           {"localized", CountNamed(own.waystone)},
           {"right", CountRight(own.waystone, is_right)},
           {"search_found", CountNamed(own.search)},
           {"search_right", CountRight(own.search, is_right)},
           {"foreign", foreign},
           {"foreign_localized", CountNamed(others.waystone)},
           {"search_foreign", CountNamed(others.search)}};
  std::printf(
      "  %-32s localized %2d, right %2d; image search found %2d, right %2d, of %zu; foreign "
      "%d and %d of %zu\n",
      change.c_str(), row["localized"].get<int>(), row["right"].get<int>(),
      row["search_found"].get<int>(), row["search_right"].get<int>(), asked,
      row["foreign_localized"].get<int>(), row["search_foreign"].get<int>(), foreign);
  (void)std::fflush(stdout);
  return row;
}

std::vector<cv::Mat> ReadAll(const std::vector<fs::path>& images) {
  std::vector<cv::Mat> photos;
  photos.reserve(images.size());
  for (const fs::path& image : images) photos.push_back(DecodeGrey(ReadBytes(image)));
  return photos;
}

Json MeasureSet(const RecallSet& set, const std::vector<fs::path>& foreign) {
  std::printf("%s\n", set.name.c_str());
  const CameraPeers peers = BuildPeers(
      OpenRecallMap(set), [&](int frame) { return DecodeGrey(ReadBytes(set.map[frame])); });
  const std::vector<cv::Mat> photos = ReadAll(set.queries);
  const std::vector<cv::Mat> others = ReadAll(foreign);
  Json rows = Json::array();
  for (const ImageChange& change : ImageChanges()) {
    rows.push_back(MakeRow(change.name, AskBoth(peers, photos, change),
                           AskBoth(peers, others, change), set.is_right));
  }
  return {{"name", set.name}, {"rows", rows}};
}

// A rendered building, where the query's lens can be any: the same poses, by cameras of other focal
// lengths on a sensor of the map's size.
class Building {
 public:
  explicit Building(int number)
      : options_(OptionsOf(number)),
        world_(number % 2 == 0 ? DemoPlan() : OtherPlan(), options_),
        mapped_(MapWalk(world_.plan())),
        asked_(QueryWalk(world_.plan())) {
    const WorldSource rendered(world_, renderer_, mapped_);
    peers_ = BuildPeers(std::make_unique<WorldSource>(world_, renderer_, mapped_),
                        [&](int frame) { return rendered.Render(frame).grey; });
  }

  // A row, with the sum of the distances, in metres, of queries from the keyframes named for them.
  Json Ask(double focal_factor) const {
    const double half = std::tan(kFieldOfView_rad / 2) / focal_factor;
    const Renderer lens(PinholeCamera(kWidth, kHeight, 2 * std::atan(half)));
    const WorldSource queries(world_, lens, asked_);
    std::vector<cv::Mat> photos(asked_.frames.size());
    tbb::parallel_for(size_t{0}, photos.size(),
                      [&](size_t q) { photos[q] = queries.Render(static_cast<int>(q)).grey; });
    std::ostringstream name;
    name << focal_factor << " times the focal length";
    const ImageChange nothing{name.str(), [](const cv::Mat& grey, Random&) { return grey; }};
    const Named named = AskBoth(peers_, photos, nothing);
    Json row = MakeRow(nothing.name, named, {},
                       [&](int query, int frame) { return IsNear(query, frame); });
    row["metres"] = AddDistances(named.waystone);
    row["search_metres"] = AddDistances(named.search);
    return row;
  }

 private:
  static constexpr double kFieldOfView_rad = 1.2;  // of the map's camera
  static constexpr int kWidth = 640;
  static constexpr int kHeight = 480;
  static constexpr int kQueries = 30;

  static WorldOptions OptionsOf(int number) {
    WorldOptions options;
    options.seed = 41 + number;
    return options;
  }
  static Walk MapWalk(const FloorPlan& plan) {
    WalkOptions options;
    options.step_m = 0.1;
    return DemoWalk(plan, options);
  }
  static Walk QueryWalk(const FloorPlan& plan) {
    WalkOptions options;
    options.height_m = 1.6;
    options.gaze_rad = 0.5;
    options.gaze_period_m = 5;
    options.seed = 7;
    return SpreadOver(DemoWalk(plan, options), kQueries);
  }

  Eigen::Isometry3d QueryFromFrame(int query, int frame) const {
    return asked_.frames[query].world_from_camera.inverse() *
           mapped_.frames[frame].world_from_camera;
  }

  double AddDistances(const std::vector<std::optional<int>>& named) const {
    double sum_m = 0;
    for (size_t q = 0; q < named.size(); ++q) {
      if (named[q]) sum_m += QueryFromFrame(static_cast<int>(q), *named[q]).translation().norm();
    }
    return sum_m;
  }

  bool IsNear(int query, int frame) const {
    constexpr double kNear_m = 2.0;
    constexpr double kMaxAngle_rad = 0.7;
    const Eigen::Isometry3d moved = QueryFromFrame(query, frame);
    return moved.translation().norm() <= kNear_m &&
           Eigen::AngleAxisd(moved.linear()).angle() <= kMaxAngle_rad;
  }

  WorldOptions options_;
  World world_;
  Renderer renderer_{PinholeCamera(kWidth, kHeight, kFieldOfView_rad)};
  Walk mapped_;
  Walk asked_;
  CameraPeers peers_;
};

Json MeasureLenses(int buildings) {
  constexpr double kFactors[] = {0.6, 0.8, 1.0, 1.25, 1.6};
  std::printf("lenses\n");
  Json rows = Json::array();
  for (int number = 0; number < buildings; ++number) {
    const Building building(number);
    for (size_t f = 0; f < std::size(kFactors); ++f) {
      const Json row = building.Ask(kFactors[f]);
      if (number == 0) {
        rows.push_back(row);
        continue;
      }
      for (const char* field : {"asked", "localized", "right", "search_found", "search_right"}) {
        rows[f][field] = rows[f][field].get<int>() + row[field].get<int>();
      }
      for (const char* field : {"metres", "search_metres"}) {
        rows[f][field] = rows[f][field].get<double>() + row[field].get<double>();
      }
    }
  }
  for (Json& row : rows) {
    row["mean_m"] = row["metres"].get<double>() / std::max(1, row["localized"].get<int>());
    row["search_mean_m"] =
        row["search_metres"].get<double>() / std::max(1, row["search_found"].get<int>());
  }
  return {{"name", "lenses"}, {"rows", rows}};
}

// Foreign photos of all sets, change by change.
Json SumForeign(const Json& sets) {
  Json sums = Json::array();
  for (const Json& set : sets) {
    for (size_t i = 0; i < set["rows"].size(); ++i) {
      const Json& row = set["rows"][i];
      if (sums.size() == i) {
        sums.push_back({{"name", row["name"]}, {"asked", 0}, {"localized", 0}, {"search", 0}});
      }
      sums[i]["asked"] = sums[i]["asked"].get<int>() + row["foreign"].get<int>();
      sums[i]["localized"] = sums[i]["localized"].get<int>() + row["foreign_localized"].get<int>();
      sums[i]["search"] = sums[i]["search"].get<int>() + row["search_foreign"].get<int>();
    }
  }
  return sums;
}

CameraArgs ParseCameraArgs(const Args& raw) {
  Args args = raw;
  CameraArgs parsed;
  parsed.only = TakeOption(args, "only", "");
  parsed.foreign = std::stoi(TakeOption(args, "foreign", "20"));
  if (args.size() > 1) {
    throw MapError(ErrorCode::kUsage, "cameras takes a folder with data, --only NAME, --foreign N");
  }
  parsed.data = args.empty() ? fs::path(WAYSTONE_SOURCE_DIR) / "../shared/data" : fs::path(args[0]);
  return parsed;
}

}  // namespace

int RunCameras(const Args& raw) {
  constexpr int kBuildings = 4;
  const CameraArgs args = ParseCameraArgs(raw);
  const std::vector<RecallSet> sets = ReadRecallSets(args.data);
  Json json{{"bench", "cameras"}, {"sets", Json::array()}};
  const auto wanted = [&](const std::string& name) {
    return name.find(args.only) != std::string::npos;
  };
  for (const RecallSet& set : sets) {
    const bool of_other_light = set.name == "pavilion-sunset" || set.name == "pavilion-night";
    if (!wanted(set.name) || of_other_light || set.name.starts_with("tower")) continue;
    json["sets"].push_back(MeasureSet(set, ChooseForeign(sets, set, args.foreign)));
  }
  json["foreign"] = SumForeign(json["sets"]);
  if (wanted("lenses")) json["sets"].push_back(MeasureLenses(kBuildings));
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
