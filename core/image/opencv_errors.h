// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// Makes OpenCV's functions throw std::bad_alloc when memory runs out, as all others do, and print
// no errors besides those they throw. For the whole process; may be called repeatedly, but isn't
// synchronised with other threads that use OpenCV.
void ThrowOpenCvErrors();

}  // namespace waystone
