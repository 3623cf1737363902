// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "builder/planes/options.h"
#include "core/camera/camera.h"
#include "core/features/features.h"
#include "schema/map_data.h"

namespace waystone {

// Counts of what a tracker did.
struct TrackerReport {
  int rotation_only = 0;  // keyframe pairs
  int started = 0;
  int rejected = 0;  // by the homology test
  int merged = 0;    // by the homology test
  int dropped = 0;   // contradicted, or too few features left after the votes
  int features_dropped = 0;
};

// Algorithm 1, lines 1 to 14: finds the planes of consecutive keyframes and follows them by triple
// matching plane-image-image. Holds only the features of the planes, of the last keyframe, and of
// the reference images of open planes. Not thread-safe.
class PlaneTracker {
 public:
  explicit PlaneTracker(const PlaneLayerOptions& options);

  // The next keyframe; ids ascend. At the start of a stretch all open planes are closed first.
  void AddKeyframe(KeyframeId id, const Features& features, bool starts_stretch,
                   const std::optional<Camera>& camera);

  // Closes all open planes; planes() and edges() are then complete (with the tracker's ids,
  // ascending).
  void Finish();
  std::vector<Plane>& planes() { return closed_; }
  const std::vector<Edge>& edges() const { return edges_; }
  const TrackerReport& report() const { return report_; }
  int plane_count() const { return static_cast<int>(open_.size() + closed_.size()); }

 private:
  // A plane that was seen in the last keyframe.
  struct OpenPlane {
    Plane plane;
    std::shared_ptr<const Features> reference;  // all that the reference image shows
    std::vector<char> anchored;                 // of each feature: the reference image shows it
    std::vector<int> feature_at;  // of each keypoint of the last keyframe: plane feature or -1
    int carried = 0;              // matches that took its features to later keyframes
    int supported = 0;            // of them, those that its homographies explain
    bool renewed = false;         // a plane with a newer reference image continues it
  };

  // The step from the last keyframe to the current one.
  struct Step {
    KeyframeId id;
    const Features& current;
    std::vector<Match> matches;  // a: current keypoint, b: last keyframe's keypoint
    MatchedPoints points;        // from: current, to: last
    bool rotation_only = false;
  };
  // An open plane that was found again in the current keyframe.
  struct Tracked {
    Eigen::Matrix3d reference_from_current;
    PlaneSegment segment;         // to_from: last_from_current; rows of Step::matches
    std::vector<int> feature_at;  // of each current keypoint
  };

  Step MakeStep(KeyframeId id, const Features& features, const std::optional<Camera>& camera);
  std::optional<Tracked> Track(OpenPlane& open, const Step& step) const;
  void Reacquire(const OpenPlane& open, const Step& step, Tracked& tracked) const;
  void Advance(const Step& step);
  static void Confirm(const Step& step, OpenPlane& open, Tracked& tracked, std::vector<int>& rows);
  std::vector<int> Grow(OpenPlane& open, const Step& step, const Tracked& tracked,
                        const std::vector<int>& grown_rows);
  static void AddFeature(OpenPlane& open, int keypoint, const PlaneFeature& feature,
                         const uint8_t* descriptor, bool anchored);
  void CountVotes(OpenPlane& open, const Step& step, const Tracked& tracked) const;
  void Start(const Step& step, const PlaneSegment& segment);
  bool WantsRenewal(const OpenPlane& open, const std::vector<int>& rows) const;
  void Continue(const Step& step, const std::vector<int>& rows, Segmentation& segmentation);
  void AddEdges(const Step& step, const std::vector<PlaneId>& ids,
                const std::vector<PlaneSegment>& segments);
  bool IsContradicted(const OpenPlane& open) const;
  void Close(OpenPlane open);

  PlaneLayerOptions options_;
  std::shared_ptr<const Features> last_;
  KeyframeId last_id_;
  std::vector<OpenPlane> open_;
  std::vector<Plane> closed_;
  std::vector<Edge> edges_;
  std::set<std::pair<PlaneId, PlaneId>> has_edge_;
  int64_t next_plane_ = 1;
  TrackerReport report_;
};

}  // namespace waystone
