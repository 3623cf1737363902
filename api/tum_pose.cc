// SPDX-License-Identifier: Apache-2.0
#include "api/tum_pose.h"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/text.h"

namespace waystone {

std::optional<TumPose> ParseTumPose(std::string_view line) {
  const std::vector<std::string> words = Words(line);
  std::array<double, 8> n{};
  if (words.size() != n.size()) return std::nullopt;
  for (size_t i = 0; i < n.size(); ++i) {
    const std::optional<double> number = ToNumber(words[i]);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    n[i] = *number;
  }
  return TumPose{n[0], {n[1], n[2], n[3]}, {n[7], n[4], n[5], n[6]}};
}

}  // namespace waystone
