// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/localization/graph_filter.h"
#include "core/panorama/fourier_signature.h"
#include "localizer/verdict/explanation.h"
#include "schema/layers/poses/pose_layer.h"

namespace waystone {

// The outcome of a query. All are answers, not errors. kUndecided occurs only with a deadline. All
// functions in this header are pure; thread-safe.
enum class Verdict { kLocalized, kAmbiguous, kNotInMap, kBadImage, kUndecided };

// "localized", "ambiguous", "not_in_map", "bad_image", "undecided".
const char* NameOf(Verdict verdict);

// The gate that decided an answer.
enum class DecidedBy {
  kNone,               // nothing was decided: the layer has nothing to compare with
  kFeatures,           // the image has too few features
  kShortlistVotes,     // no plane got enough votes
  kHomographyInliers,  // planes that fit, or none that does
  kEpipolarInliers,    // a keyframe that fits by its landmarks
  kInlierShare,        // too few of the best plane's matches fit its homography
  kHomographyScale,    // the best plane's homography has an implausible scale
  kPlaceProbability,   // the best place isn't probable enough
  kAmbiguousPlaces,    // two places of a map look alike
  kAmbiguousMaps,      // several maps recognise the image
  kBuildingAxes,       // the image's lines against the building's axes
  kPanoramaSignature,  // only a panorama's appearance
  kPanoramaFeatures,   // relative poses to the nodes' features
  kPhoto,              // a photo that no two panoramas show enough of, or that can't be queried
  kPhotoFeatures,      // a photo's relative poses to the nodes' features
  kSeries,             // the belief over a series of panoramas
  kDeadline,           // the query's deadline
  kBadImage,           // bytes that are no image, or an image that can't be used
  kImageTooLarge,      // an image beyond the limits
};
// As in the JSON answer: "homography_inliers", "building_axes", ...; "" for kNone.
const char* NameOf(DecidedBy gate);

// The stages of a query, in their order.
enum class Stage { kQueue, kDecode, kExtract, kShortlist, kDecide };
// "queue", "decode", "extract", "shortlist", "decide".
const char* NameOf(Stage stage);

// A reference to a keyframe in an answer.
struct KeyframeRef {
  KeyframeId id;
  std::string sequence;  // name
  std::string source;
  std::optional<double> time_s;
};

// A plane that the query shows.
struct RecognisedPlane {
  PlaneId id;
  int inliers = 0;
  KeyframeRef reference;
  // x_reference = reference_from_query * x_query, homogeneous pixels, h33 = 1.
  Eigen::Matrix3d reference_from_query = Eigen::Matrix3d::Identity();
  std::vector<Eigen::Vector2d> outline;  // in the query image, px, clipped to it
  std::vector<PlaneId> expect_next;      // covisible planes not recognised here, by id
  // The matches that support it: query pixels and reference pixels, row by row.
  std::vector<Eigen::Vector2d> query_points;
  std::vector<Eigen::Vector2d> reference_points;
};

// A place that was considered: a keyframe with the evidence for it.
struct PlaceCandidate {
  KeyframeRef keyframe;
  double probability = 0;  // in [0, 1]
  int inliers = 0;
};

// What a heading is relative to.
enum class HeadingFrame { kKeyframe, kBuilding, kLayer };
const char* NameOf(HeadingFrame frame);  // "keyframe", "building", "layer"

// Counter-clockwise from the frame's x axis, seen from above.
struct Heading {
  double rad = 0;
  double sigma_rad = 0;
  HeadingFrame frame = HeadingFrame::kKeyframe;
};

// The query's rotation in the building, where the map has an orientation layer.
struct BuildingView {
  // The building's axes x and y are horizontal, z is up; the query's frame is its camera's, or the
  // panorama's middle column's: x right, y down, z forward. Unit; the identity without a heading.
  Eigen::Quaterniond building_from_query = Eigen::Quaterniond::Identity();
  std::optional<Heading>
      heading;  // in the building: of the view ahead; nothing where it stays open
  // Numbers of the query's lines along the building's x, y and z; 0 where the rotation isn't from
  // lines.
  std::array<int, 3> lines{};
  // Angle between the axes by the query's lines and those that the place implies, up to quarter
  // turns; nothing where the lines are inconclusive.
  std::optional<double> disagreement_rad;
};

// A reference to a node of the appearance layer in an answer.
struct NodeRef {
  AppearanceNodeId id;
  std::string sequence;  // name
  std::string source;
  std::optional<double> time_s;
  Pose2 pose;  // in the layer's frame and units
};

// A node that was considered.
struct NodeCandidate {
  NodeRef node;
  double probability = 0;  // in [0, 1]
  double cost = 0;         // of appearance: 0 the same view, about 1 another place
  int inliers = 0;         // features that fit one motion; 0 when it wasn't verified
  // The query's rotation relative to the node by that motion; nothing when it wasn't verified.
  std::optional<Eigen::Matrix3d> query_from_node;
};

// All matches of a query with one keyframe that fit one epipolar geometry: of its planes' features
// and of its landmarks.
struct EpipolarMatches {
  KeyframeRef keyframe;
  int inliers = 0;  // at distinct positions of the query
  int matches = 0;  // among which they were found
  // The inliers, row by row: pixels of the query and of the keyframe.
  std::vector<Eigen::Vector2d> query_points;
  std::vector<Eigen::Vector2d> keyframe_points;
};

// A keypoint of the query and the map's feature that it shows, by row of MapIndex::search().
struct MapMatch {
  int keypoint = 0;
  int row = 0;

  auto operator<=>(const MapMatch&) const = default;
};

// Where the query's camera was in the frame of the map's pose layer.
struct QueryPose {
  std::string frame;  // its name
  LengthUnit unit = LengthUnit::kUnknown;
  // The camera has x right, y down, z forward.
  Eigen::Isometry3d frame_from_camera = Eigen::Isometry3d::Identity();
  // Of the position, x y z, and of a small rotation about the frame's x, y and z,
  // exp(delta) frame_from_camera: unit^2, unit rad, rad^2.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int inliers = 0;  // matches that support it; 0 for a panorama by its appearance only
  // Whether the request had no camera, and that of the map's images, of the same size, was used.
  bool by_own_camera = false;
};

// The plane layer's answer to a query. Empty where the appearance layer answered.
struct PlaneAnswer {
  std::optional<KeyframeRef> keyframe;      // nearest; only when localized
  std::vector<RecognisedPlane> recognised;  // most inliers first; none where landmarks settled it
  std::optional<EpipolarMatches> epipolar;  // where the map has landmarks
  std::vector<PlaceCandidate> places;       // when ambiguous: all that look alike, best first
  std::optional<PlaceCandidate> runner_up;
  std::vector<PlaceCandidate> candidates;  // every place that was considered, best first
  std::optional<Explanation> explanation;  // only with LocalizeOptions::explain
  std::vector<MapMatch> matches;           // of the place, only when localized on a map with poses
};

// Inliers of the best plane or, where no plane was recognised, of the keyframe; 0 with neither.
int CountBestInliers(const PlaneAnswer& answer);

// The appearance layer's answer to a query: where it was taken, which is valid only when the answer
// is localized.
struct PanoramaAnswer {
  NodeRef node;      // the nearest
  Pose2 pose;        // of the query, in the layer's frame and units
  double sigma = 0;  // of the position, in the layer's units
  // Of the position, in the layer's frame; `sigma` is along its worst direction.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  std::optional<double> metres_per_unit;  // nothing when the layer's scale isn't known
  // The nodes that were considered, best first, including those near the best.
  std::vector<NodeCandidate> candidates;
  std::optional<NodeCandidate> runner_up;  // the best node elsewhere
};

// Where a query was taken on a floor plan of the map.
struct PlanPosition {
  std::string name;                              // of the plan
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // of its image, from the upper left corner
};

// Milliseconds by stage. Stages that were not reached are 0.
struct StageTimes {
  double decode_ms = 0;
  double extract_ms = 0;
  double shortlist_ms = 0;
  double verify_ms = 0;
  double pose_ms = 0;  // only on maps with poses
  double total_ms = 0;
};

// The localizer's answer for one image and one map.
struct Answer {
  Verdict verdict = Verdict::kNotInMap;
  double probability = 0;  // that the place is right; in [0, 1]
  std::string image;       // name of the query, as given
  std::string map;
  std::string map_version;
  std::optional<Heading> heading;
  std::optional<BuildingView> building;  // of a localized query of known camera, or a panorama
  PlaneAnswer planes;
  std::optional<PanoramaAnswer> panorama;  // where the appearance layer answered
  std::optional<QueryPose> pose;           // of a localized photo of known camera, or a panorama
  std::string pose_reason;                 // why a map with poses gave none
  std::optional<std::string> place_name;   // what people named the place of a localized query
  std::optional<PlanPosition> plan;        // of a localized query with a position on a plan
  // The belief for the next panorama of a series: the likeliest nodes, by index. Empty as long as
  // no panorama looked like a place of the map.
  FilterState belief;
  // For a panorama of a series: what the next one is compared with.
  std::optional<FourierSignature> described;
  DecidedBy decided_by = DecidedBy::kNone;
  std::string message;  // one line for people: why it isn't localized, and what would help
  // The last stage that was finished. Nothing unless the query had a deadline.
  std::optional<Stage> last_stage;
  StageTimes timing;
};

// "89%", rounded down, so that no share appears to reach a threshold that it misses.
std::string PercentText(double share);

// The answer once the deadline has passed, `last` being the last stage that was finished.
Answer Undecided(Stage last);

// The verdict kBadImage for an error of decoding or describing an image (kBadImage or
// kImageTooLarge, WS_CHECK), with its cause.
Answer RefuseImage(const MapError& error);

}  // namespace waystone
