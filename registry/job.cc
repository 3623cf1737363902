// SPDX-License-Identifier: Apache-2.0
#include "registry/job.h"

#include <algorithm>
#include <exception>

#include "api/json.h"
#include "core/base/error.h"
#include "registry/map_version.h"

namespace waystone {
namespace {

constexpr int kLeastPartFrames = 20;
constexpr int kMostPartFrames = 1'000'000;
constexpr int kMostAttempts = 100;
constexpr int kLeastOverlap = 10;

void CheckRange(const std::string& name, int value, int least, int most) {
  if (value >= least && value <= most) return;
  throw MapError(ErrorCode::kUsage, name + " is " + std::to_string(value) +
                                        "; it must be between " + std::to_string(least) + " and " +
                                        std::to_string(most));
}

}  // namespace

void CheckJobSpec(const JobSpec& spec) {
  CheckMapName(spec.name);
  CheckTags(spec.tags);
  if (spec.sources.empty()) throw MapError(ErrorCode::kUsage, "no source given; give at least one");
  CheckRange("--part-frames", spec.part_frames, kLeastPartFrames, kMostPartFrames);
  CheckRange("--attempts", spec.max_attempts, 1, kMostAttempts);
  const Json kept = Json::parse(TextOf(spec));
  if (kept["sources"] != Json(spec.sources) || kept["options"] != Json(spec.options)) {
    throw MapError(ErrorCode::kUsage,
                   "a path of the job is not UTF-8, which the database holds; rename it");
  }
}

std::string TextOf(const JobSpec& spec) {
  return Dump({{"sources", spec.sources},
               {"options", spec.options},
               {"tags", SortedTags(spec.tags)},
               {"part_frames", spec.part_frames},
               {"max_attempts", spec.max_attempts}});
}

JobSpec ReadJobSpec(const std::string& name, const std::string& text) {
  try {
    const Json json = Json::parse(text);
    JobSpec spec;
    spec.name = name;
    json.at("sources").get_to(spec.sources);
    json.at("options").get_to(spec.options);
    json.at("tags").get_to(spec.tags);
    json.at("part_frames").get_to(spec.part_frames);
    json.at("max_attempts").get_to(spec.max_attempts);
    CheckJobSpec(spec);
    return spec;
  } catch (const std::exception& error) {
    throw MapError(ErrorCode::kFileUnreadable, "the job in the database is damaged (" +
                                                   std::string(error.what()) +
                                                   "); cancel it and enqueue it again");
  }
}

int OverlapFrames(int part_frames) { return std::max(kLeastOverlap, part_frames / 10); }

std::vector<JobPart> CutIntoParts(int source, int frames, int from, int every, int part_frames) {
  const int overlap = OverlapFrames(part_frames);
  const int step = part_frames - overlap;
  const int count = frames <= part_frames ? 1 : (frames - overlap + step - 1) / step;
  // Frames that are new in each part, spread evenly; the first part has the overlap in addition.
  const int64_t fresh = std::max(0, frames - overlap);
  std::vector<JobPart> parts;
  for (int i = 0; i < count; ++i) {
    const auto first = static_cast<int>(fresh * i / count);
    const auto last = static_cast<int>(fresh * (i + 1) / count) + overlap - 1;
    const bool is_last = i + 1 == count;
    parts.push_back({.source = source,
                     .from = from + first * every,
                     .to = is_last ? -1 : from + last * every,
                     .frames = (is_last ? frames : last + 1) - first});
  }
  return parts;
}

}  // namespace waystone
