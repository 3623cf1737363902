// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "builder/appearance/options.h"
#include "builder/appearance/take_panoramas.h"
#include "builder/frames/layer_builder.h"

namespace waystone {

// What building the layer did. Skipped frames are not usable panoramas.
struct AppearanceReport : FrameReport {
  int panoramas = 0;
  int steps = 0;            // from one panorama to the next
  int uncertain = 0;        // of them, those whose heading is uncertain
  int loop_candidates = 0;  // given to the compass
  int loops_certain = 0;    // of them, with a certain heading
  int loops_supported = 0;  // of them, that neighbours agree with
  int loops_rejected = 0;   // of them, that don't fit the graph
  int dropped = 0;          // redundant panoramas
  // One pose per panorama, including dropped ones, by odometry only and in the end.
  std::vector<Pose2> odometry;
  std::vector<Pose2> poses;
  double odometry_s = 0;
  double loops_s = 0;
  double graph_s = 0;
  double calibrate_s = 0;  // of the verdict, by BuildMap

  // Whether so many steps are uncertain that the trajectory is unreliable: rooms are too small for
  // the steps, or panoramas too dark, too plain or too far apart.
  bool IsTrajectoryDoubtful() const;
};

// A panorama as it was read, also where it was left out as redundant.
struct AppearanceSampleFrame {
  FourierSignature signature;
  BearingFeatures features;  // all that were found; none where the layer keeps none
  Pose2 pose;                // layer_from_node
  int node = -1;             // index in the layer's nodes; -1 when it was left out
  SequenceId sequence;
  FrameInfo info;
};

// The appearance layer of sequences of panoramas (Fernandez et al. 2011): signatures (eq. 1),
// odometry (eqs. 2 to 5), loop closure, pose graph, and redundant nodes left out. Sequences are
// connected by the loops between them; one without any is laid out below the others. The layer's
// unit of length is that of eq. (2): its length in metres isn't known. Frames that can't be used
// (not decodable, of another size, all black, no panorama) are skipped. The layer doesn't depend on
// the number of threads.
class AppearanceLayerBuilder : public LayerBuilder {
 public:
  // Throws MapError(kBadOptions).
  explicit AppearanceLayerBuilder(const AppearanceOptions& options);

  std::string stage() const override { return "panoramas"; }
  void StartSequence(SequenceId id, const Source& source) override;
  std::unique_ptr<Observation> Observe(const Frame& frame) const override;
  // Throws MapError(kBadSource) for a panorama that shows other elevations than those before it.
  void Add(std::unique_ptr<Observation> observation, ProgressReporter& progress) override;
  // Throws MapError(kBadSource) for fewer than 2 usable panoramas.
  void FinishSequence(const FrameReport& sequence) override;
  // Stages "odometry", "loops" and "poses".
  void Finish(MapData& map, ProgressReporter& progress) override;

  const AppearanceReport& report() const { return report_; }
  // Panoramas that kept all of their features, for calibration; valid after Finish. AddNodePoses
  // changes their poses.
  std::vector<AppearanceSampleFrame>& samples() { return samples_; }

 private:
  AppearanceOptions options_;
  PanoramaTaker taker_;
  AppearanceReport report_;
  std::vector<AppearanceSampleFrame> samples_;
};

}  // namespace waystone
