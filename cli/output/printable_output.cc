// SPDX-License-Identifier: Apache-2.0
#include "cli/output/printable_output.h"

#include <algorithm>
#include <cerrno>
#include <iostream>

#include "core/base/text.h"

namespace waystone {

std::string PrintableBuffer::Take(std::string_view bytes) {
  pending_ += bytes;
  std::string_view left = pending_;
  std::string text;
  while (!left.empty() && !MayBecomeControl(left)) {
    const size_t control = left[0] == '\n' || left[0] == '\t' ? 0 : ControlBytes(left);
    text += control > 0 ? EscapeControl(left.substr(0, control)) : std::string(left.substr(0, 1));
    left.remove_prefix(std::max<size_t>(control, 1));
  }
  pending_ = std::string(left);
  return text;
}

int PrintableBuffer::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

bool PrintableBuffer::Write(std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  const std::string text = Take(bytes);
  const auto size = static_cast<std::streamsize>(text.size());
  errno = 0;
  return Note(target_.sputn(text.data(), size) == size);
}

bool PrintableBuffer::Note(bool written) {
  if (!written && error_ == 0) error_ = errno != 0 ? errno : EIO;
  return written;
}

PrintableBuffer::int_type PrintableBuffer::overflow(int_type byte) {
  if (traits_type::eq_int_type(byte, traits_type::eof())) return traits_type::not_eof(byte);
  const char c = traits_type::to_char_type(byte);
  return Write({&c, 1}) ? byte : traits_type::eof();
}

std::streamsize PrintableBuffer::xsputn(const char* bytes, std::streamsize count) {
  return Write({bytes, static_cast<size_t>(count)}) ? count : 0;
}

int PrintableBuffer::sync() {
  const std::lock_guard lock(mutex_);
  errno = 0;
  return Note(target_.pubsync() == 0) ? 0 : -1;
}

PrintableOutput::PrintableOutput(std::ostream& stream)
    : stream_(stream), raw_(stream.rdbuf()), buffer_(*raw_) {
  RawErrors();  // before std::cerr's buffer is replaced
  stream_.rdbuf(&buffer_);
}

PrintableOutput::~PrintableOutput() {
  stream_.flush();
  stream_.rdbuf(raw_);
}

int PrintableOutput::Flush() {
  stream_.flush();
  return buffer_.error();
}

std::ostream& RawErrors() {
  static std::ostream raw(std::cerr.rdbuf());
  return raw;
}

}  // namespace waystone
