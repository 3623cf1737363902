// SPDX-License-Identifier: Apache-2.0
// The steps of a job: its plan, its parts, and joining them.
#include <algorithm>
#include <cstdio>
#include <optional>
#include <utility>
#include <vector>

#include "builder/joining/join_parts.h"
#include "cli/commands/build_flags.h"
#include "cli/commands/job_persist.h"
#include "cli/commands/job_worker.h"
#include "cli/files/map_file.h"
#include "cli/output/progress.h"
#include "cli/system/signals.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "registry/coarse_file.h"
#include "schema/file/map_store.h"
#include "schema/file/sha256.h"
#include "schema/sequence_kinds.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr double kMegabyte = 1e6;

void StopIfNeeded(const LeaseKeeper& keeper) {
  if (!Interrupted() && !keeper.lost()) return;
  throw MapError(ErrorCode::kInterrupted, "interrupted");
}

// The number of frames that the source yields. A video's header may be wrong, so a video is read to
// its end.
int CountFrames(Source& source, const LeaseKeeper& keeper) {
  if (source.kind() != kVideoKind) return source.size();
  int frames = 0;
  while (source.NextEncoded()) {
    ++frames;
    StopIfNeeded(keeper);
  }
  return frames;
}

// Maps of other layers can't be joined, those without pictures aren't tied together, and those with
// poses would be aligned by what they show instead of by their poses.
bool CanBeCut(const BuildFlags& flags, const std::vector<std::unique_ptr<Source>>& sources,
              const BuildOptions& options) {
  return options.images && flags.poses.file.empty() &&
         std::ranges::all_of(sources, [&](const auto& source) {
           return ChooseLayers(*source, options.layers) == std::vector{LayerKind::kPlanes};
         });
}

BuildFlags FlagsOfPart(const JobSpec& spec, const JobPart& part) {
  BuildFlags flags = ParseBuildFlags(spec.sources, spec.options);
  if (part.source < 0) return flags;
  flags.sources.paths = {flags.sources.paths.at(static_cast<size_t>(part.source))};
  flags.sources.options.from = part.from;
  if (part.to >= 0) flags.sources.to = part.to;
  return flags;
}

std::string MegabytesText(int64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) / kMegabyte);
  return text;
}

int64_t BytesOf(const fs::path& file) { return static_cast<int64_t>(fs::file_size(file)); }

// The database's answer. Throws MapError(kInterrupted) where there is none: a signal came first, or
// the lease was lost.
template <class Answer>
Answer Answered(std::optional<Answer> answer) {
  if (!answer) throw MapError(ErrorCode::kInterrupted, "interrupted");
  return *std::move(answer);
}

void RemoveFile(const fs::path& file) {
  std::error_code ignored;
  fs::remove(file, ignored);
}

}  // namespace

JobWorker::Outcome JobWorker::Plan(const JobLease& lease, LeaseKeeper& keeper) {
  const JobSpec& spec = lease.spec;
  const BuildFlags flags = ParseBuildFlags(spec.sources, spec.options);
  const BuildOptions options = MakeBuildOptions(flags, spec.name);
  CheckPoseFlags(flags.poses);
  const auto sources = OpenSources(flags.sources, options.layers, true);
  const bool can_be_cut = CanBeCut(flags, sources, options);
  std::vector<JobPart> parts;
  int frames = 0;
  for (size_t i = 0; i < sources.size(); ++i) {
    const int count = CountFrames(*sources[i], keeper);
    frames += count;
    const std::vector<JobPart> cut =
        CutIntoParts(static_cast<int>(i), count, flags.sources.options.from,
                     flags.sources.options.every, spec.part_frames);
    parts.insert(parts.end(), cut.begin(), cut.end());
  }
  if (!can_be_cut || frames <= spec.part_frames) parts = {{.frames = frames}};
  const bool held =
      Answered(Persist([&](JobQueue& queue) { return queue.FinishPlan(lease, parts); }, &keeper));
  return {held, std::to_string(frames) + " frames in " + std::to_string(parts.size()) +
                    (parts.size() == 1 ? " part" : " parts")};
}

JobWorker::Outcome JobWorker::BuildPart(const JobLease& lease, LeaseKeeper& keeper) {
  const Clock::time_point start = Clock::now();
  const fs::path file = MapOf(lease);
  const bool built_before = fs::exists(file);
  std::string sha256;
  int64_t bytes = 0;
  if (built_before || BuildMapOf(lease, keeper, file)) {
    StopIfNeeded(keeper);
    sha256 = Sha256OfFile(file);
    bytes = BytesOf(file);
    keeper.Report({.stage = "storing", .frames = lease.part.frames});
    store_->Put(file, sha256, bytes);
  }
  const bool held = Answered(
      Persist([&](JobQueue& queue) { return queue.FinishPart(lease, sha256, bytes); }, &keeper));
  RemoveFile(file);
  const std::string result = sha256.empty() ? "shows nothing" : MegabytesText(bytes);
  return {held, result + (built_before ? ", built before the worker was stopped" : "") + ", " +
                    Duration(SecondsSince(start))};
}

// Builds the map. False where the images show nothing by which a query could be recognised.
bool JobWorker::BuildMapOf(const JobLease& lease, LeaseKeeper& keeper, const fs::path& file) {
  const BuildFlags flags = FlagsOfPart(lease.spec, lease.part);
  const std::string number = lease.parts > 1 ? "-" + std::to_string(lease.step) : "";
  BuildOptions options = MakeBuildOptions(flags, lease.spec.name + number);
  options.threads = options_.threads;
  StepProgress progress;
  const auto go_on = [&](const BuildProgress& now) {
    progress.stage = now.stage;
    progress.done = now.done;
    progress.total = now.total;
    // The first stage reads the frames; each goes through all of them.
    if (now.stage == "frames") progress.frames = std::min(now.done, lease.part.frames);
    keeper.Report(progress);
    return !Interrupted() && !keeper.lost();
  };
  const BuildResult result =
      BuildMap(OpenSources(flags.sources, options.layers, true), options, go_on, PosesOf(flags));
  if (CanAnswer(result)) {
    WriteMap(result.map, file, {.overwrite = true});
    return true;
  }
  if (lease.parts > 1) return false;
  throw MapError(ErrorCode::kBadSource, NoPlanesText(result.map));
}

JobWorker::Outcome JobWorker::Join(const JobLease& lease, LeaseKeeper& keeper) {
  const Clock::time_point start = Clock::now();
  std::vector<BuiltPart> parts =
      Answered(Persist([&](JobQueue& queue) { return queue.Parts(lease.job); }, &keeper));
  std::erase_if(parts, [](const BuiltPart& part) { return part.sha256.empty(); });
  if (parts.empty()) {
    throw MapError(ErrorCode::kBadSource,
                   "no plane or landmark found in any of " + std::to_string(lease.parts) +
                       " parts; record textured walls or floors while moving sideways");
  }
  std::vector<MapCache::FilePtr> files;
  for (const BuiltPart& part : parts) {
    keeper.Report({.stage = "fetching"});
    StopIfNeeded(keeper);
    files.push_back(parts_->Get(*store_, part.sha256, part.bytes));
  }
  const fs::path merged = MapOf(lease);
  if (files.size() > 1) MergeParts(lease, keeper, files, merged);
  const fs::path file = files.size() > 1 ? merged : files.front()->path();
  keeper.Report({.stage = "publishing"});
  const OpenMap map = OpenMapFile(file, true);
  const MapVersion version = MakeVersion(lease.spec.name, *map.index, BytesOf(file),
                                         lease.spec.tags, PutCoarseEntry(*store_, *map.index));
  store_->Put(file, version.sha256, version.bytes);
  StopIfNeeded(keeper);
  const auto finished =
      Persist([&](JobQueue& queue) { return queue.FinishJoin(lease, version); }, &keeper);
  if (finished || keeper.lost()) {  // otherwise the step may be this worker's again
    RemoveFile(merged);
    files.clear();
    for (const BuiltPart& part : parts) parts_->Drop(part.sha256);
  }
  const std::optional<MapVersion> published = Answered(finished);
  if (!published) return {.held = false, .said = {}};
  return {true, "published " + waystone::Describe(*published) + ", " +
                    MegabytesText(version.bytes) + ", " + Duration(SecondsSince(start))};
}

void JobWorker::MergeParts(const JobLease& lease, LeaseKeeper& keeper,
                           const std::vector<MapCache::FilePtr>& files, const fs::path& merged) {
  const BuildOptions options =
      MakeBuildOptions(ParseBuildFlags(lease.spec.sources, lease.spec.options), lease.spec.name);
  std::vector<MapData> maps;
  for (const MapCache::FilePtr& file : files) {
    keeper.Report({.stage = "joining",
                   .done = static_cast<int>(maps.size()),
                   .total = static_cast<int>(files.size())});
    StopIfNeeded(keeper);
    maps.push_back(ReadMap(file->path()));
  }
  WriteMap(JoinParts(std::move(maps), lease.spec.name, options).map, merged, {.overwrite = true});
}

}  // namespace waystone
