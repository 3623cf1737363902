// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

// What a command writes must not overwrite what it reads.
namespace waystone {

// Throws MapError(kFileExists) where `output` is the file `input` itself, by its name, by a link or
// by another path. `what` says what the input is: "the map that is exported".
void CheckIsNotInput(const std::filesystem::path& output, const std::filesystem::path& input,
                     const std::string& what);

// Throws MapError(kFileExists) where `output` is a map: for commands that write other files.
void CheckReplacesNoMap(const std::filesystem::path& output);

}  // namespace waystone
