// SPDX-License-Identifier: Apache-2.0
#include "server/service/served_map.h"

#include <utility>

#include "api/map_json.h"
#include "quality/audit.h"
#include "schema/file/map_store.h"
#include "server/http/problem.h"

namespace waystone {

ServedMap::ServedMap(std::string name, std::shared_ptr<const MapIndex> index)
    : name_(std::move(name)), index_(std::move(index)), summary_(MapJson(name_, *index_)) {}

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
