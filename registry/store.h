// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace waystone {

// Receives the bytes of a file in order.
class FileSink {
 public:
  virtual ~FileSink() = default;
  // The next bytes start at this offset: the one asked for, or 0 from a store that can't send part
  // of a file. Called once, first. May throw MapError.
  virtual void Begin(int64_t offset) = 0;
  // May throw MapError. False ends the transfer.
  virtual bool Take(std::span<const char> bytes) = 0;
};

// Where map files are kept: a folder, or a server that answers GET (and, for publishing, HEAD and
// PUT) of BASE/ab/<64 hex digits>.db, where "ab" is the first two digits of the file's SHA-256. A
// folder has its files at the same paths, so any web server can serve it. Files are only ever
// added, and always whole. Thread-safe.
class Store {
 public:
  virtual ~Store() = default;

  // Adds a file; in place of a file of that hash whose bytes are different, if the store has one.
  // Throws MapError: kFileUnreadable, also for a file whose hash has changed meanwhile,
  // kFileUnwritable for a store that doesn't take it, and kStoreUnavailable for one that can't be
  // reached.
  virtual void Put(const std::filesystem::path& file, const std::string& sha256,
                   int64_t bytes) const = 0;
  // Passes the bytes of a file of `bytes` in total to the sink, from `offset` on. They are what the
  // store has: the caller must verify them. Throws what the sink throws, and
  // MapError(kStoreUnavailable) when the store can't be reached, doesn't have the file, or its file
  // ends early.
  virtual void Fetch(const std::string& sha256, int64_t offset, int64_t bytes,
                     FileSink& sink) const = 0;
};

// The store at a location: a folder (created when something is put there), or the address (http://
// or https://) of a server. The environment variable WAYSTONE_STORE_TOKEN, if set, is sent as a
// bearer token. Throws MapError(kUsage) for any other address.
std::unique_ptr<Store> OpenStore(const std::string& location);

// "ab/<64 hex digits>.db" for "sha256:ab...".
std::string StorePath(const std::string& sha256);

// Throws MapError(kFileUnreadable) for a file whose hash has changed meanwhile.
[[noreturn]] void ThrowChanged(const std::filesystem::path& file);

}  // namespace waystone
