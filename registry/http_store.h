// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "registry/store.h"

namespace waystone {

// A store behind a server, by OpenStore: inside registry only.
std::unique_ptr<Store> OpenHttpStore(const std::string& base);

}  // namespace waystone
