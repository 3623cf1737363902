// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/error.h"

// What the targets share: bytes somebody made up, and what must hold of what is read from them.
namespace waystone {

using FuzzInput = std::span<const uint8_t>;

// A property that doesn't hold.
class FuzzFinding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

// Throws FuzzFinding unless it `holds`.
void Require(bool holds, const std::string& property);

// What `read` returns, or nothing where it refuses by MapError, which is the only thing it may
// throw and must neither be ours to blame (kInternal) nor say nothing.
template <class Read>
auto ReadOrRefuse(const Read& read) -> std::optional<decltype(read())> {
  try {
    return read();
  } catch (const MapError& error) {
    Require(error.code() != ErrorCode::kInternal && *error.what() != '\0',
            std::string("a refusal names its cause: ") + error.what());
    return std::nullopt;
  }
}

// The same of what must be readable because we wrote it.
template <class Read>
auto ReadBack(const Read& read, const std::string& what) -> decltype(read()) {
  try {
    return read();
  } catch (const MapError& error) {
    throw FuzzFinding(what + " is written and not read back: " + error.what());
  }
}

std::string_view TextOf(FuzzInput input);

// The input up to its first line's end, and the rest.
std::pair<std::string_view, FuzzInput> SplitLine(FuzzInput input);

// A folder of this process, below TMPDIR, which goes away at its end.
const std::filesystem::path& FuzzFolder();

// Writes the bytes into a file of that folder, over what was there, and returns its path.
std::filesystem::path WriteInput(const std::string& name, std::string_view bytes);

}  // namespace waystone
