// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/camera/rig.h"
#include "core/manhattan/manhattan_frame.h"
#include "localizer/index/map_index.h"
#include "localizer/orientation/building_options.h"
#include "localizer/verdict/answer.h"

// A camera's rotation in the building by the map's orientation layer and the query's own lines
// (Puig et al. 2012, sec. II-A), once the place is known. All functions are deterministic;
// thread-safe.
namespace waystone {

// A rotation that a query would have if its place and one reading of its motion were right.
struct BuildingGuess {
  Eigen::Matrix3d building_from_query = Eigen::Matrix3d::Identity();
  double sigma_rad = 0;  // of its heading
  int weight = 0;        // inliers that speak for it
};

// The guesses of a localized answer, best plane or node first; a homography allows two motions
// (Malis and Vargas 2007), which give two guesses. Rotations come through keyframes and nodes whose
// frame is reliable in the orientation layer; none where there is no such frame. A panorama without
// verified features is assumed to stand as upright as the node's. The camera is the query's, not
// needed for panoramas.
std::vector<BuildingGuess> GuessRotation(const MapIndex& index, const Answer& answer,
                                         const std::optional<Camera>& camera,
                                         const BuildingOptions& options = {});

// The rotation that the guesses and the lines agree on, with its heading; nothing where they leave
// it open. Lines select the guess, and are more precise where they are reliable. `disagreement_rad`
// is set where reliable lines could be compared with a guess; when it is above
// options.max_disagreement_rad, nothing else is set.
BuildingView ViewBuilding(const std::vector<BuildingGuess>& guesses, const ManhattanFrame& lines,
                          const BuildingOptions& options);

// The query's lines: of one camera, or, without a camera, of the six faces of a panorama. Throws
// MapError(kBadImage) for an image that doesn't have the camera's size.
ManhattanFrame DetectLines(const cv::Mat& grey, const std::optional<Camera>& camera,
                           const BuildingOptions& options);

// How many chances the guesses give axes to agree: guesses nearer to each other than `apart_rad`,
// up to the quarter turns that axes leave open, count as one. Planes of one view share the true one
// of their two motions.
int CountChances(const std::vector<BuildingGuess>& guesses, double apart_rad);

// The gate kBuildingAxes: an answer whose axes disagree by more than the options' bound becomes
// less probable, since of true places only the share options.true_disagreeing disagrees and of
// wrong ones as many as by chance, and kNotInMap where its probability falls below
// `min_probability`. `chances` is the number of chances that the axes had to agree. The answer is
// localized and has `building`.
void JudgeByAxes(int chances, double min_probability, const BuildingOptions& options,
                 Answer& answer);

// What AddBuilding knows of a query besides its image.
struct BuildingQuery {
  std::optional<Camera> camera;  // nothing for a panorama; one of another size isn't used
  bool with_lines = true;        // whether lines are detected, which takes as long as features
  double min_probability = 0.9;  // that the answer's layer requires
};

// Adds the rotation in the building to a localized answer and judges it by the axes. Leaves other
// answers, and those of maps without the layer, as they are.
void AddBuilding(const MapIndex& index, const cv::Mat& grey, const BuildingQuery& query,
                 const BuildingOptions& options, Answer& answer);

}  // namespace waystone
