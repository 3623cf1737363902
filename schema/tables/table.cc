// SPDX-License-Identifier: Apache-2.0
#include "schema/tables/table.h"

namespace waystone {

std::string ColumnList(const TableView& table) {
  std::string list;
  const auto add = [&](const std::string& name) { list += (list.empty() ? "" : ", ") + name; };
  for (const Column& column : table.columns) {
    const std::string name(column.name);
    if (column.type == ColumnType::kBlob) add(name + "_crc32c");
    add(name);
  }
  return list;
}

int StoredColumns(const TableView& table) {
  int count = 0;
  for (const Column& column : table.columns) count += column.type == ColumnType::kBlob ? 2 : 1;
  return count;
}

}  // namespace waystone
