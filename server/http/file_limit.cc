// SPDX-License-Identifier: Apache-2.0
#include "server/http/file_limit.h"

#include <sys/resource.h>

#include <algorithm>

namespace waystone {
namespace {

constexpr int kOtherFiles = 100;  // descriptors that aren't connections

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
  const rlim_t free = limit.rlim_cur > kOtherFiles ? limit.rlim_cur - kOtherFiles : 1;
  return static_cast<int>(std::min<rlim_t>(free, static_cast<rlim_t>(wanted)));
}

}  // namespace waystone
