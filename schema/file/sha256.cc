// SPDX-License-Identifier: Apache-2.0
#include "schema/file/sha256.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <memory>
#include <new>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"

namespace waystone {
namespace {

constexpr const char* kPrefix = "sha256:";
constexpr size_t kHexDigits = 64;
constexpr size_t kBlockBytes = 1 << 20;

struct FreeDigest {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};

// OpenSSL allocates memory for each digest.
void CheckDigest(bool made) {
  if (!made && errno == ENOMEM) throw std::bad_alloc();
  WS_CHECK(made, "OpenSSL has no SHA-256");
}

std::string Hex(const unsigned char* digest, size_t bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (size_t i = 0; i < bytes; ++i) {
    hex += kDigits[digest[i] >> 4];
    hex += kDigits[digest[i] & 15];
  }
  return hex;
}

}  // namespace

std::string Sha256(std::span<const unsigned char> bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  errno = 0;
  const bool made =
      EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, EVP_sha256(), nullptr) == 1;
  CheckDigest(made);
  return kPrefix + Hex(digest.data(), length);
}

std::string Sha256OfFile(const std::filesystem::path& path) {
  errno = 0;
  const std::unique_ptr<EVP_MD_CTX, FreeDigest> context(EVP_MD_CTX_new());
  CheckDigest(context && EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1);
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  std::vector<char> block(kBlockBytes);
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    CheckDigest(EVP_DigestUpdate(context.get(), block.data(), static_cast<size_t>(in.gcount())) ==
                1);
  }
  if (!in.eof()) {
    throw MapError(ErrorCode::kFileUnreadable,
                   path.string() + ": " + std::strerror(errno) + "; check the path and the disk");
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  CheckDigest(EVP_DigestFinal_ex(context.get(), digest.data(), &length) == 1);
  return kPrefix + Hex(digest.data(), length);
}

bool IsSha256(const std::string& text) {
  const std::string prefix = kPrefix;
  return text.size() == prefix.size() + kHexDigits && text.starts_with(prefix) &&
         std::all_of(text.begin() + static_cast<std::ptrdiff_t>(prefix.size()), text.end(),
                     [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

}  // namespace waystone
