// SPDX-License-Identifier: Apache-2.0
#include "server/service/served_map.h"

#include "quality/audit.h"
#include "schema/file/map_store.h"

namespace waystone {

const AuditReport& ServedMap::Audit(QueryGate& gate) const {
  std::call_once(audited_, [&] {
    const QueryGate::Turn turn = gate.Enter();
    audit_ = std::make_shared<const AuditReport>(AuditMap(*index_));
  });
  return *audit_;
}

std::shared_ptr<const MapIndex> OpenForServing(const std::filesystem::path& file) {
  std::shared_ptr<const MapIndex> index = MapIndex::Build(ReadMap(file));
  if (index->map().appearance) index->node_features();
  return index;
}

}  // namespace waystone
