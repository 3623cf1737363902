// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace waystone {

// A map file that somebody made to harm its reader, from a sound map of 1024-byte pages.
struct CraftedMap {
  std::string name;
  std::function<void(const std::filesystem::path&)> make;  // changes the sound map at the path
  bool sound = false;  // whether it must still be read as what it was, and not be refused
};

// By SQL: objects that evaluate something, and values that claim too much.
std::vector<CraftedMap> CraftedByStatements();
// By bytes: headers, trees, overflow chains and free lists that lie.
std::vector<CraftedMap> CraftedByBytes();

}  // namespace waystone
