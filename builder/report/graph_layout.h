// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace waystone {

// Where to draw each of `nodes` nodes of a graph, in [0, 1] x [0, 1]: neighbours near each other.
// An edge names two different nodes, from 0. The same graph gives the same picture. Thread-safe.
std::vector<Eigen::Vector2d> LayOutGraph(size_t nodes,
                                         const std::vector<std::pair<size_t, size_t>>& edges);

}  // namespace waystone
