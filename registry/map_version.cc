// SPDX-License-Identifier: Apache-2.0
#include "registry/map_version.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <set>
#include <utility>

#include "api/map_json.h"
#include "api/overview_json.h"
#include "api/query_request_json.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/file/map_store.h"
#include "schema/file/sha256.h"

namespace waystone {
namespace {

constexpr size_t kMaxMapNameBytes = 100;

std::string UtcNow() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

// Whether JSON keeps the text as it is: invalid bytes would become U+FFFD.
bool IsUtf8(const std::string& text) { return ToUtf8(text) == text; }

Json PlaceNamesJson(const MapData& map) {
  std::set<std::string> names;
  for (const NamedPlace& place : map.names) names.insert(place.name);
  Json list = Json::array();
  for (const std::string& name : names) list.push_back(name);
  return list;
}

// The smallest box around points of one length.
class BoundingBox {
 public:
  void Add(const Eigen::VectorXd& point) {
    min_ = empty_ ? point : Eigen::VectorXd(min_.cwiseMin(point));
    max_ = empty_ ? point : Eigen::VectorXd(max_.cwiseMax(point));
    empty_ = false;
  }
  Json ToJson(const std::string& frame, const Json& metres_per_unit) const {
    if (empty_) return nullptr;
    return {{"frame", frame},
            {"metres_per_unit", metres_per_unit},
            {"min", std::vector<double>(min_.begin(), min_.end())},
            {"max", std::vector<double>(max_.begin(), max_.end())}};
  }

 private:
  bool empty_ = true;
  Eigen::VectorXd min_;
  Eigen::VectorXd max_;
};

Json BoundsJson(const MapData& map) {
  BoundingBox box;
  if (map.poses) {
    for (const KeyframePose& pose : map.poses->keyframes) box.Add(pose.position);
    const bool metric = map.poses->unit == LengthUnit::kMetres;
    return box.ToJson(map.poses->frame, metric ? Json(1.0) : Json(nullptr));
  }
  if (!map.appearance) return nullptr;
  for (const AppearanceNode& node : map.appearance->nodes) {
    box.Add(Eigen::Vector2d(node.pose.x, node.pose.y));
  }
  return box.ToJson("appearance", OrNull(map.appearance->metres_per_unit));
}

std::vector<double> NumbersIn(const Json& list) {
  std::vector<double> numbers;
  if (!list.is_array()) return numbers;
  for (const Json& one : list) {
    if (one.is_number()) numbers.push_back(one.get<double>());
  }
  return numbers;
}

}  // namespace

std::string Describe(const MapVersion& version) {
  return version.name + ", version " + std::to_string(version.number);
}

MapVersion MakeVersion(const std::string& name, const MapIndex& index, int64_t bytes,
                       std::vector<std::string> tags, const std::optional<CoarseFile>& coarse) {
  CheckMapName(name);
  CheckTags(tags);
  tags = SortedTags(std::move(tags));
  const MapData& map = index.map();
  Json details = {
      {"schema_version", kSchemaVersion}, {"feature_type", NameOf(map.info.feature_type)},
      {"layers", LayersJson(map)},        {"places", PlaceNamesJson(map)},
      {"bounds", BoundsJson(map)},        {"tags", tags},
      {"published_at", UtcNow()},         {"publisher", HostName()},
      {"summary", MapJson(name, index)}};
  if (coarse) details["coarse"] = {{"sha256", coarse->sha256}, {"bytes", coarse->bytes}};
  return {name, 0, map.info.version, bytes, Dump(details)};
}

std::string HostName() {
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return "unknown";
  return name.data();
}

void CheckTags(const std::vector<std::string>& tags) {
  for (const std::string& tag : tags) {
    if (!tag.empty() && tag.size() <= kMaxMapNameBytes && Printable(tag) == tag && IsUtf8(tag)) {
      continue;
    }
    throw MapError(ErrorCode::kUsage, "tag '" + Printable(tag).substr(0, 2 * kMaxMapNameBytes) +
                                          "' is not allowed; use 1 to " +
                                          std::to_string(kMaxMapNameBytes) +
                                          " bytes of UTF-8 without control characters");
  }
}

std::vector<std::string> SortedTags(std::vector<std::string> tags) {
  std::ranges::sort(tags);
  // Not std::ranges::unique, whose subrange clang 14 doesn't read.
  tags.erase(std::unique(tags.begin(), tags.end()), tags.end());
  return tags;
}

void CheckMapName(const std::string& name) {
  const bool good = !name.empty() && name.size() <= kMaxMapNameBytes && name[0] != '.' &&
                    name.find('/') == std::string::npos && Printable(name) == name && IsUtf8(name);
  if (good) return;
  throw MapError(ErrorCode::kUsage,
                 "'" + Printable(name).substr(0, 2 * kMaxMapNameBytes) +
                     "' can't be the name of a map in a registry; use 1 to " +
                     std::to_string(kMaxMapNameBytes) +
                     " bytes of UTF-8 without slashes, control characters and a dot in front "
                     "(--name)");
}

std::string ManifestOf(const MapVersion& version) {
  std::string text = Dump({{"name", version.name},
                           {"version", version.number},
                           {"sha256", version.sha256},
                           {"bytes", version.bytes}});
  text.pop_back();  // the details are some kilobytes of JSON already
  return text + ",\"details\":" + version.details + "}";
}

MapVersion ReadManifest(const std::string& text, const std::string& where) {
  try {
    const Json json = ParseJson(text, kAnswerBounds);
    MapVersion version{json.at("name").get<std::string>(), json.at("version").get<int>(),
                       json.at("sha256").get<std::string>(), json.at("bytes").get<int64_t>(),
                       Dump(json.at("details"))};
    CheckMapName(version.name);
    const bool sound = version.number >= 1 && IsSha256(version.sha256) && version.bytes > 0 &&
                       json["details"].at("summary").is_object();
    if (sound) return version;
  } catch (const Json::exception&) {  // reported below
  } catch (const MapError&) {
  }
  throw MapError(ErrorCode::kFileUnreadable,
                 where +
                     " is not the manifest of a map version; restore it from a backup of the "
                     "registry, or publish the map again");
}

Json SummaryOf(const MapVersion& version) { return Json::parse(version.details)["summary"]; }

MapTraits TraitsOf(const MapVersion& version) {
  MapTraits traits;
  const Json details = Json::parse(version.details);
  for (const Json& tag : details.value("tags", Json::array())) {
    if (tag.is_string()) traits.tags.push_back(tag.get<std::string>());
  }
  traits.tags = SortedTags(std::move(traits.tags));  // earlier programs didn't sort them
  const Json bounds = details.value("bounds", Json());
  if (bounds.is_object() && bounds.value("frame", Json()).is_string()) {
    traits.min = NumbersIn(bounds.value("min", Json()));
    traits.max = NumbersIn(bounds.value("max", Json()));
    const bool sound = traits.min.size() == traits.max.size() && !traits.min.empty();
    if (sound) traits.frame = bounds["frame"].get<std::string>();
  }
  const Json coarse = details.value("coarse", Json());
  if (coarse.is_object() && coarse.value("sha256", Json()).is_string() &&
      coarse.value("bytes", Json()).is_number_integer()) {
    const CoarseFile file{coarse["sha256"].get<std::string>(), coarse["bytes"].get<int64_t>()};
    if (IsSha256(file.sha256) && file.bytes > 0) traits.coarse = file;
  }
  return traits;
}

bool HasLayer(const MapVersion& version, const std::string& layer) {
  const Json layers = Json::parse(version.details).value("layers", Json::array());
  return std::ranges::count(layers, Json(layer)) > 0;
}

}  // namespace waystone
