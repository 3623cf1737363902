// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

#include "api/logged_query.h"

namespace waystone {

// All queries of a small log. Throws as ReadQueryLog does.
inline std::vector<LoggedQuery> ReadQueries(const std::filesystem::path& folder) {
  std::vector<LoggedQuery> queries;
  ReadQueryLog(folder, [&](LoggedQuery& query) { queries.push_back(std::move(query)); });
  return queries;
}

}  // namespace waystone
