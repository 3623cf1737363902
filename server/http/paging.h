// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "server/http/message.h"

namespace waystone {

// The part of a list that a request asks for: ?limit=N (1 to 1000, 100 by default) and
// ?cursor=... as the `next` of the page before gave it.
struct Page {
  size_t begin = 0;  // first row
  size_t end = 0;    // one past the last row
  std::string next;  // the cursor of the page after; empty at the end
};

// The rows of a list of `size` rows. Throws MapError(kBadRequest) for a limit or cursor that isn't
// one.
Page PageOf(const HttpRequest& request, size_t size);

}  // namespace waystone
