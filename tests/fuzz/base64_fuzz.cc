// SPDX-License-Identifier: Apache-2.0
#include <openssl/evp.h>

#include "server/http/body_parts.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

std::string EncodeBase64(const std::string& bytes) {
  std::string text((bytes.size() + 2) / 3 * 4 + 1, '\0');
  const int size = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                   reinterpret_cast<const unsigned char*>(bytes.data()),
                                   static_cast<int>(bytes.size()));
  text.resize(size);
  return text;
}

}  // namespace

// What is decoded has the size that the text says, and is decoded again from OpenSSL's encoding.
bool FuzzBase64(FuzzInput input) {
  const std::string_view text = TextOf(input);
  const auto bytes = ReadOrRefuse([&] { return DecodeBase64(text); });
  if (!bytes) return false;
  Require(bytes->size() <= text.size() / 4 * 3, "base64 decodes to three quarters at most");
  const std::string again = EncodeBase64(*bytes);
  Require(DecodeBase64(again) == *bytes, "what was decoded is encoded and decoded to the same");
  if (!text.starts_with("data:")) {
    Require(again.size() == text.size(), "the size of base64 is that of its encoding");
  }
  return true;
}

}  // namespace waystone
