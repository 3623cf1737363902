// SPDX-License-Identifier: Apache-2.0
#include "core/image/opencv_errors.h"

#include <cstring>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>

namespace waystone {
namespace {

// After a return OpenCV throws its own exception.
int OnOpenCvError(int code, const char*, const char* message, const char*, int, void*) {
  // The image codecs pass on libjpeg's message with another code.
  const bool codec = std::strstr(message, "Insufficient memory") != nullptr;
  if (code == cv::Error::StsNoMem || codec) throw std::bad_alloc();
  return 0;
}

}  // namespace

void ThrowOpenCvErrors() {
  cv::redirectError(OnOpenCvError);
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
}

}  // namespace waystone
