// SPDX-License-Identifier: Apache-2.0
// Every target with the inputs kept in corpus/, and with simple mutations of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "core/base/random.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// The kept inputs of a target, by name.
std::vector<std::string> ReadCorpus(const FuzzTarget& target) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(fs::path(WAYSTONE_CORPUS) / target.name)) {
    paths.push_back(entry.path());
  }
  std::ranges::sort(paths);
  std::vector<std::string> inputs;
  for (const fs::path& path : paths) {
    std::ifstream in(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return inputs;
}

// Whether a target bears an input; else writes that where it can be found.
bool Bears(const FuzzTarget& target, const std::string& input) {
  try {
    target.run({reinterpret_cast<const uint8_t*>(input.data()), input.size()});
    return true;
  } catch (const std::exception& error) {
    const fs::path kept =
        fs::temp_directory_path() / ("waystone-" + std::string(target.name) + ".input");
    std::ofstream(kept, std::ios::binary) << input;
    ADD_FAILURE() << error.what() << "\nthe input is " << kept;
    return false;
  }
}

class FuzzReplay : public testing::TestWithParam<FuzzTarget> {};

TEST_P(FuzzReplay, BearsTheCorpus) {
  const std::vector<std::string> inputs = ReadCorpus(GetParam());
  EXPECT_GE(inputs.size(), 2u);
  for (const std::string& input : inputs) Bears(GetParam(), input);
  Bears(GetParam(), "");
}

TEST_P(FuzzReplay, BearsMutations) {
  const FuzzTarget& target = GetParam();
  const std::vector<std::string> inputs = ReadCorpus(target);
  ASSERT_FALSE(inputs.empty());
  Random random(16);
  const auto any = [&]() -> const std::string& {
    return inputs[random.Below(static_cast<int>(inputs.size()))];
  };
  const auto simply = [&](std::string bytes, size_t max_bytes) {
    return MutateSimply(std::move(bytes), any(), max_bytes, random);
  };
  for (int i = 0; i < target.mutations; ++i) {
    const auto seed = static_cast<uint32_t>(random.Next());
    const std::string mutant = target.mutate != nullptr
                                   ? target.mutate(any(), target.max_bytes, seed, simply)
                                   : simply(any(), target.max_bytes);
    if (!Bears(target, mutant)) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzReplay,
                         testing::ValuesIn(FuzzTargets().begin(), FuzzTargets().end()),
                         [](const auto& target) { return std::string(target.param.name); });

TEST(FuzzTargets, EachHasItsCorpusAndEachCorpusItsTarget) {
  std::vector<std::string> folders;
  for (const auto& entry : fs::directory_iterator(WAYSTONE_CORPUS)) {
    folders.push_back(entry.path().filename().string());
  }
  std::ranges::sort(folders);
  std::vector<std::string> names;
  for (const FuzzTarget& target : FuzzTargets()) names.emplace_back(target.name);
  EXPECT_EQ(folders, names);
}

}  // namespace
}  // namespace waystone
