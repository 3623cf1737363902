// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/recall_sets.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "bench/accuracy/common.h"
#include "bench/accuracy/oriented_set.h"
#include "bench/accuracy/rgbd_truth.h"
#include "bench/baseline/scenes.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "core/image/decode.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;
using Cells = std::vector<std::string>;

constexpr int kCorridorFrames = 4;  // within which a corridor's answer is right
constexpr int kTowerFrames = 4;     // the same, in frames of a floor's video
constexpr double kMaxAngle_rad = std::numbers::pi / 6;
constexpr double kKitchen_m = 1.5;
constexpr double kChurch_m = 15;
constexpr double kPavilion_m = 2.0;
constexpr double kRigPlaces_m = 5.0;
constexpr double kLevel = 0.5;  // a camera's axis is at most as steep

struct Viewpoint {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d ahead = Eigen::Vector3d::Zero();
};

bool IsNear(const Viewpoint& a, const Viewpoint& b, double max_m) {
  return (a.centre - b.centre).norm() <= max_m && a.ahead.dot(b.ahead) >= std::cos(kMaxAngle_rad);
}

Viewpoint ViewpointOf(const PosedCamera& camera) {
  return {camera.centre, camera.world_from_camera.col(2)};
}

RecallSet ReadCorridor(const fs::path& folder) {
  RecallSet set{"corridor", ImagesIn(folder / "map"), ImagesIn(folder / "query"), {}, {}};
  std::map<std::string, int> frames;
  for (size_t i = 0; i < set.map.size(); ++i) frames[set.map[i].filename()] = static_cast<int>(i);
  std::map<std::string, int> nearest;
  for (const Cells& row : ReadCsv(folder / "truth.csv")) nearest[row.at(0)] = frames.at(row.at(1));
  std::vector<int> truth;
  for (const fs::path& query : set.queries) truth.push_back(nearest.at(query.filename()));
  set.is_right = [truth](int query, int frame) {
    return std::abs(truth[query] - frame) <= kCorridorFrames;
  };
  return set;
}

RecallSet ReadKitchen(const fs::path& folder) {
  constexpr int kMapFrames = 500;
  constexpr int kStep = 10;  // of the queries
  const RgbdTruth truth(folder);
  RecallSet set{"kitchen", {}, {}, {}, {}};
  std::vector<Viewpoint> mapped;
  std::vector<Viewpoint> asked;
  for (int i = 0; i < truth.frames(); ++i) {
    const Eigen::Isometry3d& pose = truth.world_from_camera(i);
    const Viewpoint view{pose.translation(), pose.linear().col(2)};
    if (i < kMapFrames) {
      set.map.push_back(folder / truth.image(i));
      mapped.push_back(view);
    } else if (i % kStep == 0) {
      set.queries.push_back(folder / truth.image(i));
      asked.push_back(view);
    }
  }
  set.is_right = [mapped, asked](int query, int frame) {
    return IsNear(asked[query], mapped[frame], kKitchen_m);
  };
  return set;
}

RecallSet ReadChurch(const fs::path& folder) {
  RecallSet set{"church", ImagesIn(folder / "map"), ImagesIn(folder / "query_P8"), {}, {}};
  std::map<std::string, Viewpoint> views;
  for (const PhotoPose& photo : ReadPhotoPoses(folder)) {
    views[photo.image] = ViewpointOf(photo.camera);
  }
  std::vector<Viewpoint> mapped;
  std::vector<Viewpoint> asked;
  for (const fs::path& image : set.map) mapped.push_back(views.at(image.filename()));
  for (const fs::path& image : set.queries) asked.push_back(views.at(image.filename()));
  set.is_right = [mapped, asked](int query, int frame) {
    return IsNear(asked[query], mapped[frame], kChurch_m);
  };
  return set;
}

RecallSet ReadPavilion(const fs::path& folder, const std::string& light) {
  RecallSet set{"pavilion-" + light, {}, {}, {}, {}};
  std::vector<Viewpoint> mapped;
  std::vector<Viewpoint> asked;
  for (const PhotoPose& photo : ReadPhotoPoses(folder)) {
    const fs::path image = folder / photo.image;
    if (photo.role == "map") {
      set.map.push_back(image);
      mapped.push_back(ViewpointOf(photo.camera));
    } else if (photo.role == "query" && image.parent_path().filename() == light) {
      set.queries.push_back(image);
      asked.push_back(ViewpointOf(photo.camera));
    }
  }
  set.is_right = [mapped, asked](int query, int frame) {
    return IsNear(asked[query], mapped[frame], kPavilion_m);
  };
  return set;
}

std::vector<RecallSet> ReadTower(const fs::path& folder) {
  const std::vector<Cells> rows = ReadCsv(folder / "frames.csv");
  std::map<std::string, RecallSet> sets;
  std::map<std::string, std::pair<std::vector<int>, std::vector<int>>> frames;  // mapped, asked
  for (const Cells& row : rows) sets[row.at(2)].name = "tower-" + row.at(2);
  for (const Cells& row : rows) {
    const fs::path image = folder / row.at(1);
    for (auto& [floor, set] : sets) {
      if (floor != row.at(2)) set.look_alikes.push_back(image);
    }
    const bool mapped = row.at(0) == "map";
    RecallSet& own = sets.at(row.at(2));
    auto& numbers = frames[row.at(2)];
    (mapped ? own.map : own.queries).push_back(image);
    (mapped ? numbers.first : numbers.second).push_back(std::stoi(row.at(5)));
  }
  std::vector<RecallSet> all;
  for (auto& [floor, set] : sets) {
    set.is_right = [numbers = frames.at(floor)](int query, int frame) {
      return std::abs(numbers.second[query] - numbers.first[frame]) <= kTowerFrames;
    };
    all.push_back(std::move(set));
  }
  return all;
}

}  // namespace

std::unique_ptr<Source> OpenRecallMap(const RecallSet& set) {
  MemorySequence sequence{.name = set.name};
  for (size_t i = 0; i < set.map.size(); ++i) {
    const fs::path path = set.map[i];
    sequence.frames.emplace_back(FrameInfo{static_cast<int>(i), path.filename(), {}},
                                 [path] { return DecodeGrey(ReadBytes(path)); });
  }
  return std::make_unique<MemorySource>(std::move(sequence));
}

std::vector<RecallSet> ReadRecallSets(const fs::path& data) {
  std::vector<RecallSet> sets;
  if (fs::exists(data / "corridor")) sets.push_back(ReadCorridor(data / "corridor"));
  if (fs::exists(data / "kitchen")) sets.push_back(ReadKitchen(data / "kitchen"));
  if (fs::exists(data / "church")) sets.push_back(ReadChurch(data / "church"));
  if (fs::exists(data / "pavilion")) {
    for (const char* light : {"midday", "sunset", "night"}) {
      sets.push_back(ReadPavilion(data / "pavilion", light));
    }
  }
  if (fs::exists(data / "tower")) {
    for (RecallSet& set : ReadTower(data / "tower")) sets.push_back(std::move(set));
  }
  if (sets.empty()) {
    throw MapError(ErrorCode::kFileUnreadable, data.string() + " has none of the sets of photos");
  }
  return sets;
}

RecallSet ReadRigPhotos(const fs::path& folder) {
  const OrientedSet places = OpenOrientedSet(folder);
  std::vector<const RigCamera*> level;
  for (const RigCamera& camera : places.rig.cameras) {
    if (std::abs(camera.rig_from_camera.linear()(1, 2)) < kLevel) level.push_back(&camera);
  }
  RecallSet set{places.name, {}, {}, {}, {}};
  std::vector<Viewpoint> mapped;
  std::vector<Viewpoint> asked;
  const auto add = [&](int place, const RigCamera& camera, std::vector<fs::path>& images,
                       std::vector<Viewpoint>& views) {
    images.push_back(folder / "rig" / places.names[place] / (camera.name + ".jpg"));
    const Eigen::Isometry3d pose = places.world_from_rig[place] * camera.rig_from_camera;
    views.push_back({pose.translation(), pose.linear().col(2)});
  };
  for (const RigCamera* camera : level) {
    for (int i = 0; i < places.size(); i += 2) add(i, *camera, set.map, mapped);
  }
  for (int i = 1; i < places.size(); i += 2) {
    add(i, *level[i / 2 % level.size()], set.queries, asked);
  }
  set.is_right = [mapped, asked](int query, int frame) {
    return IsNear(asked[query], mapped[frame], kRigPlaces_m);
  };
  return set;
}

RecallSet Exchanged(const RecallSet& set, int max_queries) {
  RecallSet exchanged{set.name, set.queries, {}, set.look_alikes, {}};
  const size_t most = std::max(1, max_queries);
  const size_t step = (set.map.size() + most - 1) / most;
  for (size_t i = 0; i < set.map.size(); i += step) exchanged.queries.push_back(set.map[i]);
  exchanged.is_right = [step, is_right = set.is_right](int query, int frame) {
    return is_right(frame, query * static_cast<int>(step));
  };
  return exchanged;
}

std::vector<Features> ExtractAll(const std::vector<fs::path>& images,
                                 const FeatureOptions& options) {
  std::vector<Features> features(images.size());
  tbb::parallel_for(size_t{0}, images.size(), [&](size_t i) {
    features[i] = ExtractFeatures(DecodeGrey(ReadBytes(images[i])), options);
  });
  return features;
}

std::vector<fs::path> ChooseForeign(const std::vector<RecallSet>& sets, const RecallSet& own,
                                    int count) {
  const auto place = [](const std::string& name) { return name.substr(0, name.find('-')); };
  std::vector<fs::path> all;
  for (const RecallSet& set : sets) {
    if (place(set.name) == place(own.name)) continue;
    all.insert(all.end(), set.queries.begin(), set.queries.end());
  }
  std::vector<fs::path> chosen;
  const size_t most = std::max(1, count);
  const size_t step = std::max<size_t>(1, (all.size() + most - 1) / most);
  for (size_t i = 0; i < all.size(); i += step) chosen.push_back(all[i]);
  return chosen;
}

}  // namespace waystone::bench
