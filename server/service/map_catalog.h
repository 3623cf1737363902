// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "localizer/index/map_index.h"
#include "server/service/map_source.h"

namespace waystone {

// Maps that are all in memory, and may be replaced while requests are answered. Thread-safe.
class MapCatalog : public MapSource {
 public:
  using Indices = std::map<std::string, std::shared_ptr<const MapIndex>>;
  using Maps = std::map<std::string, std::shared_ptr<const ServedMap>>;

  explicit MapCatalog(const Indices& indices);

  // All maps as they are now.
  std::shared_ptr<const Maps> Now() const;
  MapPtr Find(const std::string& name) const;

  std::vector<std::string> Names() const override;
  void CheckName(const std::string& name) const override { Find(name); }
  MapPtr Find(const std::string& name, const Deadline&) override { return Find(name); }
  // Maps from files have neither tags nor a registry's frames: hints about them are kNotAvailable.
  SearchScope ScopeOf(const MapHints& hints) const override;
  std::vector<FoundMap> FindLot(std::span<const std::string> names, const Deadline&) override;
  Json Summary(const std::string& name) const override;
  Holdings holdings() const override;

  // Adds a map, or replaces the one of that name. The index is complete.
  void Put(const std::string& name, std::shared_ptr<const MapIndex> index);
  void Remove(const std::string& name);

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const Maps> maps_;
};

}  // namespace waystone
