// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/image/encode.h"
#include "schema/file/map_problems.h"
#include "schema/file/map_store.h"
#include "schema/layers/floor_plans/floor_plan.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

constexpr int kWidth = 60;
constexpr int kHeight = 40;
constexpr double kNoPlanNumber = std::numeric_limits<double>::quiet_NaN();

std::vector<uint8_t> PlanImageBytes() {
  return EncodeJpeg(cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(240)));
}

// A plan as an architect draws it: turned, scaled and moved, rows counted downwards.
struct Drawing {
  double angle_rad = 0;
  double px_per_unit = 1;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // px

  Eigen::Vector2d Of(const Eigen::Vector2d& at) const {
    const double c = std::cos(angle_rad), s = std::sin(angle_rad);
    return origin +
           px_per_unit * Eigen::Vector2d(c * at.x() - s * at.y(), -(s * at.x() + c * at.y()));
  }
};

std::vector<PlanAnchor> AnchorsOf(const Drawing& drawing,
                                  const std::vector<Eigen::Vector2d>& points) {
  std::vector<PlanAnchor> anchors;
  for (const Eigen::Vector2d& at : points) anchors.push_back({drawing.Of(at), at});
  return anchors;
}

const Drawing kDrawing{0.1, 5, {10, 30}};
const std::vector<Eigen::Vector2d> kPoints{{0, 0}, {6, 0}, {6, 3}};

FloorPlanImage MakePlan(const std::string& name) {
  return {name, kWidth, kHeight, AnchorsOf(kDrawing, kPoints), {}, PlanImageBytes()};
}

MapData PlannedMap() {
  MapData map = MadeMap(5);
  map.floor_plans = {MakePlan("Erdgeschoß"), MakePlan("Ground")};
  map.floor_plans[1].heights = PlanHeights{-0.5, 2.5};
  return map;
}

std::string FirstProblem(const MapData& map) {
  const std::vector<MapProblem> problems = FindMapProblems(map);
  return problems.empty() ? "" : problems[0].where + ": " + problems[0].message;
}

TEST(FloorPlans, AreFittedExactlyToAnchorsOfADrawingToScale) {
  Random random(7);
  for (int run = 0; run < 200; ++run) {
    const Drawing drawing{random.Uniform(-3.1, 3.1),
                          std::exp(random.Uniform(-3, 6)),
                          {random.Uniform(-500, 500), random.Uniform(-500, 500)}};
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < 2 + run % 4; ++i) {
      points.emplace_back(random.Uniform(-40, 40), random.Uniform(-40, 40));
    }
    const PlanFit fit = FitPlan(AnchorsOf(drawing, points));
    EXPECT_NEAR(fit.px_per_unit / drawing.px_per_unit, 1, 1e-9);
    EXPECT_LT(fit.residual_px, 1e-8 * (1 + drawing.px_per_unit * 80));
    const Eigen::Vector2d at(random.Uniform(-99, 99), random.Uniform(-99, 99));
    EXPECT_LT((fit.Of(at) - drawing.Of(at)).norm(), 1e-6 * (1 + drawing.px_per_unit)) << run;
  }
}

// Errors of the anchors are stated, and the fit is better than any nearby.
TEST(FloorPlans, AreFittedByLeastSquares) {
  std::vector<PlanAnchor> anchors =
      AnchorsOf({0.4, 20, {300, 200}}, {{0, 0}, {10, 0}, {10, 6}, {0, 6}});
  anchors[2].px += Eigen::Vector2d(8, 0);
  const PlanFit fit = FitPlan(anchors);
  EXPECT_GT(fit.residual_px, 1);
  EXPECT_LT(fit.residual_px, 4);
  const auto cost = [&anchors](const PlanFit& tried) {
    double sum = 0;
    for (const PlanAnchor& anchor : anchors) sum += (tried.Of(anchor.at) - anchor.px).squaredNorm();
    return sum;
  };
  EXPECT_NEAR(std::sqrt(cost(fit) / 4), fit.residual_px, 1e-9);
  for (const double step : {-1e-3, 1e-3}) {
    PlanFit turned = fit, scaled = fit, moved = fit;
    turned.plan_from_frame.leftCols<2>() =
        Eigen::Rotation2Dd(step).toRotationMatrix() * fit.plan_from_frame.leftCols<2>();
    scaled.plan_from_frame.leftCols<2>() *= 1 + step;
    moved.plan_from_frame.col(2) += Eigen::Vector2d(step, -step);
    for (const PlanFit& other : {turned, scaled, moved}) EXPECT_GT(cost(other), cost(fit));
  }
}

TEST(FloorPlans, AnchorsThatFixNoPlanAreNamed) {
  const auto problem = [](const std::vector<PlanAnchor>& anchors) {
    return FindAnchorProblem(anchors, kWidth, kHeight).value_or("");
  };
  const std::vector<PlanAnchor> good = AnchorsOf(kDrawing, kPoints);
  EXPECT_EQ(problem(good), "");
  EXPECT_EQ(problem({good[0], good[1]}), "");
  const auto expect = [&](const std::vector<PlanAnchor>& anchors, const std::string& about) {
    EXPECT_NE(problem(anchors).find(about), std::string::npos) << about << ": " << problem(anchors);
  };
  expect({good[0]}, "1 anchors; 2 to 100");
  expect(std::vector<PlanAnchor>(101, good[0]), "101 anchors");
  expect({good[0], {{kWidth + 1, 3}, {1, 1}}}, "outside of the image of 60x40 px");
  expect({good[0], {{3, -0.1}, {1, 1}}}, "outside");
  expect({good[0], {{kNoPlanNumber, 3}, {1, 1}}}, "outside");
  expect({good[0], {{3, 3}, {1, 2e9}}}, "beyond 1e9");
  expect({good[0], {{3, 3}, {kNoPlanNumber, 1}}}, "beyond 1e9");
  expect({good[0], good[0]}, "same point of the image");
  expect({good[0], {{3, 3}, good[0].at}}, "same point of the map");
  expect({good[0], good[1], good[1]}, "same point of the image");
  expect(AnchorsOf(kDrawing, {{0, 0}, {3, 0}, {6, 0}}), "on one line of the image");
  std::vector<PlanAnchor> flat = good;
  flat[2].at = {3, 0};
  expect(flat, "on one line of the map");
  std::vector<PlanAnchor> mirrored = good;
  for (PlanAnchor& anchor : mirrored) anchor.at.y() = -anchor.at.y();
  expect(mirrored, "mirrored");
  std::vector<PlanAnchor> off = good;
  off[2].at = {1, 3};
  expect(off, "don't fit a plan that is drawn to scale");
}

TEST(FloorPlans, ImagesAreInspected) {
  const PlanImageSize size = InspectPlanImage(PlanImageBytes());
  EXPECT_EQ(size.problem, "");
  EXPECT_EQ(size.width, kWidth);
  EXPECT_EQ(size.height, kHeight);
  EXPECT_STREQ(MediaTypeOf(PlanImageBytes()), "image/jpeg");
  std::vector<uint8_t> cut = PlanImageBytes();
  cut.resize(cut.size() / 2);
  EXPECT_NE(InspectPlanImage(cut).problem, "");
  EXPECT_NE(InspectPlanImage({}).problem, "");
  const std::string pnm = "P5 2 2 255\nabcd";
  const std::vector<uint8_t> bytes(pnm.begin(), pnm.end());
  EXPECT_NE(InspectPlanImage(bytes).problem.find("pnm; save it as PNG"), std::string::npos);
  std::vector<uint8_t> large = PlanImageBytes();
  large.resize(kMaxPlanImageBytes + 1);
  EXPECT_NE(InspectPlanImage(large).problem.find("at most 8000000"), std::string::npos);
}

TEST(FloorPlans, AreWrittenAndRead) {
  const TemporaryFolder folder;
  const MapData map = PlannedMap();
  WriteMap(map, folder / "m.db", {});
  EXPECT_EQ(ReadMap(folder / "m.db").floor_plans, map.floor_plans);
  EXPECT_TRUE(CheckMap(folder / "m.db").empty());
  WriteMap(map, folder / "again.db", {});
  EXPECT_EQ(ReadFile(folder / "m.db"), ReadFile(folder / "again.db"));
  std::vector<FloorPlanImage> plain = map.floor_plans;
  for (FloorPlanImage& plan : plain) plan.image.clear();
  EXPECT_EQ(ReadMap(folder / "m.db", {.images = false}).floor_plans, plain);
}

TEST(FloorPlans, LeaveNoTraceInMapsWithoutThem) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "m.db";
  WriteMap(MadeMap(5), path, {});
  EXPECT_EQ(ReadFile(path).find("floor_plans"), std::string::npos);
  MapData map = ReadMap(path);
  map.floor_plans = PlannedMap().floor_plans;
  RewriteOptionalTables(map, path);
  EXPECT_EQ(ReadMap(path).floor_plans, map.floor_plans);
  MapData without = ReadMap(path);
  without.floor_plans.clear();
  RewriteOptionalTables(without, path);
  EXPECT_EQ(ReadFile(path).find("floor_plans"), std::string::npos);
  EXPECT_EQ(WithoutVersion(ReadMap(path)), MadeMap(5));
}

TEST(FloorPlans, ThatWereTamperedWithAreFound) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"UPDATE floor_plans SET name = 'x' WHERE id = 1", "floor_plans: its values have CRC-32C"},
      {"UPDATE floor_plans SET image = zeroblob(9)", "floor_plans 1: image"},
      {"UPDATE floor_plans SET high = NULL", "floor_plans 2: low and high"},
      {"UPDATE floor_plans SET anchor_count = 1000", "floor_plans 1: anchor_count"},
      {"UPDATE floor_plans SET width = 0", "floor_plans 1: width"},
      {"DROP TABLE floor_plans; VACUUM", "floor_plans: this table is missing"}};
  for (const auto& [sql, problem] : cases) {
    const TemporaryFolder folder;
    WriteMap(PlannedMap(), folder / "m.db", {});
    RunSql(folder / "m.db", sql);
    const std::vector<MapProblem> problems = CheckMap(folder / "m.db");
    const bool found = std::ranges::any_of(problems, [&problem = problem](const MapProblem& one) {
      return (one.where + ": " + one.message).starts_with(problem);
    });
    EXPECT_TRUE(found) << sql << ": " << (problems.empty() ? "" : problems[0].message);
    EXPECT_EQ(ErrorOf([&] { ReadMap(folder / "m.db"); }).code(), ErrorCode::kMapDamaged) << sql;
  }
}

TEST(FloorPlans, MustFitTheMap) {
  EXPECT_EQ(FirstProblem(PlannedMap()), "");
  const auto expect = [](const std::function<void(MapData&)>& damage, const std::string& about) {
    MapData map = PlannedMap();
    damage(map);
    EXPECT_NE(FirstProblem(map).find(about), std::string::npos)
        << about << ": " << FirstProblem(map);
  };
  expect([](MapData& map) { std::swap(map.floor_plans[0], map.floor_plans[1]); }, "in order");
  expect([](MapData& map) { map.floor_plans[1].name = map.floor_plans[0].name; }, "in order");
  expect([](MapData& map) { map.floor_plans[0].name = "a\n"; }, "control character");
  expect([](MapData& map) { map.floor_plans[0].anchors.resize(1); }, "1 anchors");
  expect([](MapData& map) { map.floor_plans[1].heights = PlanHeights{2, 2}; }, "no range");
  expect(
      [](MapData& map) {
        map.floor_plans[1].heights = PlanHeights{0, kNoPlanNumber};
      },
      "no range");
  expect([](MapData& map) { ++map.floor_plans[0].width; }, "60x40 px; expected 61x40 px");
  expect([](MapData& map) { map.floor_plans[0].image.resize(40); }, "its image");
  expect([](MapData& map) { map.poses.reset(); }, "no pose layer");
  expect(
      [](MapData& map) {
        map.poses.reset();
        map.appearance.reset();
      },
      "no positions");
  expect(
      [](MapData& map) {
        map.floor_plans.clear();
        for (int i = 10; i < 43; ++i) map.floor_plans.push_back(MakePlan(std::to_string(i)));
      },
      "at most 32");
}

}  // namespace
}  // namespace waystone
