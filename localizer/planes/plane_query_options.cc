// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/plane_query_options.h"

namespace waystone {

void PlaneQueryOptions::Check() const {
  CheckFields("planes", *this);
  ransac.Check();
  homology.Check();
  if (settled_share <= gates.ambiguous_share) return;
  throw MapError(ErrorCode::kBadOptions,
                 "planes.settled_share must not exceed planes.gates.ambiguous_share, below which a "
                 "plane elsewhere can't make an answer ambiguous");
}

}  // namespace waystone
