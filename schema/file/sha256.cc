// SPDX-License-Identifier: Apache-2.0
#include "schema/file/sha256.h"

#include <openssl/evp.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <new>

#include "core/base/check.h"

namespace waystone {
namespace {

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
  if (!made && errno == ENOMEM) throw std::bad_alloc();
  WS_CHECK(made, "OpenSSL has no SHA-256");
  return "sha256:" + Hex(digest.data(), length);
}

}  // namespace waystone
