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

  // One token a line; blank lines and those that begin with # are left out. A token has 16 to 512
  // printable characters. Throws MapError: kFileUnreadable; kBadOptions with the line, and for a
  // file without any token.
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
