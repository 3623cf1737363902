// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>

#include "bench/accuracy/common.h"
#include "bench/accuracy/world_source.h"
#include "bench/baseline/scenes.h"
#include "core/base/error.h"
#include "core/image/decode.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kFewest = 20;  // localized answers that a reliability requires

// Photos of one kind, no two of which are the same file or frame.
struct Photos {
  std::string name;
  bool real = true;  // taken by a camera; the others are rendered, as a map's calibration renders
  std::vector<std::function<cv::Mat()>> decode;
};

struct Verdicts {
  int queries = 0;
  int localized = 0;
  int right = 0;
  int ambiguous = 0;
  int outside = 0;  // queries that are not in the map
  int outside_real = 0;
  int false_localized = 0;
  int false_ambiguous = 0;
  int most_inliers = 0;  // of a query that is not in the map
  double stated = 0;     // sum of the probabilities of localized answers, false ones among them

  // What localized answers state, and how many of them are right. Refused ones don't count: their
  // number depends on what is asked, and a refused place of the map can't be checked.
  struct Reliability {
    double stated = 0;
    double observed = 0;
  };
  std::optional<Reliability> Reliable() const {
    const int answers = localized + false_localized;
    if (answers < kFewest) return std::nullopt;
    return Reliability{stated / answers, static_cast<double>(right) / answers};
  }
};

Photos ReadPhotos(const std::string& name, const std::vector<fs::path>& folders, int step) {
  std::vector<fs::path> paths;
  for (const fs::path& folder : folders) {
    const std::vector<fs::path> all = ImagesIn(folder);
    for (size_t i = 0; i < all.size(); i += step) paths.push_back(all[i]);
  }
  Photos photos{name, true, {}};
  for (const fs::path& path : paths) {
    photos.decode.emplace_back([path] { return DecodeGrey(ReadBytes(path), {}); });
  }
  return photos;
}

// Frames of a walk through another building than the demo's.
Photos RenderOther(int count) {
  WorldOptions options;
  options.seed = 2;
  const World world(OtherPlan(), options);
  Walk walk = DemoWalk(world.plan(), {});
  const Renderer renderer(PinholeCamera(640, 480, 1.2));
  const WorldSource source(world, renderer, walk);
  count = std::min(count, source.size());
  std::vector<cv::Mat> pictures(count);
  tbb::parallel_for(0, count, [&](int i) {
    const int frame = static_cast<int>(static_cast<int64_t>(i) * source.size() / count);
    pictures[i] = source.Render(frame).grey;
  });
  Photos photos{"world", false, {}};
  for (const cv::Mat& picture : pictures) {
    photos.decode.emplace_back([picture] { return picture; });
  }
  return photos;
}

void AskScene(const Scene& scene, const MapIndex& index, Verdicts& verdicts) {
  std::vector<Answer> answers(scene.queries());
  tbb::parallel_for(0, scene.queries(), [&](int q) {
    answers[q] = LocalizeImage(index, scene.Decode(q), LocalizeOptions{});
  });
  for (int q = 0; q < scene.queries(); ++q) {
    ++verdicts.queries;
    verdicts.ambiguous += answers[q].verdict == Verdict::kAmbiguous;
    if (answers[q].verdict != Verdict::kLocalized) continue;
    ++verdicts.localized;
    verdicts.right += scene.IsRight(q, SceneAnswerOf(index, answers[q]));
    verdicts.stated += answers[q].probability;
  }
}

void AskOutside(const Photos& photos, const MapIndex& index, Verdicts& verdicts) {
  std::vector<Answer> answers(photos.decode.size());
  tbb::parallel_for(size_t{0}, answers.size(), [&](size_t i) {
    answers[i] = LocalizeImage(index, photos.decode[i](), LocalizeOptions{});
  });
  for (size_t i = 0; i < answers.size(); ++i) {
    const Answer& answer = answers[i];
    ++verdicts.outside;
    verdicts.outside_real += photos.real;
    if (answer.planes.runner_up) {
      verdicts.most_inliers = std::max(verdicts.most_inliers, answer.planes.runner_up->inliers);
    }
    verdicts.false_ambiguous += answer.verdict == Verdict::kAmbiguous;
    if (answer.verdict == Verdict::kLocalized) {
      ++verdicts.false_localized;
      verdicts.stated += answer.probability;
      std::printf("false: %s %zu, %.2f sure, %d inliers\n", photos.name.c_str(), i,
                  answer.probability, CountBestInliers(answer.planes));
    }
  }
}

nlohmann::ordered_json JsonOf(const Verdicts& v) {
  nlohmann::ordered_json reliability;
  if (const auto reliable = v.Reliable()) {
    reliability = {{"stated", reliable->stated},
                   {"observed", reliable->observed},
                   {"gap", std::abs(reliable->stated - reliable->observed)}};
  }
  return {{"queries", v.queries},
          {"localized", v.localized},
          {"right", v.right},
          {"ambiguous", v.ambiguous},
          {"outside", v.outside},
          {"outside_real", v.outside_real},
          {"false_localized", v.false_localized},
          {"false_ambiguous", v.false_ambiguous},
          {"most_inliers_outside", v.most_inliers},
          {"reliability", reliability}};
}

void Print(const std::string& scene, const VerdictModel& model, const Verdicts& v) {
  std::printf("%-10s model %.1f %+.2f log(1+inliers) %+.2f share, from %d right and %d wrong\n",
              scene.c_str(), model.intercept, model.log_inliers, model.inlier_share,
              model.positives, model.negatives);
  std::printf(
      "           %d queries: %d localized, %d right, %d ambiguous; %d from elsewhere: %d "
      "localized, %d ambiguous, most inliers %d\n",
      v.queries, v.localized, v.right, v.ambiguous, v.outside, v.false_localized, v.false_ambiguous,
      v.most_inliers);
  if (const auto reliable = v.Reliable()) {
    std::printf("           localized answers: stated %.3f, right %.3f\n", reliable->stated,
                reliable->observed);
  }
}

// Over the photos that were queried against a map that doesn't show them, each counted once.
nlohmann::ordered_json CountDistinct(const std::vector<Photos>& photos) {
  nlohmann::ordered_json json;
  int real = 0;
  int rendered = 0;
  for (const Photos& each : photos) {
    const int count = static_cast<int>(each.decode.size());
    (each.real ? real : rendered) += count;
    json["of"][each.name] = count;
  }
  json["distinct"] = real + rendered;
  json["real"] = real;
  json["rendered"] = rendered;
  return json;
}

struct Mapped {
  std::unique_ptr<Scene> scene;
  std::vector<std::string> inside;  // photos that show the scene
};

}  // namespace

int RunVerdicts(const Args& raw) {
  if (raw.size() > 1)
    throw MapError(ErrorCode::kUsage, "verdicts wants one folder of data, or none");
  const SceneLimits limits;
  std::vector<Photos> photos;
  photos.push_back(RenderOther(400));
  std::vector<Mapped> maps;
  maps.push_back({MakeWorldScene(400, 200, limits), {}});
  if (!raw.empty()) {
    const fs::path data = raw[0];
    photos.push_back(ReadPhotos("street", {data / "street/image_0"}, 1));
    photos.push_back(ReadPhotos("church", {data / "church/map", data / "church/query_P8"}, 1));
    photos.push_back(ReadPhotos("kitchen", {data / "kitchen/rgb"}, 2));
    photos.push_back(ReadPhotos("york_urban", {data / "york_urban"}, 1));
    photos.push_back(ReadPhotos("dealership", {data / "dealership/rig"}, 1));
    photos.push_back(ReadPhotos("corridor", {data / "corridor"}, 1));
    photos.push_back(ReadPhotos("tower", {data / "tower"}, 1));
    photos.push_back(ReadPhotos("homographies", {data / "homographies"}, 1));
    maps.push_back(
        {OpenRgbdScene(data / "kitchen", {0, 499, 1}, {500, 990, 10}, limits), {"kitchen"}});
    maps.push_back({OpenPhotoScene(data / "church", limits), {"church"}});
  }
  nlohmann::ordered_json json = {{"bench", "verdicts"}};
  int outside = 0;
  int false_localized = 0;
  for (const Mapped& mapped : maps) {
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(mapped.scene->OpenMap());
    const auto index = MapIndex::Build(BuildMap(sources, BuildOptions{}, {}).map);
    Verdicts verdicts;
    AskScene(*mapped.scene, *index, verdicts);
    for (const Photos& from : photos) {
      const bool inside =
          std::find(mapped.inside.begin(), mapped.inside.end(), from.name) != mapped.inside.end();
      if (!inside) AskOutside(from, *index, verdicts);
    }
    Print(mapped.scene->name(), index->map().verdict.value_or(VerdictModel{}), verdicts);
    json[mapped.scene->name()] = JsonOf(verdicts);
    outside += verdicts.outside;
    false_localized += verdicts.false_localized;
  }
  json["photos"] = CountDistinct(photos);
  json["outside"] = outside;
  json["false_localized"] = false_localized;
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
