// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>

namespace waystone {

// Writes to another buffer with control characters made visible, so that a name in a map or a file
// name can't drive the user's terminal: those of core/base/text.h but newline and tab become
// `\u001b` and the like, which a string of JSON may contain as well. Thread-safe: text that is
// written at once, as a string is, stays together.
class PrintableBuffer : public std::streambuf {
 public:
  explicit PrintableBuffer(std::streambuf& target) : target_(target) {}

  // errno of the first write that failed, or 0.
  int error() const;

 protected:
  int_type overflow(int_type byte) override;
  std::streamsize xsputn(const char* bytes, std::streamsize count) override;
  int sync() override;

 private:
  bool Write(std::string_view bytes);
  bool Note(bool written);
  std::string Take(std::string_view bytes);

  std::streambuf& target_;
  mutable std::mutex mutex_;  // of all below, and of the target
  std::string pending_;  // bytes that aren't written, because control characters begin with them
  int error_ = 0;
};

// Makes a stream printable while it exists. What writes control characters to std::cerr on purpose
// writes to RawErrors(). Not thread-safe.
class PrintableOutput {
 public:
  explicit PrintableOutput(std::ostream& stream);
  ~PrintableOutput();
  PrintableOutput(const PrintableOutput&) = delete;
  PrintableOutput& operator=(const PrintableOutput&) = delete;

  // Writes what is pending. Returns errno of the first write that failed, or 0.
  int Flush();

 private:
  std::ostream& stream_;
  std::streambuf* raw_;
  PrintableBuffer buffer_;
};

// The terminal behind std::cerr, for code that draws on it.
std::ostream& RawErrors();

}  // namespace waystone
