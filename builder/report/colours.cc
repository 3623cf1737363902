// SPDX-License-Identifier: Apache-2.0
#include "builder/report/colours.h"

#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>

namespace waystone {
namespace {

// Turns of the colour wheel from an id to the next: with the golden ratio, any run of ids is spread
// evenly over it.
constexpr double kTurnPerId = std::numbers::phi - 1;
// Bright enough for dots on a photo, dark enough for dots on a white page.
constexpr double kMean = 150;
constexpr double kSwing = 105;

double Channel(double turn) { return kMean + kSwing * std::cos(2 * std::numbers::pi * turn); }

}  // namespace

cv::Scalar ColourOf(PlaneId id) {
  const double hue = static_cast<double>(id.value) * kTurnPerId;
  return {Channel(hue - 2.0 / 3), Channel(hue - 1.0 / 3), Channel(hue)};
}

std::string CssColourOf(PlaneId id) {
  const cv::Scalar bgr = ColourOf(id);
  std::ostringstream text;
  text << '#' << std::hex << std::setfill('0');
  for (const int channel : {2, 1, 0}) text << std::setw(2) << static_cast<int>(bgr[channel]);
  return text.str();
}

}  // namespace waystone
