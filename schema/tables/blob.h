// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/panorama/fourier_signature.h"

// The blobs of a map file: rows of numbers, little-endian whatever the machine, without padding.
// How many rows and columns a blob has is said beside it; FORMAT.md lists them. The decoders take
// blobs whose length has already been checked (WS_CHECK). All functions are pure; thread-safe.
namespace waystone {

using Bytes = std::vector<uint8_t>;
using BytesView = std::span<const uint8_t>;

// Bytes of one row of each kind of blob.
inline constexpr int kVertexBytes = 16;    // float64 x, y
inline constexpr int kParameterBytes = 8;  // float64
inline constexpr int kMatrixBytes = 72;    // nine float64, row after row
inline constexpr int kListBytes = 2;       // uint16
inline constexpr int kHalfBytes = 2;       // float16
inline constexpr int kFloatBytes = 4;      // float32

// CRC-32C (Castagnoli): polynomial 0x1EDC6F41, reflected, starting and ending with all ones.
uint32_t Crc32c(BytesView bytes);

// "1a2b3c4d", a CRC for messages.
std::string HexOf(uint32_t crc);

// A CRC-32C over values, each preceded by its kind, so that NULL, 0 and "0" differ. Not
// thread-safe.
class ValueChecksum {
 public:
  void AddNull();                          // byte 0
  void AddInteger(int64_t value);          // byte 1, int64
  void AddReal(double value);              // byte 2, float64; -0 counts as 0
  void AddText(const std::string& value);  // byte 3, uint32 length, bytes
  void AddBlob(const std::string& bytes);  // byte 4, uint32 length, bytes
  // The CRC of everything that was added.
  uint32_t Value() const { return Crc32c(bytes_); }

 private:
  void AddSized(uint8_t kind, const std::string& value);

  Bytes bytes_;
};

Bytes EncodeOutline(const std::vector<Eigen::Vector2d>& outline);
Bytes EncodeParameters(const std::vector<double>& parameters);
Bytes EncodeMatrix(const Eigen::Matrix3d& matrix);
Bytes EncodeHalves(const HalfMatrix& matrix);
Bytes EncodeFloats(const std::vector<float>& values);
Bytes EncodeLists(const std::vector<uint16_t>& list_of_row);

std::vector<Eigen::Vector2d> DecodeOutline(BytesView blob);
std::vector<double> DecodeParameters(BytesView blob);
Eigen::Matrix3d DecodeMatrix(BytesView blob);
// A blob of rows * columns values.
HalfMatrix DecodeHalves(BytesView blob, int rows, int columns);
std::vector<float> DecodeFloats(BytesView blob);
std::vector<uint16_t> DecodeLists(BytesView blob);

}  // namespace waystone
