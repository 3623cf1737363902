// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace waystone {

// A map to be built and published.
struct JobSpec {
  std::string name;                  // of the map
  std::vector<std::string> sources;  // as `waystone build` takes them, for every worker
  std::vector<std::string> options;  // of `waystone build`: "--every=2"
  std::vector<std::string> tags;     // of the published version
  int part_frames = 3000;            // a longer walk is cut into parts
  int max_attempts = 5;              // of each step

  bool operator==(const JobSpec&) const = default;
};

// Throws MapError(kUsage) for a name or tag that can't be published, no source, and numbers out of
// their ranges.
void CheckJobSpec(const JobSpec& spec);

// As the database holds it. Reading throws MapError(kFileUnreadable) for what is no such text.
std::string TextOf(const JobSpec& spec);
JobSpec ReadJobSpec(const std::string& name, const std::string& text);

// A stretch of a job's frames, which one worker builds at a time.
struct JobPart {
  int source = -1;  // the one of JobSpec::sources that is cut; -1: all of them, whole
  int from = 0;     // numbers of its first and last frame, as `waystone build` takes them
  int to = -1;      // -1: up to the end, or where the options end
  int frames = 0;   // that are used

  bool operator==(const JobPart&) const = default;
};

// Frames of two neighbouring parts that both have, so that their maps can be joined.
int OverlapFrames(int part_frames);

// A sequence of `frames` used frames, each `every`-th from `from` on, cut into parts of at most
// `part_frames`, as even as they can be, each with OverlapFrames in common with the one before. The
// last part ends where the source does, whose number of frames may be an estimate.
std::vector<JobPart> CutIntoParts(int source, int frames, int from, int every, int part_frames);

// What a worker does of a job, one after the other, but that parts are built by several at once.
enum class StepKind {
  kPlan,  // looks at the source, and cuts it
  kPart,  // builds a part, and puts its map into the store
  kJoin,  // joins the parts' maps, and publishes the map
};

// A step that a worker has. It is the worker's until the lease ends, which heartbeats put off;
// `token` tells it from the leases of the same step before and after.
struct JobLease {
  int64_t job = 0;
  int step = 0;
  StepKind kind = StepKind::kPlan;
  int64_t token = 0;
  JobSpec spec = {};
  int failures = 0;   // of the step, before this lease
  JobPart part = {};  // of kPart
  int parts = 0;      // of the job, once it is planned
};

// What has become of a part.
struct BuiltPart {
  JobPart part;
  std::string sha256;  // of its map in the store; empty where the images showed nothing
  int64_t bytes = 0;
};

// How far a step is.
struct StepProgress {
  std::string stage = {};
  int done = 0;
  int total = 0;   // 0 when not known
  int frames = 0;  // of the part, so far
};

}  // namespace waystone
