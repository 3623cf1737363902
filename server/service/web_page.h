// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "server/http/router.h"

namespace waystone {

// Adds the routes of the page: "/" and each of its files. They are sent compressed to clients that
// accept gzip, with an ETag of their bytes and a policy that allows only this origin.
void AddWebPage(Router& router);

}  // namespace waystone
