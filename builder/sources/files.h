// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/image/decode.h"

// Small helpers for files and text: internal to builder/sources. Thread-safe.
namespace waystone {

// The calibration that lies in a folder of images or faces, or beside it.
inline constexpr const char* kCameraFile = "camera.yaml";

// Whole file. Throws MapError(code) when it isn't there, isn't a file, can't be read or has more
// than `max_bytes`.
std::vector<uint8_t> ReadFile(const std::filesystem::path& path, int64_t max_bytes, ErrorCode code);

// An image file: one that is larger than any image within the limits isn't read.
std::vector<uint8_t> ReadImageFile(const std::filesystem::path& path, const DecodeLimits& limits,
                                   ErrorCode code);

// A whole text file, without the byte order mark that some editors put in front of UTF-8. Throws
// like ReadFile.
std::string ReadText(const std::filesystem::path& path, int64_t max_bytes, ErrorCode code);

// A line of a text file with its number, from 1; without line end and surrounding white space.
struct TextLine {
  int number = 0;
  std::string text;
};

// The lines that are neither empty nor a comment (from '#' on). Throws like ReadFile.
std::vector<TextLine> ReadLines(const std::filesystem::path& path, ErrorCode code);

// 'path', for messages.
std::string Quoted(const std::filesystem::path& path);

}  // namespace waystone
