// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/image_store.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "tests/bench/baseline/made_graph.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;

class Stored : public testing::Test {
 protected:
  Stored() : path_(fs::path(testing::TempDir()) / "images.db") {}
  ~Stored() override { fs::remove(path_); }

  fs::path path_;
  ImageGraph graph_ = BuildImageGraph(MadeNodes(), {});
};

TEST_F(Stored, ComesBackAsItWas) {
  WriteImageGraph(graph_, path_);
  EXPECT_TRUE(ReadImageGraph(path_) == graph_);
}

TEST_F(Stored, ReplacesWhatWasThere) {
  WriteImageGraph(graph_, path_);
  graph_.nodes.pop_back();
  WriteImageGraph(graph_, path_);
  EXPECT_EQ(ReadImageGraph(path_).nodes.size(), 2u);
}

// The size is what is compared: it is what the features take and little more.
TEST_F(Stored, TakesHardlyMoreThanItsBlobs) {
  std::vector<ImageNode> nodes;
  for (int i = 0; i < 20; ++i) nodes.push_back({KeyframeId{i + 1}, i, MadeImage(1000, i + 1)});
  WriteImageGraph({nodes, {}}, path_);
  const double blobs = 20.0 * 1000 * (16 + 128);
  EXPECT_GT(static_cast<double>(fs::file_size(path_)), blobs);
  EXPECT_LT(static_cast<double>(fs::file_size(path_)), 1.05 * blobs);
}

TEST_F(Stored, DamageIsNoticed) {
  WriteImageGraph(graph_, path_);
  std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(fs::file_size(path_)) / 2);
  file.write("damaged", 7);
  file.close();
  EXPECT_THROW(ReadImageGraph(path_), MapError);
}

}  // namespace
}  // namespace waystone::bench
