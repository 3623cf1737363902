// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "registry/postgres_database.h"
#include "registry/registry.h"

namespace waystone {

// A registry in a PostgreSQL database, by OpenRegistry: internal to registry. Everything is in the
// schema `waystone`, which the first publisher creates:
//   registry  one row: format, id, store, and the number of changes, whose row each change locks
//   versions  one row for each version, written once
//   maps      the current version of each name, whether it is retired, and the change that said so
// Each change notifies the channel `waystone`. Servers need SELECT on the three tables alone.
std::unique_ptr<Registry> OpenPostgresRegistry(const std::string& url,
                                               const std::optional<NewRegistry>& create,
                                               std::stop_token stop);

// What Registry::Publish does, as a part of the caller's transaction. Others that change the
// registry wait until it ends.
MapVersion PublishInTransaction(postgres::Database& database, const MapVersion& version);

}  // namespace waystone
