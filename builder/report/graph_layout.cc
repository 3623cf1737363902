// SPDX-License-Identifier: Apache-2.0
#include "builder/report/graph_layout.h"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/circle_layout.hpp>
#include <boost/graph/connected_components.hpp>
#include <boost/graph/fruchterman_reingold.hpp>
#include <boost/graph/kamada_kawai_spring_layout.hpp>
#include <boost/graph/topology.hpp>
#include <cmath>
#include <random>

namespace waystone {
namespace {

using Weight = boost::property<boost::edge_weight_t, double>;
using Graph =
    boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS, boost::no_property, Weight>;
using Square = boost::square_topology<std::minstd_rand>;
using SquarePoint = Square::point_type;

// Springs between all pairs give the clearer picture, at a cost that grows with the cube of the
// number of nodes; beyond this many, forces between neighbours have to do.
constexpr size_t kMostSprings = 400;
// Share by which the springs' energy changes in a step when they count as at rest.
constexpr double kAtRest = 1e-4;
// Steps of the springs per node: some graphs oscillate between two layouts forever.
constexpr size_t kMostStepsPerNode = 1000;
// Rounds of forces: their temperature falls to nothing over them.
constexpr int kForceRounds = 200;
// Room between two parts of the graph, as a share of the smallest part's width.
constexpr double kComponentGap = 0.25;

using Pairs = std::vector<std::pair<size_t, size_t>>;

// A connected part of the graph: its nodes, its edges (between indices of `rows`), and where the
// nodes are, in [0, 1] x [0, 1].
struct Part {
  std::vector<size_t> rows;
  Pairs edges;
  std::vector<Eigen::Vector2d> at;
  double width() const { return std::sqrt(static_cast<double>(rows.size())); }
};

// Ends the springs' steps.
class SpringsEnd {
 public:
  explicit SpringsEnd(size_t nodes) : steps_left_(kMostStepsPerNode * nodes) {}

  template <typename Node>
  bool operator()(double change, Node node, const Graph& graph, bool global) {
    if (steps_left_ == 0) return true;
    --steps_left_;
    return at_rest_(change, node, graph, global);
  }

 private:
  boost::layout_tolerance<double> at_rest_{kAtRest};
  size_t steps_left_;
};

// The largest part first.
std::vector<Part> FindParts(size_t count, const Pairs& edges) {
  Graph graph(count);
  for (const auto& [a, b] : edges) boost::add_edge(a, b, 1.0, graph);
  std::vector<size_t> part_of(count);
  std::vector<Part> parts(static_cast<size_t>(boost::connected_components(graph, part_of.data())));
  std::vector<size_t> index_in_part(count);
  for (size_t i = 0; i < count; ++i) {
    index_in_part[i] = parts[part_of[i]].rows.size();
    parts[part_of[i]].rows.push_back(i);
  }
  for (const auto& [a, b] : edges) {
    parts[part_of[a]].edges.emplace_back(index_in_part[a], index_in_part[b]);
  }
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Part& a, const Part& b) { return a.rows.size() > b.rows.size(); });
  return parts;
}

std::vector<Eigen::Vector2d> FitToUnitSquare(const std::vector<SquarePoint>& points) {
  Eigen::Array2d low = Eigen::Array2d(points[0][0], points[0][1]);
  Eigen::Array2d high = low;
  for (const SquarePoint& p : points) {
    low = low.min(Eigen::Array2d(p[0], p[1]));
    high = high.max(Eigen::Array2d(p[0], p[1]));
  }
  const Eigen::Array2d size = high - low;
  std::vector<Eigen::Vector2d> fitted;
  for (const SquarePoint& p : points) {
    Eigen::Array2d at(0.5, 0.5);
    for (int i = 0; i < 2; ++i) {
      if (size[i] > 0) at[i] = (p[static_cast<size_t>(i)] - low[i]) / size[i];
    }
    fitted.emplace_back(at);
  }
  return fitted;
}

void LayOut(Part& part) {
  Graph graph(part.rows.size());
  for (const auto& [a, b] : part.edges) boost::add_edge(a, b, 1.0, graph);
  std::vector<SquarePoint> points(part.rows.size());
  const auto positions =
      boost::make_iterator_property_map(points.begin(), boost::get(boost::vertex_index, graph));
  boost::circle_graph_layout(graph, positions, 0.5);
  std::minstd_rand engine(1);
  const Square square(engine, 1.0);
  if (part.rows.size() > kMostSprings) {
    boost::fruchterman_reingold_force_directed_layout(
        graph, positions, square,
        boost::cooling(boost::linear_cooling<double>(kForceRounds, 0.1))
            .force_pairs(boost::make_grid_force_pairs(square, positions, graph)));
  } else if (part.rows.size() > 1) {
    boost::kamada_kawai_spring_layout(graph, positions, boost::get(boost::edge_weight, graph),
                                      square, boost::side_length(1.0),
                                      SpringsEnd(part.rows.size()));
  }
  part.at = FitToUnitSquare(points);
}

}  // namespace

std::vector<Eigen::Vector2d> LayOutGraph(size_t nodes, const Pairs& edges) {
  std::vector<Eigen::Vector2d> at(nodes);
  if (nodes == 0) return at;
  std::vector<Part> parts = FindParts(nodes, edges);
  const double gap = kComponentGap * parts.back().width();
  double total = gap * static_cast<double>(parts.size() - 1);
  for (const Part& part : parts) total += part.width();
  // Side by side: each part as wide as it has to be, and as high as it is wide or the page allows.
  const double tallest = parts.front().width();
  double x = 0;
  for (Part& part : parts) {
    LayOut(part);
    const double height = part.width() / tallest;
    for (size_t i = 0; i < part.rows.size(); ++i) {
      at[part.rows[i]] = {(x + part.at[i].x() * part.width()) / total,
                          0.5 + (part.at[i].y() - 0.5) * height};
    }
    x += part.width() + gap;
  }
  return at;
}

}  // namespace waystone
