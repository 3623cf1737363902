// SPDX-License-Identifier: Apache-2.0
#include "registry/registry.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <random>
#include <utility>

#include "api/json.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "registry/folder_registry.h"
#include "registry/postgres_registry.h"

namespace waystone {

bool IsPostgres(const std::string& url) {
  return url.starts_with("postgresql://") || url.starts_with("postgres://");
}

std::unique_ptr<Registry> OpenRegistry(const std::string& url,
                                       const std::optional<NewRegistry>& create,
                                       std::stop_token stop) {
  if (IsPostgres(url)) return OpenPostgresRegistry(url, create, std::move(stop));
  if (url.empty() || url.find("://") != std::string::npos) {
    throw MapError(ErrorCode::kUsage,
                   "'" + url + "' is not a registry; give a folder or postgresql://...");
  }
  return OpenFolderRegistry(url, create);
}

std::string NewRegistryId() {
  std::random_device device;
  std::string id;
  for (int i = 0; i < 4; ++i) {
    std::array<char, 9> part{};
    std::snprintf(part.data(), part.size(), "%08x", device());
    id += part.data();
  }
  return id;
}

void CheckRegistryFormat(const std::string& url, int format) {
  if (format == kRegistryFormat) return;
  throw MapError(ErrorCode::kFileUnreadable,
                 url + " is a registry of format " + std::to_string(format) +
                     ", this program knows format " + std::to_string(kRegistryFormat) +
                     "; use the program that it was made with, or a newer "
                     "one");
}

MapError NoMapError(const std::string& name) {
  return {ErrorCode::kNotFound, "no map '" + Printable(name.substr(0, 100)) +
                                    "' in this registry; waystone maps lists the maps"};
}

MapError NoVersionError(const std::string& name, std::optional<int> number) {
  const std::string which =
      number ? "has no version " + std::to_string(*number) : "has no earlier version";
  return {ErrorCode::kNotFound,
          "map '" + name + "' " + which + "; waystone maps REGISTRY --name lists the versions"};
}

bool IsPublished(const MapState& state, const MapVersion& next) {
  if (state.retired || state.version.sha256 != next.sha256) return false;
  const MapTraits known = TraitsOf(state.version);
  const MapTraits told = TraitsOf(next);
  return known.tags == told.tags && known.coarse == told.coarse;
}

int RollbackNumber(const MapState& state, const std::vector<int>& versions,
                   std::optional<int> number) {
  const int current = state.version.number;
  if (!number && state.retired) return current;
  if (number) {
    if (std::ranges::count(versions, *number) > 0) return *number;
    throw NoVersionError(state.version.name, number);
  }
  const auto at = std::ranges::lower_bound(versions, current);
  if (at == versions.begin()) throw NoVersionError(state.version.name, std::nullopt);
  return *std::prev(at);
}

}  // namespace waystone
