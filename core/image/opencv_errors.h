// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// From now on OpenCV's functions throw std::bad_alloc where memory runs out, as all others do, and
// print no errors beside those they throw. For the whole process; any number of times.
void ThrowOpenCvErrors();

}  // namespace waystone
