// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/edit_list.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {

// A share of a video is one, and what isn't understood is played as a whole.
bool FuzzEditList(FuzzInput input) {
  const double share = PlayedShare(WriteInput("walk.mp4", TextOf(input)));
  Require(share > 0 && share <= 1, "a share of the frames is above 0 and at most 1");
  return share < 1;
}

}  // namespace waystone
