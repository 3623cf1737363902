// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/base/random.h"

namespace waystone::bench {

// What another camera, another hand or another light makes of a picture.
struct ImageChange {
  std::string name;
  // From CV_8UC1 to CV_8UC1, of another size where the change says so.
  std::function<cv::Mat(const cv::Mat& grey, Random& random)> apply;
};

// The picture (CV_8UC1) with its light multiplied by `gain`, and with the sensor's noise, in grey
// levels, which doesn't shrink with the light.
cv::Mat Expose(const cv::Mat& grey, double gain, double noise_sigma, Random& random);

// Every change that can be made from the picture only, the first of which leaves it as it is. A
// wider lens isn't among them: it sees more than the picture shows.
std::vector<ImageChange> ImageChanges();

}  // namespace waystone::bench
