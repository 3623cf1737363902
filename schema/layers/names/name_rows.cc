// SPDX-License-Identifier: Apache-2.0
#include <utility>
#include <vector>

#include "schema/layers/layer_rows.h"
#include "schema/layers/names/name_tables.h"
#include "schema/tables/blob.h"
#include "schema/tables/optional_table.h"
#include "schema/tables/table_writer.h"

namespace waystone {
namespace {

constexpr int kLastNamedKind = static_cast<int>(NamedKind::kPlanes);

}  // namespace

std::vector<NamedPlace> ReadNames(SQLite::Database& database, std::vector<MapProblem>& problems) {
  std::vector<NamedPlace> places;
  ForEachOptionalRow(database, problems, kPlaceRangesTable, [&](Row& row) {
    row.Int64(1);
    NamedPlace place{row.Text(), {}, {}};
    NamedRange range;
    range.kind = static_cast<NamedKind>(row.Int(0, kLastNamedKind));
    range.first = row.Int64(1);
    range.last = row.Int64(range.first);
    place.ranges.push_back(range);
    places.push_back(std::move(place));
  });
  ForEachOptionalRow(database, problems, kPlacePolygonsTable, [&](Row& row) {
    row.Int64(1);
    NamedPlace place{row.Text(), {}, {}};
    place.polygons.push_back(
        DecodeOutline(row.Blob(static_cast<int64_t>(row.Int()) * kVertexBytes)));
    places.push_back(std::move(place));
  });
  return Canonical(std::move(places));
}

void WriteNames(const std::vector<NamedPlace>& places, RowSink& sink) {
  int64_t id = 0;
  OptionalTableWriter<kPlaceRangesTable> ranges(sink, kPlaceRangesSql);
  for (const NamedPlace& place : places) {
    for (const NamedRange& range : place.ranges) {
      ranges.Row(++id, place.name, range.kind, range.first, range.last);
    }
  }
  id = 0;
  OptionalTableWriter<kPlacePolygonsTable> polygons(sink, kPlacePolygonsSql);
  for (const NamedPlace& place : places) {
    for (const NamedPolygon& polygon : place.polygons) {
      polygons.Row(++id, place.name, polygon.size(), EncodeOutline(polygon));
    }
  }
}

}  // namespace waystone
