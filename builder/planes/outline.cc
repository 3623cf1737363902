// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/outline.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "builder/planes/plane_features.h"
#include "core/homography/homography.h"
#include "schema/layers/planes/surfaces.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Points = std::vector<Vector2d>;

// The longest edge of an outline that isn't peeled off, as a share of the reference image's longer
// side.
constexpr double kLongestEdge = 0.3;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

std::vector<cv::Point2f> InSinglePrecision(const Points& points) {
  std::vector<cv::Point2f> result;
  for (const Vector2d& p : points) {
    result.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  return result;
}

// Rounds points for the triangulation, which can't distinguish points that nearly coincide; none
// lies far from a reference image.
std::vector<cv::Point2f> OnGrid(const Points& points) {
  constexpr double kUnitsPerPx = 16;
  constexpr double kFarthest_px = 1e5;
  std::vector<cv::Point2f> result;
  for (const Vector2d& p : points) {
    if (!(p.cwiseAbs().maxCoeff() < kFarthest_px)) continue;
    result.emplace_back(static_cast<float>(std::round(p.x() * kUnitsPerPx) / kUnitsPerPx),
                        static_cast<float>(std::round(p.y() * kUnitsPerPx) / kUnitsPerPx));
  }
  return result;
}

// Three corners, by their number, anticlockwise.
using Triangle = std::array<int, 3>;
using HalfEdge = std::pair<int, int>;

// A triangulation from which triangles are removed.
class Shape {
 public:
  explicit Shape(const Points& points) {
    const std::vector<cv::Point2f> all = OnGrid(points);
    if (all.size() < 3) return;
    const cv::Rect around = cv::boundingRect(all);
    cv::Subdiv2D subdivision(
        cv::Rect(around.tl() - cv::Point(1, 1), around.size() + cv::Size(2, 2)));
    std::map<std::pair<float, float>, int> number;
    for (const cv::Point2f& p : all) {
      if (!number.emplace(std::pair(p.x, p.y), static_cast<int>(at_.size())).second) continue;
      at_.emplace_back(p.x, p.y);
      subdivision.insert(p);
    }
    std::vector<cv::Vec6f> found;
    subdivision.getTriangleList(found);
    for (const cv::Vec6f& t : found) Take(t, number);
    on_border_.assign(at_.size(), 0);
    for (const auto& [edge, triangle] : of_edge_) {
      if (IsBorder(edge)) ++on_border_[static_cast<size_t>(edge.first)];
    }
  }

  bool empty() const { return triangles_.empty(); }

  // Marks the triangles that hold one of these points.
  void Contradict(const Points& others) {
    contradicted_.assign(triangles_.size(), 0);
    for (const Vector2d& x : others) {
      for (size_t t = 0; t < triangles_.size(); ++t) {
        if (Holds(triangles_[t], x)) contradicted_[t] = 1;
      }
    }
  }

  void Peel(double longest_edge) {
    // Longest first; for equal lengths the edge with the higher corners.
    std::priority_queue<std::tuple<double, HalfEdge>> queue;
    const auto consider = [&](const HalfEdge& edge) {
      const double length = (At(edge.first) - At(edge.second)).norm();
      if (length > longest_edge || contradicted_[of_edge_.at(edge)]) queue.emplace(length, edge);
    };
    for (const auto& [edge, triangle] : of_edge_) {
      if (IsBorder(edge)) consider(edge);
    }
    while (!queue.empty()) {
      const HalfEdge edge = std::get<1>(queue.top());
      queue.pop();
      const auto found = of_edge_.find(edge);
      if (found == of_edge_.end()) continue;
      const Triangle& triangle = triangles_[found->second];
      const int apex = Apex(triangle, edge);
      // With its apex on the border, the triangle is the only connection of two parts, or the only
      // triangle of a corner.
      if (on_border_[static_cast<size_t>(apex)] > 0) continue;
      Remove(found->second);
      // The border now passes through the apex.
      ++on_border_[static_cast<size_t>(apex)];
      consider({edge.first, apex});
      consider({apex, edge.second});
    }
  }

  // Removes the contradicted triangles in the interior that don't touch the border.
  void CutHoles() {
    for (size_t t = 0; t < triangles_.size(); ++t) {
      const Triangle& triangle = triangles_[t];
      if (!contradicted_[t] || !of_edge_.contains({triangle[0], triangle[1]})) continue;
      const bool inside = std::ranges::none_of(
          triangle, [&](int corner) { return on_border_[static_cast<size_t>(corner)] > 0; });
      if (inside) Remove(t);
    }
  }

  // The borders, the one around everything first.
  std::vector<Points> Rings() const {
    std::map<int, std::vector<int>> next;  // along the border
    for (const auto& [edge, triangle] : of_edge_) {
      if (IsBorder(edge)) next[edge.first].push_back(edge.second);
    }
    std::vector<Points> rings;
    while (!next.empty()) rings.push_back(TakeRing(next));
    std::ranges::sort(rings, std::greater<>(), AreaOf);
    return rings;
  }

  static double AreaOf(const Points& ring) {
    double twice = 0;
    for (size_t i = 0; i < ring.size(); ++i) twice += Cross(ring[i], ring[(i + 1) % ring.size()]);
    return 0.5 * twice;
  }

 private:
  const Vector2d& At(int corner) const { return at_[static_cast<size_t>(corner)]; }
  // Each triangle has its three edges anticlockwise: the border consists of those whose reverse has
  // no triangle.
  bool IsBorder(const HalfEdge& edge) const {
    return !of_edge_.contains({edge.second, edge.first});
  }

  void Take(const cv::Vec6f& t, const std::map<std::pair<float, float>, int>& number) {
    Triangle triangle;
    for (int i = 0; i < 3; ++i) {
      const auto corner = number.find({t[2 * i], t[2 * i + 1]});
      if (corner == number.end()) return;  // one of those that stand for infinity
      triangle[static_cast<size_t>(i)] = corner->second;
    }
    const double area = Cross(At(triangle[1]) - At(triangle[0]), At(triangle[2]) - At(triangle[0]));
    if (area == 0) return;
    if (area < 0) std::swap(triangle[1], triangle[2]);
    for (int i = 0; i < 3; ++i) {
      of_edge_[{triangle[static_cast<size_t>(i)], triangle[static_cast<size_t>((i + 1) % 3)]}] =
          triangles_.size();
    }
    triangles_.push_back(triangle);
  }

  bool Holds(const Triangle& triangle, const Vector2d& x) const {
    for (size_t i = 0; i < 3; ++i) {
      const Vector2d& a = At(triangle[i]);
      if (!(Cross(At(triangle[(i + 1) % 3]) - a, x - a) >= 0)) return false;
    }
    return true;
  }

  static int Apex(const Triangle& triangle, const HalfEdge& edge) {
    for (const int corner : triangle) {
      if (corner != edge.first && corner != edge.second) return corner;
    }
    return -1;
  }

  void Remove(size_t t) {
    const Triangle& triangle = triangles_[t];
    for (size_t i = 0; i < 3; ++i) of_edge_.erase({triangle[i], triangle[(i + 1) % 3]});
  }

  // Where rings touch at a corner, the sharpest turn to the right keeps them apart.
  Points TakeRing(std::map<int, std::vector<int>>& next) const {
    Points ring;
    const int start = next.begin()->first;
    int before = -1;
    int here = start;
    do {
      ring.push_back(At(here));
      const auto out = next.find(here);
      if (out == next.end()) break;
      std::vector<int>& choices = out->second;
      size_t best = 0;
      for (size_t i = 1; i < choices.size() && before >= 0; ++i) {
        if (Turn(before, here, choices[i]) < Turn(before, here, choices[best])) best = i;
      }
      const int there = choices[best];
      choices.erase(choices.begin() + static_cast<std::ptrdiff_t>(best));
      if (choices.empty()) next.erase(out);
      before = here;
      here = there;
    } while (here != start);
    return ring;
  }

  // The angle by which a path turns to the left, -pi to pi.
  double Turn(int before, int here, int there) const {
    const Vector2d in = At(here) - At(before);
    const Vector2d out = At(there) - At(here);
    return std::atan2(Cross(in, out), in.dot(out));
  }

  Points at_;
  std::vector<Triangle> triangles_;
  std::vector<char> contradicted_;
  std::map<HalfEdge, size_t> of_edge_;  // the triangle on its left
  std::vector<int> on_border_;          // of each corner: border edges that start there
};

// Joins a hole to a ring by a cut between their nearest corners.
void JoinHole(const Points& hole, Points& ring) {
  size_t from = 0;
  size_t to = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (size_t r = 0; r < ring.size(); ++r) {
    for (size_t h = 0; h < hole.size(); ++h) {
      const double distance = (ring[r] - hole[h]).squaredNorm();
      if (distance < nearest) std::tie(nearest, from, to) = std::tuple(distance, r, h);
    }
  }
  Points detour;
  for (size_t h = 0; h <= hole.size(); ++h) detour.push_back(hole[(to + h) % hole.size()]);
  detour.push_back(ring[from]);
  ring.insert(ring.begin() + static_cast<std::ptrdiff_t>(from) + 1, detour.begin(), detour.end());
}

}  // namespace

Points ConvexHull(const Points& points) {
  const std::vector<cv::Point2f> all = InSinglePrecision(points);
  std::vector<cv::Point2f> hull;
  if (!all.empty()) cv::convexHull(all, hull);
  Points corners;
  for (const cv::Point2f& p : hull) corners.emplace_back(p.x, p.y);
  return corners;
}

std::vector<int> FeaturesInsideHull(const Plane& plane, const Matrix3d& to_from,
                                    const Points& points) {
  const std::vector<cv::Point2f> hull = InSinglePrecision(ConvexHull(points));
  std::vector<int> inside;
  for (int f = 0; f < static_cast<int>(plane.features.size()); ++f) {
    const Vector2d x = PositionOf(plane.features[f].reference);
    if (!IsInFront(to_from, x)) continue;
    const Eigen::Vector2f there = Apply(to_from, x).cast<float>();
    if (there.allFinite() && cv::pointPolygonTest(hull, {there.x(), there.y()}, false) >= 0) {
      inside.push_back(f);
    }
  }
  return inside;
}

Points SupportedPolygon(const Points& points, const Points& others, double longest_edge) {
  Shape shape(points);
  if (shape.empty()) return ConvexHull(points);
  shape.Contradict(others);
  shape.Peel(longest_edge);
  shape.CutHoles();
  std::vector<Points> rings = shape.Rings();
  Points outline = std::move(rings.front());
  for (size_t r = 1; r < rings.size(); ++r) {
    if (Shape::AreaOf(rings[r]) < 0) JoinHole(rings[r], outline);
  }
  return outline;
}

void OutlinePlanes(MapData& map) {
  const std::vector<PlaneId> surface = FindSurfaces(map.planes, map.edges);
  std::unordered_map<KeyframeId, std::vector<std::pair<size_t, const PlaneView*>>> seen;
  for (size_t p = 0; p < map.planes.size(); ++p) {
    for (const PlaneView& view : map.planes[p].views) seen[view.keyframe].emplace_back(p, &view);
  }
  const auto outline = [&](size_t p) {
    const Plane& plane = map.planes[p];
    Points others;
    for (const auto& [q, view] : seen.at(plane.reference)) {
      if (surface[q] == surface[p]) continue;
      const Matrix3d keyframe_from_reference = view->reference_from_keyframe.inverse();
      for (const Vector2d& x : PositionsOf(map.planes[q])) {
        if (!IsInFront(keyframe_from_reference, x)) continue;
        others.push_back(Apply(keyframe_from_reference, x));
      }
    }
    const Keyframe& reference =
        *std::ranges::lower_bound(map.keyframes, plane.reference, {}, &Keyframe::id);
    return SupportedPolygon(PositionsOf(plane), others,
                            kLongestEdge * std::max(reference.width, reference.height));
  };
  std::vector<Points> outlines(map.planes.size());
  tbb::parallel_for(size_t{0}, map.planes.size(), [&](size_t p) { outlines[p] = outline(p); });
  for (size_t p = 0; p < map.planes.size(); ++p) map.planes[p].outline = std::move(outlines[p]);
}

}  // namespace waystone
