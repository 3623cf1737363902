// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <string>

#include "builder/sources/source.h"
#include "core/base/options.h"
#include "core/camera_pose/inverse_depth.h"
#include "core/features/match.h"
#include "core/two_view/fundamental.h"
#include "schema/map_data.h"

namespace waystone {

// Where the images of a build were taken, by another program.
struct GivenPoses {
  std::string frame = "map";  // its name
  LengthUnit unit = LengthUnit::kUnknown;
  // frame_from_camera of an image of a sequence; nothing where it isn't known. The camera has x
  // right, y down, z forward; a panorama's looks ahead where its middle column does. Any thread.
  std::function<std::optional<Eigen::Isometry3d>(const Sequence&, const FrameInfo&)> of_image;
};

struct PoseOptions {
  double keypoint_sigma_px = 0.7;
  int neighbours = 4;
  double near_px = 3;
  double max_descriptor_distance = 0.5;
  double min_consistent = 0.5;
  double min_posed = 0.5;
  int compared_steps = 100;
  double max_turn_error_rad = 0.05;
  double max_direction_error_rad = 0.5;
  MatchOptions match;
  EpipolarOptions epipolar{.max_error_px = 1.5};
  DepthOptions depth;

  static constexpr auto Fields(const auto& use) {
    using Self = PoseOptions;
    return use(
        OptionField{"keypoint_sigma_px", &Self::keypoint_sigma_px, Above(0), "px",
                    "Standard deviation of a keypoint's position, the error of the given poses "
                    "included.",
                    OptionUse::kInternal},
        OptionField{"neighbours", &Self::neighbours, Closed(1, 20), "",
                    "Keyframes before and after in which a feature is searched for.",
                    OptionUse::kInternal},
        OptionField{"near_px", &Self::near_px, Above(0), "px",
                    "A plane's feature is searched for in another view within this distance of "
                    "where the homography puts it.",
                    OptionUse::kInternal},
        OptionField{"max_descriptor_distance", &Self::max_descriptor_distance, OpenLow(0, 1), "",
                    "Largest distance of a feature's descriptors in two views, as a share of what "
                    "descriptors can differ by.",
                    OptionUse::kInternal},
        OptionField{"min_consistent", &Self::min_consistent, Closed(0, 1), "",
                    "Smallest share of the matches of neighbouring keyframes that must agree with "
                    "the poses. With fewer, the poses are refused.",
                    OptionUse::kInternal},
        OptionField{"min_posed", &Self::min_posed, Closed(0, 1), "",
                    "Smallest share of the keyframes, and of the panoramas, that must have a pose.",
                    OptionUse::kInternal},
        OptionField{"compared_steps", &Self::compared_steps, Closed(1, 100'000), "",
                    "Steps from a panorama to the next whose motion is compared with the poses, "
                    "spread evenly over all. A few ms each.",
                    OptionUse::kInternal},
        OptionField{
            "max_turn_error_rad", &Self::max_turn_error_rad, Closed(0.001, 1), "rad",
            "By how much the turn of such a step may differ. A turn of twice as much is one "
            "that poses must show.",
            OptionUse::kInternal},
        OptionField{"max_direction_error_rad", &Self::max_direction_error_rad, Closed(0.01, 3),
                    "rad", "By how much its direction may differ.", OptionUse::kInternal},
        OptionGroup{"match", &Self::match}, OptionGroup{"epipolar", &Self::epipolar},
        OptionGroup{"depth", &Self::depth});
  }
};

}  // namespace waystone
