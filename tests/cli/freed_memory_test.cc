// SPDX-License-Identifier: Apache-2.0
#include "cli/system/freed_memory.h"

#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>

#include <opencv2/core.hpp>
#include <vector>

namespace waystone {
namespace {

int64_t CountPageFaults() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt;
}

// Page faults while pyramids of 40 MB come and go.
int64_t CountFaultsOfPyramids() {
  const int64_t before = CountPageFaults();
  for (int i = 0; i < 10; ++i) {
    std::vector<cv::Mat> pyramid;
    for (int level = 0; level < 10; ++level) {
      pyramid.emplace_back(1000, 1000, CV_32FC1, cv::Scalar(i));
    }
  }
  return CountPageFaults() - before;
}

TEST(KeepFreedMemory, ImagesGetTheMemoryOfTheOnesBefore) {
#ifdef WAYSTONE_SANITIZED
  GTEST_SKIP() << "sanitizers have allocators of their own";
#endif
  // As the C library starts, whatever the environment asks of it.
  mallopt(M_MMAP_THRESHOLD, 128 << 10);
  mallopt(M_TRIM_THRESHOLD, 128 << 10);
  const int64_t before = CountFaultsOfPyramids();
  KeepFreedMemory();
  CountFaultsOfPyramids();
  const int64_t after = CountFaultsOfPyramids();
  EXPECT_GT(before, 10'000) << "the C library keeps it by itself";
  EXPECT_LT(after, 1'000);
}

}  // namespace
}  // namespace waystone
