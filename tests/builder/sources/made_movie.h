// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

// The boxes of an MP4 that has no images: what the reader of edit lists looks at.
namespace waystone {

inline std::string BigEndian(uint64_t number, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(number >> (8 * i) & 0xff);
  return text;
}

inline std::string MakeBox(const std::string& name, const std::string& content) {
  return BigEndian(content.size() + 8, 4) + name + content;
}

// mvhd and mdhd: version and flags, two times, units a second, duration.
inline std::string Times(const std::string& name, uint64_t units_per_s, uint64_t duration) {
  return MakeBox(name, std::string(12, '\0') + BigEndian(units_per_s, 4) + BigEndian(duration, 4));
}

inline std::string Handler(const std::string& kind) {
  return MakeBox("hdlr", std::string(8, '\0') + kind + std::string(12, '\0'));
}

inline std::string Edit(uint64_t duration, uint64_t from) {
  return BigEndian(duration, 4) + BigEndian(from, 4) + BigEndian(1 << 16, 4);
}

inline std::string Track(const std::string& kind, const std::string& edits, int count) {
  return MakeBox(
      "trak", MakeBox("edts", MakeBox("elst", std::string(4, '\0') + BigEndian(count, 4) + edits)) +
                  MakeBox("mdia", Times("mdhd", 90'000, 900'000) + Handler(kind)));
}

// Ten seconds of video; a thousand units a second in the movie.
inline std::string Movie(const std::string& tracks) {
  return MakeBox("ftyp", "isom") + MakeBox("mdat", std::string(100, 'x')) +
         MakeBox("moov", Times("mvhd", 1000, 10'000) + tracks);
}

}  // namespace waystone
