// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/layer_rows.h"
#include "schema/layers/looks/look_tables.h"
#include "schema/tables/blob.h"
#include "schema/tables/optional_table.h"

namespace waystone {
namespace {

constexpr int kLooksBytes = 2;  // looked, found

Bytes EncodeLooks(const std::vector<FeatureLooks>& looks) {
  Bytes blob;
  blob.reserve(looks.size() * kLooksBytes);
  for (const FeatureLooks& one : looks) {
    blob.push_back(one.looked);
    blob.push_back(one.found);
  }
  return blob;
}

std::vector<FeatureLooks> ReadFeatureLooks(Row& row) {
  const int count = row.Int();
  const BytesView blob = row.Blob(int64_t{count} * kLooksBytes);
  std::vector<FeatureLooks> looks;
  looks.reserve(static_cast<size_t>(count));
  for (size_t i = 0; i < blob.size(); i += kLooksBytes) looks.push_back({blob[i], blob[i + 1]});
  return looks;
}

}  // namespace

Looks ReadLooks(SQLite::Database& database, std::vector<MapProblem>& problems) {
  Looks looks;
  ForEachOptionalRow(database, problems, kPlaneLooksTable, [&](Row& row) {
    row.Int64(1);
    PlaneLooks one;
    one.plane = {row.Int64(1)};
    one.sequence = {row.Int64(1)};
    one.features = ReadFeatureLooks(row);
    looks.planes.push_back(std::move(one));
  });
  ForEachOptionalRow(database, problems, kLandmarkLooksTable, [&](Row& row) {
    row.Int64(1);
    LandmarkLooks one;
    one.keyframe = {row.Int64(1)};
    one.sequence = {row.Int64(1)};
    one.landmarks = ReadFeatureLooks(row);
    looks.landmarks.push_back(std::move(one));
  });
  return looks;
}

void WriteLooks(const Looks& looks, RowSink& sink) {
  int64_t id = 0;
  OptionalTableWriter<kPlaneLooksTable> planes(sink, kPlaneLooksSql);
  for (const PlaneLooks& one : looks.planes) {
    planes.Row(++id, one.plane, one.sequence, one.features.size(), EncodeLooks(one.features));
  }
  id = 0;
  OptionalTableWriter<kLandmarkLooksTable> landmarks(sink, kLandmarkLooksSql);
  for (const LandmarkLooks& one : looks.landmarks) {
    landmarks.Row(++id, one.keyframe, one.sequence, one.landmarks.size(),
                  EncodeLooks(one.landmarks));
  }
}

}  // namespace waystone
