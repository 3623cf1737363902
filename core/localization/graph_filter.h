// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/base/options.h"
#include "core/geometry/pose2.h"

// Localizes a series of images in a graph of nodes with poses: a Bayes filter whose places are the
// nodes, each with a normal distribution of the heading. Monte-Carlo localization (Fernandez et al.
// 2010) approaches it with many particles; here nothing is drawn at random.
namespace waystone {

struct GraphFilterOptions {
  double position_sigma = 0.3;
  double share_of_trajectory = 0.1;
  double step_sigma = 1.0;
  double turn_sigma_rad = 0.1;
  double kidnapped = 1e-3;
  int max_beliefs = 64;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"position_sigma", &GraphFilterOptions::position_sigma, Closed(1e-9, 1e9), "",
                    "Standard deviation of an image's position around the predicted place, in the "
                    "poses' units, in addition to share_of_trajectory. At least the distance "
                    "between nodes, since a robot is rarely at a node."},
        OptionField{
            "share_of_trajectory", &GraphFilterOptions::share_of_trajectory, Closed(0, 1), "",
            "The same as position_sigma, per unit of trajectory that the odometry reports."},
        OptionField{"step_sigma", &GraphFilterOptions::step_sigma, Closed(1e-9, 1e9), "",
                    "Standard deviation of the distance that a robot moves between two images, "
                    "without odometry. Higher values follow faster robots; lower values resolve "
                    "ambiguities sooner."},
        OptionField{"turn_sigma_rad", &GraphFilterOptions::turn_sigma_rad, Closed(0.001, 3), "rad",
                    "Standard deviation of a turn that the odometry reports."},
        OptionField{
            "kidnapped", &GraphFilterOptions::kidnapped, Closed(1e-9, 0.5), "",
            "Probability that the robot was carried elsewhere between two images. Higher values "
            "recover sooner from an error; lower values retain what is known for longer."},
        OptionField{"max_beliefs", &GraphFilterOptions::max_beliefs, Closed(1, 10'000), "",
                    "Maximum number of beliefs kept in a state. Lower values make states smaller "
                    "and updates faster, but lose places that were unlikely at first."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// What an image says about one node.
struct NodeEvidence {
  double log_likelihood = 0;  // of the image at this node, up to a constant; -infinity: impossible
  double heading_rad = 0;     // the robot's heading in the graph's frame if it is there
  double sigma_rad = 0.1;     // of that heading, above 0
};

struct Belief {
  int node = 0;
  double probability = 0;
  double heading_rad = 0;  // in the graph's frame
  double sigma_rad = 0;

  bool operator==(const Belief&) const = default;
};

// What is known after some images: the likeliest nodes, the likeliest first (ties by node). The
// next update needs nothing else; the probability missing from 1 may be anywhere.
using FilterState = std::vector<Belief>;

struct FilterAnswer {
  FilterState state;  // the first is the answer; never empty
};

// The probability that a robot has come to another place: the distance that it moved over
// position_sigma, at most 1; a robot that moved less may have stayed at its node. Pure;
// thread-safe.
double ShareMoved(const Pose2& odometry, const GraphFilterOptions& options);

// The belief after an image. `poses` are graph_from_node, `evidence[i]` is of node i. `previous` is
// the state before (empty for the first image), `odometry` previous_from_now where it is known. A
// belief that odometry takes farther than three sigmas from all nodes has left the graph and may be
// anywhere. `heights` are those of the nodes, in the poses' unit, NaN where unknown; empty where
// none is known. Odometry doesn't know floors, so a robot stays on its own. Takes time proportional
// to nodes times beliefs. Pure; thread-safe. Throws MapError: kBadOptions; kBadRequest when the
// previous state names nodes that aren't there or isn't made of probabilities, or when the image is
// impossible everywhere. Having no nodes, or not one evidence per node, is a programmer's error.
FilterAnswer UpdateBelief(const std::vector<Pose2>& poses,
                          const std::vector<NodeEvidence>& evidence, const FilterState& previous,
                          const std::optional<Pose2>& odometry,
                          const GraphFilterOptions& options = {},
                          const std::vector<double>& heights = {});

}  // namespace waystone
