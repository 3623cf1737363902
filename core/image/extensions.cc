// SPDX-License-Identifier: Apache-2.0
#include "core/image/extensions.h"

#include <algorithm>
#include <array>

namespace waystone {
namespace {

constexpr std::array<std::string_view, 10> kImageExtensions{
    ".jpg", ".jpeg", ".png", ".webp", ".heic", ".heif", ".bmp", ".pgm", ".ppm", ".pnm"};

}  // namespace

std::span<const std::string_view> ImageExtensions() { return kImageExtensions; }

std::string ImageExtensionsText() {
  std::string all;
  for (const std::string_view extension : kImageExtensions) {
    if (!all.empty()) all += ' ';
    all += extension;
  }
  return all;
}

bool HasImageExtension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; });
  return std::ranges::find(kImageExtensions, extension) != kImageExtensions.end();
}

}  // namespace waystone
