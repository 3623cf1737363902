// SPDX-License-Identifier: Apache-2.0
#include "schema/tables/blob.h"

#include <bit>
#include <boost/crc.hpp>
#include <cstdio>
#include <cstring>

#include "core/base/check.h"

namespace waystone {
namespace {

// The lowest byte first, on any machine.
template <class Unsigned>
void Append(Bytes& out, Unsigned value) {
  for (size_t i = 0; i < sizeof(Unsigned); ++i) {
    out.push_back(static_cast<uint8_t>(value >> (8 * i)));
  }
}

template <class Unsigned>
Unsigned At(BytesView blob, size_t index) {
  Unsigned value = 0;
  for (size_t i = 0; i < sizeof(Unsigned); ++i) {
    value |=
        static_cast<Unsigned>(static_cast<Unsigned>(blob[index * sizeof(Unsigned) + i]) << (8 * i));
  }
  return value;
}

void AppendFloat(Bytes& out, float value) { Append(out, std::bit_cast<uint32_t>(value)); }
void AppendDouble(Bytes& out, double value) { Append(out, std::bit_cast<uint64_t>(value)); }
float FloatAt(BytesView blob, size_t i) { return std::bit_cast<float>(At<uint32_t>(blob, i)); }
double DoubleAt(BytesView blob, size_t i) { return std::bit_cast<double>(At<uint64_t>(blob, i)); }

void CheckWhole(BytesView blob, int row_bytes) {
  WS_CHECK(blob.size() % row_bytes == 0, "a blob of " + std::to_string(blob.size()) + " bytes");
}

#if defined(__x86_64__)
// The processor has an instruction for this CRC: opening large maps spends much of its time here.
__attribute__((target("sse4.2"))) uint32_t Crc32cByInstruction(BytesView bytes) {
  uint64_t crc = 0xFFFFFFFF;
  size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    uint64_t word;
    std::memcpy(&word, bytes.data() + i, 8);
    crc = __builtin_ia32_crc32di(crc, word);
  }
  auto rest = static_cast<uint32_t>(crc);
  for (; i < bytes.size(); ++i) rest = __builtin_ia32_crc32qi(rest, bytes[i]);
  return ~rest;
}
#endif

}  // namespace

uint32_t Crc32c(BytesView bytes) {
#if defined(__x86_64__)
  static const bool has_instruction = [] {
    __builtin_cpu_init();
    return __builtin_cpu_supports("sse4.2") != 0;
  }();
  if (has_instruction) return Crc32cByInstruction(bytes);
#endif
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

std::string HexOf(uint32_t crc) {
  char text[9];
  std::snprintf(text, sizeof(text), "%08x", crc);
  return text;
}

void ValueChecksum::AddNull() { bytes_.push_back(0); }

void ValueChecksum::AddInteger(int64_t value) {
  bytes_.push_back(1);
  Append(bytes_, static_cast<uint64_t>(value));
}

void ValueChecksum::AddReal(double value) {
  bytes_.push_back(2);
  AppendDouble(bytes_, value == 0 ? 0.0 : value);
}

void ValueChecksum::AddText(const std::string& value) { AddSized(3, value); }

void ValueChecksum::AddBlob(const std::string& bytes) { AddSized(4, bytes); }

void ValueChecksum::AddSized(uint8_t kind, const std::string& value) {
  bytes_.push_back(kind);
  Append(bytes_, static_cast<uint32_t>(value.size()));
  bytes_.insert(bytes_.end(), value.begin(), value.end());
}

Bytes EncodeOutline(const std::vector<Eigen::Vector2d>& outline) {
  Bytes out;
  out.reserve(outline.size() * kVertexBytes);
  for (const Eigen::Vector2d& vertex : outline) {
    AppendDouble(out, vertex.x());
    AppendDouble(out, vertex.y());
  }
  return out;
}

Bytes EncodeParameters(const std::vector<double>& parameters) {
  Bytes out;
  for (const double parameter : parameters) AppendDouble(out, parameter);
  return out;
}

Bytes EncodeMatrix(const Eigen::Matrix3d& matrix) {
  Bytes out;
  out.reserve(kMatrixBytes);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) AppendDouble(out, matrix(row, column));
  }
  return out;
}

Bytes EncodeLists(const std::vector<uint16_t>& list_of_row) {
  Bytes out;
  out.reserve(list_of_row.size() * kListBytes);
  for (const uint16_t list : list_of_row) Append(out, list);
  return out;
}

Bytes EncodeHalves(const HalfMatrix& matrix) {
  Bytes out;
  out.reserve(matrix.size() * kHalfBytes);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    Append(out, Eigen::numext::bit_cast<uint16_t>(matrix.data()[i]));
  }
  return out;
}

Bytes EncodeFloats(const std::vector<float>& values) {
  Bytes out;
  out.reserve(values.size() * kFloatBytes);
  for (const float value : values) AppendFloat(out, value);
  return out;
}

std::vector<Eigen::Vector2d> DecodeOutline(BytesView blob) {
  CheckWhole(blob, kVertexBytes);
  std::vector<Eigen::Vector2d> outline(blob.size() / kVertexBytes);
  for (size_t i = 0; i < outline.size(); ++i) {
    outline[i] = {DoubleAt(blob, 2 * i), DoubleAt(blob, 2 * i + 1)};
  }
  return outline;
}

std::vector<double> DecodeParameters(BytesView blob) {
  CheckWhole(blob, kParameterBytes);
  std::vector<double> parameters(blob.size() / kParameterBytes);
  for (size_t i = 0; i < parameters.size(); ++i) parameters[i] = DoubleAt(blob, i);
  return parameters;
}

Eigen::Matrix3d DecodeMatrix(BytesView blob) {
  WS_CHECK(blob.size() == kMatrixBytes, "a matrix's blob");
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = DoubleAt(blob, i);
  return matrix;
}

HalfMatrix DecodeHalves(BytesView blob, int rows, int columns) {
  WS_CHECK(std::ssize(blob) == int64_t{rows} * columns * kHalfBytes, "a half matrix's blob");
  HalfMatrix matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    matrix.data()[i] = Eigen::numext::bit_cast<Eigen::half>(At<uint16_t>(blob, i));
  }
  return matrix;
}

std::vector<float> DecodeFloats(BytesView blob) {
  CheckWhole(blob, kFloatBytes);
  std::vector<float> values(blob.size() / kFloatBytes);
  for (size_t i = 0; i < values.size(); ++i) values[i] = FloatAt(blob, i);
  return values;
}

std::vector<uint16_t> DecodeLists(BytesView blob) {
  CheckWhole(blob, kListBytes);
  std::vector<uint16_t> lists(blob.size() / kListBytes);
  for (size_t i = 0; i < lists.size(); ++i) lists[i] = At<uint16_t>(blob, i);
  return lists;
}

}  // namespace waystone
