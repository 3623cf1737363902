// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace waystone {

// Who may use the server: bearer tokens (RFC 6750), of which only the SHA-256 is kept. Thread-safe.
class Tokens {
 public:
  Tokens() = default;  // none: everybody may

  // Throws as ReadTokenFile does.
  static Tokens FromFile(const std::filesystem::path& path);

  bool empty() const { return digests_.empty(); }
  // Whether the Authorization header "Bearer TOKEN" has one of the tokens; true where there are
  // none. Takes the same time for every wrong token of the same length.
  bool Admit(const std::string& authorization) const;

 private:
  using Digest = std::array<unsigned char, 32>;
  std::vector<Digest> digests_;
};

}  // namespace waystone
