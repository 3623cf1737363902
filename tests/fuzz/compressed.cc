// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/compressed.h"

#include <zlib.h>

namespace waystone {

std::string Compress(std::string_view bytes) {
  uLongf size = compressBound(bytes.size());
  std::string compressed(size, '\0');
  compress2(reinterpret_cast<Bytef*>(compressed.data()), &size,
            reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), Z_BEST_COMPRESSION);
  compressed.resize(size);
  return compressed;
}

std::string Decompress(std::string_view bytes, size_t max_bytes) {
  uLongf size = max_bytes;
  std::string whole(max_bytes, '\0');
  const int result = uncompress(reinterpret_cast<Bytef*>(whole.data()), &size,
                                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  whole.resize(result == Z_OK ? size : 0);
  return whole;
}

}  // namespace waystone
