// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace waystone {

// A map to be built and published.
struct JobSpec {
  std::string name;                  // of the map
  std::vector<std::string> sources;  // as `waystone build` takes them; every worker reaches them
  std::vector<std::string> options;  // of `waystone build`: "--every=2"
  std::vector<std::string> tags;     // of the published version
  int part_frames = 3000;            // a longer walk is cut into parts; 20 to 1,000,000
  int max_attempts = 5;              // of each step; 1 to 100

  bool operator==(const JobSpec&) const = default;
};

// Throws MapError(kUsage) for a name or tag that can't be published, no source, a source or option
// that isn't UTF-8, and numbers out of range. The functions here are pure; thread-safe.
void CheckJobSpec(const JobSpec& spec);

// The form in which the database holds it, with each tag once, sorted. Reading throws
// MapError(kFileUnreadable) for any other text, and for what CheckJobSpec refuses.
std::string TextOf(const JobSpec& spec);
JobSpec ReadJobSpec(const std::string& name, const std::string& text);

// A stretch of a job's frames, built by one worker at a time.
struct JobPart {
  int source = -1;  // index in JobSpec::sources of the one that is cut; -1: all, uncut
  int from = 0;     // numbers of its first and last frame, as `waystone build` takes them
  int to = -1;      // -1: up to the end, or where the options end
  int frames = 0;   // number of frames used

  bool operator==(const JobPart&) const = default;
};

// The number of frames that two neighbouring parts share, so that their maps can be joined: a tenth
// of a part, at least 10.
int OverlapFrames(int part_frames);

// Cuts a sequence of `frames` used frames, every `every`-th from `from` on, into parts of at most
// `part_frames` (20 or more), as even as possible, each sharing OverlapFrames with the one before.
// The last part ends where the source does, whose number of frames may be an estimate.
std::vector<JobPart> CutIntoParts(int source, int frames, int from, int every, int part_frames);

// The steps of a job, in this order; several workers may build its parts at the same time.
enum class StepKind {
  kPlan,  // looks at the source, and cuts it
  kPart,  // builds a part, and puts its map into the store
  kJoin,  // joins the parts' maps, and publishes the map
};

// A step that a worker has, until the lease ends; heartbeats extend it. `token` distinguishes this
// lease from earlier and later ones of the same step.
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

// The outcome of a part.
struct BuiltPart {
  JobPart part;
  std::string sha256;  // of its map in the store; empty where the images showed nothing
  int64_t bytes = 0;
};

// The progress of a step.
struct StepProgress {
  std::string stage = {};
  int done = 0;
  int total = 0;   // 0 when not known
  int frames = 0;  // of the part, so far
};

}  // namespace waystone
