// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace waystone {

// Who may ask: bearer tokens (RFC 6750), kept as their SHA-256 alone. Thread-safe.
class Tokens {
 public:
  Tokens() = default;  // none: everybody may

  // Throws as ReadTokenFile does.
  static Tokens FromFile(const std::filesystem::path& path);

  bool empty() const { return digests_.empty(); }
  // Whether a header "Authorization: Bearer TOKEN" has one of the tokens. Takes the same time for
  // every wrong token of one length.
  bool Admit(const std::string& authorization) const;

 private:
  using Digest = std::array<unsigned char, 32>;
  std::vector<Digest> digests_;
};

}  // namespace waystone
