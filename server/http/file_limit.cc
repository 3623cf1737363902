// SPDX-License-Identifier: Apache-2.0
#include "server/http/file_limit.h"

#include <sys/resource.h>

#include <algorithm>
#include <string>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr int kOtherFiles = 100;     // descriptors that aren't connections
constexpr int kFewConnections = 16;  // with fewer, clients close each other's

}  // namespace

int RaiseFileLimit(int wanted) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return wanted;
  const rlim_t need = static_cast<rlim_t>(wanted) + kOtherFiles;
  if (limit.rlim_cur < need) {
    limit.rlim_cur = std::min(need, limit.rlim_max);
    setrlimit(RLIMIT_NOFILE, &limit);
    getrlimit(RLIMIT_NOFILE, &limit);
  }
  const rlim_t left = limit.rlim_cur > kOtherFiles ? limit.rlim_cur - kOtherFiles : 0;
  const int got = static_cast<int>(std::min<rlim_t>(left, static_cast<rlim_t>(wanted)));
  if (got < std::min(wanted, kFewConnections)) {
    throw MapError(ErrorCode::kBadOptions,
                   "the limit of open files is " + std::to_string(limit.rlim_cur) +
                       ", which leaves " + std::to_string(got) + " of " + std::to_string(wanted) +
                       " connections; raise it to " + std::to_string(need) +
                       " (ulimit -n, LimitNOFILE)");
  }
  return got;
}

}  // namespace waystone
