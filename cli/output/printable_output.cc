// SPDX-License-Identifier: Apache-2.0
#include "cli/output/printable_output.h"

#include <iostream>

#include "core/base/text.h"

namespace waystone {
namespace {

constexpr unsigned char kC1Lead = 0xC2;  // U+0080 to U+009F are C2 80 to C2 9F

bool IsControl(unsigned char byte) {
  return (byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7F;
}

}  // namespace

std::string PrintableBuffer::Printable(unsigned char byte) {
  const bool after_lead = lead_;
  lead_ = byte == kC1Lead;
  std::string text;
  if (after_lead && byte >= 0x80 && byte < 0xA0) return EscapeControl(byte);
  if (after_lead) text += static_cast<char>(kC1Lead);
  if (lead_) return text;
  return text + (IsControl(byte) ? EscapeControl(byte) : std::string(1, static_cast<char>(byte)));
}

bool PrintableBuffer::Write(const std::string& text) {
  const auto size = static_cast<std::streamsize>(text.size());
  return target_.sputn(text.data(), size) == size;
}

PrintableBuffer::int_type PrintableBuffer::overflow(int_type byte) {
  if (traits_type::eq_int_type(byte, traits_type::eof())) return traits_type::not_eof(byte);
  return Write(Printable(static_cast<unsigned char>(byte))) ? byte : traits_type::eof();
}

std::streamsize PrintableBuffer::xsputn(const char* bytes, std::streamsize count) {
  std::string text;
  for (std::streamsize i = 0; i < count; ++i) {
    text += Printable(static_cast<unsigned char>(bytes[i]));
  }
  return Write(text) ? count : 0;
}

int PrintableBuffer::sync() { return target_.pubsync(); }

PrintableOutput::PrintableOutput(std::ostream& stream)
    : stream_(stream), raw_(stream.rdbuf()), buffer_(*raw_) {
  RawErrors();  // before the buffer of std::cerr changes
  stream_.rdbuf(&buffer_);
}

PrintableOutput::~PrintableOutput() {
  stream_.flush();
  stream_.rdbuf(raw_);
}

std::ostream& RawErrors() {
  static std::ostream raw(std::cerr.rdbuf());
  return raw;
}

}  // namespace waystone
