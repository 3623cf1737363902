// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace waystone {

// The file extensions of images that core/image decodes, in lower case and with the dot, the most
// common first. All functions are thread-safe.
std::span<const std::string_view> ImageExtensions();
// The same as ".jpg .jpeg .png ...", for messages.
std::string ImageExtensionsText();
// Whether the name ends in one of them (.jpg, .PNG, ...). The file isn't looked at.
bool HasImageExtension(const std::filesystem::path& path);

}  // namespace waystone
