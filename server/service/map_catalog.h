// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "localizer/index/map_index.h"
#include "server/service/query_gate.h"

namespace waystone {

struct AuditReport;

// A map that is served: immutable but for its audit, which is made when it is first asked for.
// Thread-safe.
class ServedMap {
 public:
  ServedMap(std::string name, std::shared_ptr<const MapIndex> index)
      : name_(std::move(name)), index_(std::move(index)) {}

  const std::string& name() const { return name_; }  // what URLs call it
  const MapIndex& index() const { return *index_; }
  const std::shared_ptr<const MapIndex>& shared_index() const { return index_; }
  const std::string& version() const { return index_->map().info.version; }
  // The first one who asks computes it, for seconds and on all cores, in a query's turn; who asks
  // meanwhile waits without one. Throws what QueryGate::Enter throws.
  const AuditReport& Audit(QueryGate& gate) const;

 private:
  std::string name_;
  std::shared_ptr<const MapIndex> index_;
  mutable std::once_flag audited_;
  mutable std::shared_ptr<const AuditReport> audit_;
};

// The maps of a server by their names, which may be exchanged while requests are answered: each
// request goes on with the maps that it found when it began. Thread-safe.
class MapCatalog {
 public:
  using Indices = std::map<std::string, std::shared_ptr<const MapIndex>>;
  using Maps = std::map<std::string, std::shared_ptr<const ServedMap>>;

  explicit MapCatalog(const Indices& indices);

  // All maps as they are now.
  std::shared_ptr<const Maps> Now() const;
  // One of them. Throws MapError(kNotFound).
  std::shared_ptr<const ServedMap> Find(const std::string& name) const;

  // Adds a map or takes the place of the one of that name. The caller has built it completely.
  void Put(const std::string& name, std::shared_ptr<const MapIndex> index);
  void Remove(const std::string& name);

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const Maps> maps_;
};

}  // namespace waystone
