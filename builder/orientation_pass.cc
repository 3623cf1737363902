// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation_pass.h"

#include <string>
#include <utility>

#include "core/base/error.h"

namespace waystone {
namespace {

OrientationOptions LookOptions(const BuildOptions& options) {
  OrientationOptions look = options.orientation;
  if (!options.images) look.image_width = 0;
  return look;
}

}  // namespace

OrientationPass::OrientationPass(const BuildOptions& options,
                                 const std::function<bool(const BuildProgress&)>& progress)
    : layers_(options.layers),
      progress_(progress),
      options_(LookOptions(options)),
      builder_(options_) {}

void OrientationPass::Watch(int64_t first, std::vector<Source*>& sources) {
  for (size_t i = 0; i < sources.size(); ++i) {
    if (!GivesOrientation(*sources[i], layers_)) continue;
    const SequenceId id{first + static_cast<int64_t>(i)};
    watched_.push_back(std::make_unique<LookedAtSource>(id, *sources[i], options_, builder_));
    sources[i] = watched_.back().get();
  }
}

Sequence OrientationPass::Read(const MapData& map, Source& source) {
  read_ = true;
  Sequence sequence;
  sequence.id = SequenceId{std::ssize(map.sequences) + 1};
  sequence.name = source.name();
  sequence.kind = source.kind();
  sequence.camera = source.camera();
  const int before = builder_.frames();
  const auto report = [&](const OrientationProgress& now) {
    BuildProgress build;
    build.stage = "directions";
    build.done = now.done - before;
    return !progress_ || progress_(build);
  };
  look_s_ += MapSequence(SequenceOf(sequence.id, source), options_, report, builder_);
  sequence.frames = builder_.frames() - before;
  return sequence;
}

void OrientationPass::Finish(BuildResult& result) {
  if (empty()) return;
  OrientationResult built = builder_.Finish();
  built.report.look_s = look_s_;
  for (const auto& source : watched_) built.report.look_s += source->look_s();
  result.map.orientation = std::move(built.layer);
  result.report.orientation = std::move(built.report);
}

std::vector<Source*> DirectionsAlone(const std::vector<std::unique_ptr<Source>>& sources,
                                     const LayerChoice& layers) {
  std::vector<Source*> alone;
  for (const std::unique_ptr<Source>& source : sources) {
    if (!LayerOf(*source, layers) && GivesOrientation(*source, layers)) {
      alone.push_back(source.get());
    }
  }
  return alone;
}

void RefuseUncalibrated(size_t sources) {
  throw MapError(ErrorCode::kBadCamera,
                 "none of the " + std::to_string(sources) +
                     " sources is calibrated, which the orientation layer requires; use --camera "
                     "FILE, panoramas or a rig");
}

}  // namespace waystone
