// SPDX-License-Identifier: Apache-2.0
#include "builder/report/graph_layout.h"

#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/fruchterman_reingold.hpp>
#include <boost/graph/topology.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <unordered_map>

namespace waystone {
namespace {

using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS>;
using Topology = boost::rectangle_topology<std::minstd_rand>;
using Point = Topology::point_type;

// Rounds of the layout: its temperature falls to nothing over them.
constexpr int kRounds = 300;

Graph GraphOf(const MapData& map) {
  Graph graph(map.planes.size());
  std::unordered_map<PlaneId, size_t> row;
  for (size_t i = 0; i < map.planes.size(); ++i) row[map.planes[i].id] = i;
  for (const Edge& edge : map.edges) boost::add_edge(row.at(edge.a), row.at(edge.b), graph);
  return graph;
}

// A start that depends on nothing but the number of planes: a spiral, in the order of their ids,
// which is the order in which the camera met them.
std::vector<Point> Spiral(size_t count) {
  std::vector<Point> points(count);
  for (size_t i = 0; i < count; ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) * (std::numbers::phi - 1);
    points[i][0] = 0.5 * std::sqrt(share) * std::cos(angle);
    points[i][1] = 0.5 * std::sqrt(share) * std::sin(angle);
  }
  return points;
}

std::vector<Eigen::Vector2d> FitToUnitSquare(const std::vector<Point>& points) {
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9);
  Eigen::Array2d high = Eigen::Array2d::Constant(-1e9);
  for (const Point& p : points) {
    low = low.min(Eigen::Array2d(p[0], p[1]));
    high = high.max(Eigen::Array2d(p[0], p[1]));
  }
  const Eigen::Array2d size = (high - low).max(1e-9);
  std::vector<Eigen::Vector2d> fitted;
  for (const Point& p : points) {
    const bool single = points.size() == 1;
    fitted.emplace_back(single ? Eigen::Array2d(0.5, 0.5) : (Eigen::Array2d(p[0], p[1]) - low) / size);
  }
  return fitted;
}

}  // namespace

std::vector<Eigen::Vector2d> LayOutGraph(const MapData& map) {
  if (map.planes.empty()) return {};
  const Graph graph = GraphOf(map);
  std::vector<Point> points = Spiral(map.planes.size());
  std::minstd_rand engine(1);
  const Topology topology(engine, -0.5, -0.5, 0.5, 0.5);
  const auto positions =
      boost::make_iterator_property_map(points.begin(), boost::get(boost::vertex_index, graph));
  boost::fruchterman_reingold_force_directed_layout(
      graph, positions, topology,
      boost::cooling(boost::linear_cooling<double>(kRounds, 0.1))
          .force_pairs(boost::all_force_pairs()));
  return FitToUnitSquare(points);
}

}  // namespace waystone
