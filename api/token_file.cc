// SPDX-License-Identifier: Apache-2.0
#include "api/token_file.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr size_t kMinTokenBytes = 16;
constexpr size_t kMaxTokenBytes = 512;
constexpr size_t kMaxFileBytes = 1'000'000;

bool IsToken(std::string_view text) {
  return text.size() >= kMinTokenBytes && text.size() <= kMaxTokenBytes &&
         std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < 127; });
}

// The contents of a file, which may be a pipe of bounded size.
std::string TextOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text(kMaxFileBytes + 1, '\0');
  if (in) in.read(text.data(), std::ssize(text));
  if (!in.is_open() || in.bad()) {
    throw MapError(ErrorCode::kFileUnreadable,
                   path.string() + " can't be read; expected a file with one token per line");
  }
  text.resize(static_cast<size_t>(in.gcount()));
  if (text.size() > kMaxFileBytes) {
    throw MapError(ErrorCode::kBadOptions,
                   path.string() + " has more than 1 MB; expected a file with one token per line");
  }
  return text;
}

}  // namespace

std::vector<std::string> ReadTokenFile(const std::filesystem::path& path) {
  std::vector<std::string> tokens;
  std::istringstream lines(TextOf(path));
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.ends_with('\r')) line.pop_back();
    if (line.empty() || line.starts_with('#')) continue;
    if (!IsToken(line)) {
      throw MapError(ErrorCode::kBadOptions,
                     path.string() + ", line " + std::to_string(number) +
                         ": a token must have 16 to 512 printable characters without spaces; "
                         "create one with: openssl rand -hex 32");
    }
    tokens.push_back(line);
  }
  if (tokens.empty()) {
    throw MapError(ErrorCode::kBadOptions,
                   path.string() + " has no tokens; create one with: openssl rand -hex 32");
  }
  return tokens;
}

}  // namespace waystone
