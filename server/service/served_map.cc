// SPDX-License-Identifier: Apache-2.0
#include "server/service/served_map.h"

#include "quality/audit.h"
#include "schema/file/map_store.h"
#include "server/http/problem.h"

namespace waystone {

const AuditReport& ServedMap::Audit(QueryGate& gate) const {
  if (is_audited_) return *audit_;
  const std::unique_lock lock(auditing_, std::try_to_lock);
  if (!lock.owns_lock()) {
    constexpr int kRetryS = 2;
    throw BusyError("the map is being audited; try again", kRetryS);
  }
  if (!is_audited_) {
    const QueryGate::Turn turn = gate.Enter();
    audit_ = std::make_shared<const AuditReport>(AuditMap(*index_));
    is_audited_ = true;
  }
  return *audit_;
}

std::shared_ptr<const MapIndex> OpenForServing(const std::filesystem::path& file) {
  std::shared_ptr<const MapIndex> index = MapIndex::Build(ReadMap(file));
  if (index->map().appearance) index->node_features();
  return index;
}

}  // namespace waystone
