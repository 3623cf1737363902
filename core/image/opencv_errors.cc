// SPDX-License-Identifier: Apache-2.0
#include "core/image/opencv_errors.h"

#include <new>
#include <opencv2/core.hpp>

namespace waystone {
namespace {

// Behind a return OpenCV throws its own exception.
int OnOpenCvError(int code, const char*, const char*, const char*, int, void*) {
  if (code == cv::Error::StsNoMem) throw std::bad_alloc();
  return 0;
}

}  // namespace

void ThrowOpenCvErrors() { cv::redirectError(OnOpenCvError); }

}  // namespace waystone
