// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "builder/sources/source.h"
#include "core/base/error.h"

namespace waystone {

// A test with an empty folder of its own, which goes when the test is over.
class TemporaryFolder : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("waystone_") + test->test_suite_name() + "_" + test->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Write(const std::string& name, const std::string& text) {
    std::filesystem::path path = folder_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  // A plain image whose grey value tells which one it is.
  void WriteImage(const std::string& name, int grey = 0, cv::Size size = {16, 12}) {
    std::filesystem::path path = folder_ / name;
    std::filesystem::create_directories(path.parent_path());
    ASSERT_TRUE(cv::imwrite(path.string(), cv::Mat(size, CV_8UC1, cv::Scalar(grey))));
  }

  std::unique_ptr<Source> Open(const SourceOptions& options = {}) {
    return OpenSource(folder_.string(), options);
  }

  // Fails unless `run` throws a MapError of this code whose message has all the parts.
  static void ExpectError(const std::function<void()>& run, ErrorCode code,
                          const std::vector<std::string>& parts) {
    try {
      run();
      ADD_FAILURE() << "nothing was thrown";
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      for (const std::string& part : parts) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
            << "'" << part << "' is not in: " << error.what();
      }
    }
  }

  std::filesystem::path folder_;
};

inline std::vector<Frame> AllFrames(Source& source) {
  std::vector<Frame> frames;
  while (auto frame = source.Next()) frames.push_back(std::move(*frame));
  return frames;
}

inline std::vector<std::string> NamesOf(const std::vector<Frame>& frames) {
  std::vector<std::string> names;
  for (const Frame& frame : frames) names.push_back(frame.info.source);
  return names;
}

}  // namespace waystone
