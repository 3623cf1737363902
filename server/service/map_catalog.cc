// SPDX-License-Identifier: Apache-2.0
#include "server/service/map_catalog.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

MapError NoMaps() { return {ErrorCode::kNotReady, "no maps loaded"}; }

}  // namespace

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
                   "no map '" + Printable(name.substr(0, 80)) + "'; GET /v1/maps lists the maps");
  }
  return it->second;
}

std::vector<std::string> MapCatalog::Names() const {
  std::vector<std::string> names;
  for (const auto& [name, map] : *Now()) names.push_back(name);
  return names;
}

SearchScope MapCatalog::ScopeOf(const MapHints& hints) const {
  if (hints.position || !hints.tags.empty()) {
    throw MapError(ErrorCode::kNotAvailable,
                   "hints.position and hints.tags need maps of a registry (waystone serve "
                   "--registry); omit them");
  }
  SearchScope scope{Names(), nullptr, 0};
  if (scope.names.empty()) throw NoMaps();
  return scope;
}

std::vector<FoundMap> MapCatalog::FindLot(std::span<const std::string> names, const Deadline&) {
  std::vector<FoundMap> found;
  for (const std::string& name : names) {
    try {
      found.push_back({name, Find(name), MapFinding::kFound, ""});
    } catch (const MapError& error) {
      found.push_back({name, nullptr, MapFinding::kFailed, error.what(), error.code()});
    }
  }
  return found;
}

Json MapCatalog::Summary(const std::string& name) const { return Find(name)->summary(); }

Holdings MapCatalog::holdings() const {
  const size_t maps = Now()->size();
  return {maps, maps, std::nullopt};
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
