// SPDX-License-Identifier: Apache-2.0
#include "server/http/tokens.h"

#include <openssl/crypto.h>
#include <openssl/sha.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <string_view>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr size_t kMinTokenBytes = 16;
constexpr size_t kMaxTokenBytes = 512;
constexpr std::string_view kScheme = "bearer ";

bool IsToken(std::string_view text) {
  return text.size() >= kMinTokenBytes && text.size() <= kMaxTokenBytes &&
         std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < 127; });
}

std::array<unsigned char, 32> DigestOf(std::string_view text) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
  return digest;
}

}  // namespace

Tokens Tokens::FromFile(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) {
    throw MapError(ErrorCode::kFileUnreadable,
                   path.string() + " can't be read; expected a file with one token per line");
  }
  Tokens tokens;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.ends_with('\r')) line.pop_back();
    if (line.empty() || line.starts_with('#')) continue;
    if (!IsToken(line)) {
      throw MapError(ErrorCode::kBadOptions,
                     path.string() + ", line " + std::to_string(number) +
                         ": a token must have 16 to 512 printable characters without spaces; "
                         "create one with: openssl rand -hex 32");
    }
    tokens.digests_.push_back(DigestOf(line));
  }
  if (tokens.empty()) {
    throw MapError(ErrorCode::kBadOptions,
                   path.string() + " has no tokens; create one with: openssl rand -hex 32");
  }
  return tokens;
}

bool Tokens::Admit(const std::string& authorization) const {
  if (empty()) return true;
  if (authorization.size() < kScheme.size()) return false;
  for (size_t i = 0; i < kScheme.size(); ++i) {
    if (std::tolower(static_cast<unsigned char>(authorization[i])) != kScheme[i]) return false;
  }
  const Digest given = DigestOf(std::string_view(authorization).substr(kScheme.size()));
  // All are compared, and whole digests: the time says nothing about which came how near.
  bool admitted = false;
  for (const Digest& digest : digests_) {
    admitted |= CRYPTO_memcmp(digest.data(), given.data(), digest.size()) == 0;
  }
  return admitted;
}

}  // namespace waystone
