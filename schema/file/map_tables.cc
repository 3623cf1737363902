// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_tables.h"

#include "schema/layers/layers.h"

namespace waystone {

const std::vector<TableView>& AllTables() {
  static const std::vector<TableView> tables = [] {
    std::vector<TableView> all{kMapTable, kSequencesTable};
    for (const StoredLayer& layer : StoredLayers()) {
      all.insert(all.end(), layer.tables.begin(), layer.tables.end());
    }
    all.emplace_back(kContentsTable);
    return all;
  }();
  return tables;
}

}  // namespace waystone
