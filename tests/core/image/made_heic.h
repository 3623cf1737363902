// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

// HEICs made without an encoder: HEVC pictures whose samples are stored as they are (pulse code
// modulation), so that decoding gives exactly what was put in.
namespace waystone {

struct MadeHeic {
  int columns = 1;  // of the grid; more than one image in all makes a grid
  int rows = 1;
  int bits = 8;         // of the samples, 8 or 10; those of 10 are the bytes times 4
  bool chroma = false;  // 4:2:0, grey; otherwise no chroma
  bool full_range = true;
  bool turned = false;          // with the properties irot and imir
  std::vector<uint8_t> exif{};  // a TIFF; none when empty
  // What a liar does: the size that the picture's parameter set claims. 0: the true one.
  int claimed_width = 0;
  int claimed_height = 0;
  int cut = 0;  // px on the right of each picture that its parameter set doesn't show
};

// A HEIC of a grey image (CV_8UC1) whose sides are multiples of 16 times columns and rows.
std::vector<uint8_t> MakeHeic(const cv::Mat& grey, const MadeHeic& made = {});

}  // namespace waystone
