// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "api/json.h"
#include "localizer/index/map_index.h"
#include "server/service/query_gate.h"

namespace waystone {

struct AuditReport;

// A map that is served: immutable but for its audit, which is made when it is first asked for.
// Thread-safe.
class ServedMap {
 public:
  ServedMap(std::string name, std::shared_ptr<const MapIndex> index);

  const std::string& name() const { return name_; }  // what URLs call it
  const MapIndex& index() const { return *index_; }
  const std::shared_ptr<const MapIndex>& shared_index() const { return index_; }
  const std::string& version() const { return index_->map().info.version; }
  const Json& summary() const { return summary_; }  // MapJson: lists of maps have it of each
  // Computed for the first caller, for seconds and on all cores, in a query's turn. Throws what
  // QueryGate::Enter throws, and BusyError to callers meanwhile: waiting would take a thread.
  const AuditReport& Audit(QueryGate& gate) const;

 private:
  std::string name_;
  std::shared_ptr<const MapIndex> index_;
  Json summary_;
  mutable std::mutex auditing_;
  mutable std::atomic<bool> is_audited_ = false;  // `audit_` is there, for good
  mutable std::shared_ptr<const AuditReport> audit_;
};

// Reads a map file and makes it ready for queries of every kind, so that none has to wait, in its
// turn, for an index that another query makes. Throws as ReadMap does. Thread-safe.
std::shared_ptr<const MapIndex> OpenForServing(const std::filesystem::path& file);

}  // namespace waystone
