// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "schema/layers/floor_plans/floor_plan_tables.h"
#include "schema/layers/layer_rows.h"
#include "schema/tables/blob.h"
#include "schema/tables/optional_table.h"
#include "schema/tables/table_writer.h"

namespace waystone {
namespace {

constexpr int kAnchorNumbers = 4;  // px x, px y, x, y

std::vector<PlanAnchor> DecodeAnchors(BytesView blob) {
  const std::vector<double> numbers = DecodeParameters(blob);
  std::vector<PlanAnchor> anchors;
  for (size_t i = 0; i + kAnchorNumbers <= numbers.size(); i += kAnchorNumbers) {
    anchors.push_back({{numbers[i], numbers[i + 1]}, {numbers[i + 2], numbers[i + 3]}});
  }
  return anchors;
}

Bytes EncodeAnchors(const std::vector<PlanAnchor>& anchors) {
  std::vector<double> numbers;
  for (const PlanAnchor& anchor : anchors) {
    numbers.insert(numbers.end(), {anchor.px.x(), anchor.px.y(), anchor.at.x(), anchor.at.y()});
  }
  return EncodeParameters(numbers);
}

std::optional<PlanHeights> HeightsOf(std::optional<double> low, std::optional<double> high) {
  if (low.has_value() != high.has_value()) {
    throw MapError(ErrorCode::kMapDamaged, "low and high must both be there, or neither");
  }
  if (!low) return std::nullopt;
  return PlanHeights{*low, *high};
}

}  // namespace

std::vector<FloorPlanImage> ReadFloorPlans(SQLite::Database& database, bool images,
                                           std::vector<MapProblem>& problems) {
  std::vector<FloorPlanImage> plans;
  ForEachOptionalRow(database, problems, kFloorPlansTable, [&](Row& row) {
    row.Int64(1);
    FloorPlanImage plan;
    plan.name = row.Text();
    plan.width = row.Int(1);
    plan.height = row.Int(1);
    const std::optional<double> low = row.OptionalReal();
    plan.heights = HeightsOf(low, row.OptionalReal());
    const int anchors = row.Int(0, static_cast<int>(kMaxPlanAnchors));
    plan.anchors = DecodeAnchors(row.Blob(int64_t{anchors} * kAnchorNumbers * kParameterBytes));
    if (images) {
      const BytesView image = row.BlobOfRows(1);
      if (image.empty()) throw MapError(ErrorCode::kMapDamaged, "image is empty");
      plan.image.assign(image.begin(), image.end());
    } else {
      row.SkipRest();
    }
    plans.push_back(std::move(plan));
  });
  return plans;
}

void WriteFloorPlans(const std::vector<FloorPlanImage>& plans, RowSink& sink) {
  int64_t id = 0;
  OptionalTableWriter<kFloorPlansTable> rows(sink, kFloorPlansSql);
  for (const FloorPlanImage& plan : plans) {
    std::optional<double> low, high;
    if (plan.heights) {
      low = plan.heights->low;
      high = plan.heights->high;
    }
    rows.Row(++id, plan.name, plan.width, plan.height, low, high, plan.anchors.size(),
             EncodeAnchors(plan.anchors), plan.image);
  }
}

}  // namespace waystone
