// SPDX-License-Identifier: Apache-2.0
#include "server/http/tokens.h"

#include <openssl/crypto.h>
#include <openssl/sha.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "api/token_file.h"

namespace waystone {
namespace {

constexpr std::string_view kScheme = "bearer ";

std::array<unsigned char, 32> DigestOf(std::string_view text) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
  return digest;
}

}  // namespace

Tokens Tokens::FromFile(const std::filesystem::path& path) {
  Tokens tokens;
  for (const std::string& token : ReadTokenFile(path)) tokens.digests_.push_back(DigestOf(token));
  return tokens;
}

bool Tokens::Admit(const std::string& authorization) const {
  if (empty()) return true;
  if (authorization.size() < kScheme.size()) return false;
  for (size_t i = 0; i < kScheme.size(); ++i) {
    if (std::tolower(static_cast<unsigned char>(authorization[i])) != kScheme[i]) return false;
  }
  const Digest given = DigestOf(std::string_view(authorization).substr(kScheme.size()));
  // All are compared, and as whole digests: the time doesn't tell how close a token came.
  bool admitted = false;
  for (const Digest& digest : digests_) {
    admitted |= CRYPTO_memcmp(digest.data(), given.data(), digest.size()) == 0;
  }
  return admitted;
}

}  // namespace waystone
