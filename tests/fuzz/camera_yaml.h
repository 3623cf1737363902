// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/camera/camera.h"

namespace waystone {

// A camera in our own format, each line behind `indent`; numbers to their last bit.
std::string CameraYaml(const Camera& camera, const std::string& indent);

// A number to its last bit.
std::string ExactText(double number);

}  // namespace waystone
