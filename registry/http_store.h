// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "registry/store.h"

namespace waystone {

// A store behind a server, opened by OpenStore. Internal to registry. Throws MapError(kUsage) for
// an address without a host or with an unusable port. Thread-safe.
std::unique_ptr<Store> OpenHttpStore(const std::string& base);

}  // namespace waystone
