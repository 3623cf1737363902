// SPDX-License-Identifier: Apache-2.0
#include "core/base/option_text.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace waystone {

size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);  // distances of a's beginning to each beginning of b
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

namespace {

// "min_votes" of "planes.fusion.min_votes".
std::string_view LastPart(std::string_view name) { return name.substr(name.rfind('.') + 1); }

}  // namespace

std::string NearestName(std::string_view name, const std::vector<std::string>& names) {
  constexpr size_t kFar = std::numeric_limits<size_t>::max() - 1;
  // Two words are near where a typing error explains the difference.
  const auto distance_of = [](std::string_view word, std::string_view candidate) {
    const size_t distance = EditDistance(word, candidate);
    return distance <= std::max<size_t>(1, word.size() / 3) ? distance : kFar;
  };
  std::string nearest;
  size_t least = kFar;
  for (const std::string& candidate : names) {
    // A name without groups means the field.
    const size_t distance = std::min(distance_of(name, candidate),
                                     distance_of(LastPart(name), LastPart(candidate)) + 1);
    if (distance >= least) continue;
    least = distance;
    nearest = candidate;
  }
  return nearest;
}

}  // namespace waystone
