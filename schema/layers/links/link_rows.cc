// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/layer_rows.h"
#include "schema/layers/links/link_tables.h"
#include "schema/tables/optional_table.h"

namespace waystone {

std::vector<KeyframeLink> ReadLinks(SQLite::Database& database, std::vector<MapProblem>& problems) {
  std::vector<KeyframeLink> links;
  ForEachOptionalRow(database, problems, kKeyframeLinksTable, [&](Row& row) {
    row.Int64(1);
    KeyframeLink link;
    link.a = {row.Int64(1)};
    link.b = {row.Int64(1)};
    links.push_back(link);
  });
  return links;
}

void WriteLinks(const std::vector<KeyframeLink>& links, RowSink& sink) {
  int64_t id = 0;
  OptionalTableWriter<kKeyframeLinksTable> writer(sink, kKeyframeLinksSql);
  for (const KeyframeLink& link : links) writer.Row(++id, link.a, link.b);
}

}  // namespace waystone
