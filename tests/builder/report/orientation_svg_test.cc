// SPDX-License-Identifier: Apache-2.0
#include "builder/report/orientation_svg.h"

#include <gtest/gtest.h>

#include "builder/report/html.h"

namespace waystone {
namespace {

size_t Count(const std::string& text, const std::string& what) {
  size_t count = 0;
  for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

OrientationFrame FrameAt(int64_t id, int64_t sequence, int frame, bool reliable) {
  OrientationFrame made;
  made.id = OrientationFrameId{id};
  made.sequence = SequenceId{sequence};
  made.frame = frame;
  made.source = "<" + std::to_string(frame) + ">.jpg";
  made.reliable = reliable;
  made.lines = {40, 20, 30};
  if (reliable) made.rotation.emplace();
  if (!reliable) return made;
  Eigen::Matrix3d upright;  // looks along the building's x
  upright << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  made.rotation->building_from_rig = Eigen::Quaterniond(upright);
  return made;
}

// Ten frames of one sequence with a turn, a false one, a corridor and a loop, and two of another.
OrientationLayer MadeLayer() {
  OrientationLayer layer;
  for (int i = 0; i < 10; ++i) layer.frames.push_back(FrameAt(i + 1, 1, i, i != 5));
  for (int i = 0; i < 2; ++i) layer.frames.push_back(FrameAt(i + 11, 2, i, true));
  layer.turns = {{OrientationFrameId{4}, 1, 1.5, true, 1},
                 {OrientationFrameId{8}, -1, -1.5, false, 1}};
  layer.nodes = {{OrientationFrameId{1}, OrientationNodeKind::kTraversable, {4, 1, 2, 8}, {}},
                 {OrientationFrameId{4}, OrientationNodeKind::kTurn, {0, 0, 0, 0}, {}},
                 {OrientationFrameId{6}, OrientationNodeKind::kTraversable, {}, {}},
                 {OrientationFrameId{11}, OrientationNodeKind::kTraversable, {}, {}}};
  layer.edges = {{OrientationFrameId{1}, OrientationFrameId{4}, OrientationEdgeKind::kLoop, 50},
                 {OrientationFrameId{4}, OrientationFrameId{11}, OrientationEdgeKind::kLoop, 50}};
  layer.corridors = {{OrientationFrameId{1}, OrientationFrameId{3}, 0}};
  return layer;
}

TEST(OrientationMapSvg, DrawsOneSequenceByKind) {
  const std::string svg = OrientationMapSvg(MadeLayer(), SequenceId{1});
  EXPECT_EQ(Count(svg, "<circle"), 4U);  // three nodes and the false turn
  EXPECT_EQ(Count(svg, "fill=\"#d6454f\""), 1U) << "a red turn";
  EXPECT_EQ(Count(svg, "fill=\"#2b9348\""), 2U) << "green nodes";
  EXPECT_EQ(Count(svg, "stroke=\"#3a78d8\""), 1U) << "a blue false turn";
  EXPECT_EQ(Count(svg, "stroke:#e08214"), 1U) << "the loop within the sequence";
  EXPECT_EQ(Count(svg, "<polyline"), 2U) << "the way and a corridor";
  EXPECT_NE(svg.find("turn: &lt;3&gt;.jpg"), std::string::npos) << svg;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  const std::string other = OrientationMapSvg(MadeLayer(), SequenceId{2});
  EXPECT_EQ(Count(other, "<circle"), 1U);
}

TEST(OrientationPlotSvg, HasAHeadingAFrameAndACurveAnAxis) {
  const std::string svg = OrientationPlotSvg(MadeLayer(), SequenceId{1});
  EXPECT_EQ(Count(svg, "<circle"), 9U) << "a frame has no rotation";
  EXPECT_EQ(Count(svg, "<polyline"), 3U);
  EXPECT_EQ(Count(svg, "<rect"), 2U) << "the corridor in both panels";
  EXPECT_EQ(Count(svg, "stroke:#d6454f"), 2U) << "the turn in both panels";
  EXPECT_EQ(Count(svg, "stroke:#3a78d8"), 2U);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(Count(OrientationPlotSvg(MadeLayer(), SequenceId{2}), "<circle"), 2U);
}

TEST(DirectionCellsSvg, ShadesByTheCounts) {
  const std::string svg = DirectionCellsSvg(MadeLayer().nodes[0]);
  EXPECT_EQ(Count(svg, "<polygon"), 4U);
  EXPECT_NE(svg.find("fill-opacity=0.75"), std::string::npos) << "the left cell has most";
  EXPECT_NE(svg.find(">left<"), std::string::npos);
  EXPECT_EQ(DirectionCellsSvg(MadeLayer().nodes[1]).find("nan"), std::string::npos);
}

TEST(OrientationReport, HasTheSectionsOfEachSequence) {
  MapData map;
  map.orientation = MadeLayer();
  const std::string page = ReportHtml(map, {}, {});
  EXPECT_NE(page.find("12 directions, 1 turns"), std::string::npos);
  EXPECT_NE(page.find("Trajectory by turns, sequence 2"), std::string::npos);
  EXPECT_EQ(Count(page, "<svg class=cells"), 3U) << "none of the frame without a rotation";
  EXPECT_EQ(SequencesOf(*map.orientation).size(), 2U);
  EXPECT_EQ(ReportHtml({}, {}, {}).find("Trajectory by turns"), std::string::npos);
}

}  // namespace
}  // namespace waystone
