// SPDX-License-Identifier: Apache-2.0
// Every target with the inputs kept in corpus/, and with simple mutations of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>

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

// Whether a target accepts an input. Nothing where it doesn't bear it, which it writes then where
// it can be found.
std::optional<bool> Accepts(const FuzzTarget& target, const std::string& input) {
  try {
    return target.run({reinterpret_cast<const uint8_t*>(input.data()), input.size()});
  } catch (const std::exception& error) {
    const fs::path kept =
        fs::temp_directory_path() / ("waystone-" + std::string(target.name) + ".input");
    std::ofstream(kept, std::ios::binary) << input;
    ADD_FAILURE() << error.what() << "\nthe input is " << kept;
    return std::nullopt;
  }
}

class FuzzReplay : public testing::TestWithParam<FuzzTarget> {};

TEST_P(FuzzReplay, BearsTheCorpus) {
  const std::vector<std::string> inputs = ReadCorpus(GetParam());
  EXPECT_GE(inputs.size(), 2u);
  int accepted = 0;
  for (const std::string& input : inputs) accepted += Accepts(GetParam(), input) == true ? 1 : 0;
  EXPECT_GT(accepted, 0) << "no input gets behind the reader's first checks";
  Accepts(GetParam(), "");
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
    if (!Accepts(target, mutant)) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzReplay,
                         testing::ValuesIn(FuzzTargets().begin(), FuzzTargets().end()),
                         [](const auto& target) { return std::string(target.param.name); });

// Longer than what is mutated.
TEST(FuzzTargets, BearInputsAtTheirBounds) {
  const auto accepts = [](const std::string& name, const std::string& input) {
    return Accepts(*std::ranges::find(FuzzTargets(), name, &FuzzTarget::name), input);
  };
  const std::string line = "GET / HTTP/1.1\r\nHost: x\r\n", header = "A: " + std::string(6995, 'x');
  std::string head = line;
  for (int i = 0; i < 9; ++i) head += header + "\r\n";
  head += "A: " + std::string(64 * 1024 - head.size() - 7, 'x');
  EXPECT_EQ(accepts("http_head", head + "\r\n\r\n"), true);
  EXPECT_EQ(accepts("http_head", head + "x\r\n\r\n"), false);
  const auto request = [](int values) {
    std::string images = R"({"images":[{"data":"eA=="}])";
    for (int i = 0; i < values; ++i) images += ",\"a\":0";
    return images + "}";
  };
  EXPECT_EQ(accepts("request_json", request(20'001)), false);
}

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
