// SPDX-License-Identifier: Apache-2.0
#include "server/service/map_catalog.h"

#include <utility>

#include "core/base/error.h"
#include "quality/audit.h"

namespace waystone {

const AuditReport& ServedMap::Audit(QueryGate& gate) const {
  std::call_once(audited_, [&] {
    const QueryGate::Turn turn = gate.Enter();
    audit_ = std::make_shared<const AuditReport>(AuditMap(*index_));
  });
  return *audit_;
}

MapCatalog::MapCatalog(const Indices& indices) {
  Maps maps;
  for (const auto& [name, index] : indices) {
    maps.emplace(name, std::make_shared<const ServedMap>(name, index));
  }
  maps_ = std::make_shared<const Maps>(std::move(maps));
}

std::shared_ptr<const MapCatalog::Maps> MapCatalog::Now() const {
  const std::lock_guard lock(mutex_);
  return maps_;
}

std::shared_ptr<const ServedMap> MapCatalog::Find(const std::string& name) const {
  const std::shared_ptr<const Maps> maps = Now();
  const auto it = maps->find(name);
  if (it == maps->end()) {
    throw MapError(ErrorCode::kNotFound,
                   "no map '" + name.substr(0, 80) + "'; GET /v1/maps lists the maps");
  }
  return it->second;
}

void MapCatalog::Put(const std::string& name, std::shared_ptr<const MapIndex> index) {
  auto served = std::make_shared<const ServedMap>(name, std::move(index));
  const std::lock_guard lock(mutex_);
  Maps maps = *maps_;
  maps[name] = std::move(served);
  maps_ = std::make_shared<const Maps>(std::move(maps));
}

void MapCatalog::Remove(const std::string& name) {
  const std::lock_guard lock(mutex_);
  Maps maps = *maps_;
  maps.erase(name);
  maps_ = std::make_shared<const Maps>(std::move(maps));
}

}  // namespace waystone
