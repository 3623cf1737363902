// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace waystone {

// Takes the bytes of a file in order.
class FileSink {
 public:
  virtual ~FileSink() = default;
  // The next bytes are those from this offset on: what was asked for, or 0 from a store that can't
  // send a part of a file. Called once, first. May throw MapError.
  virtual void Begin(int64_t offset) = 0;
  // May throw MapError. False ends the transfer.
  virtual bool Take(std::span<const char> bytes) = 0;
};

// Where map files are kept: a folder, or a server that answers GET (and for publishing HEAD and
// PUT) of BASE/ab/<64 hex digits>.db, "ab" being the first two digits of the file's SHA-256. A
// folder has its files at the same paths, so that any web server can serve it. Files are only ever
// added, and whole. Thread-safe.
class Store {
 public:
  virtual ~Store() = default;

  // Adds a file; one of that hash which the store has, but with other bytes, is replaced. Throws
  // MapError: kFileUnreadable, also for a file that has another hash by now, and kFileUnwritable
  // for a store that doesn't take it, kStoreUnavailable for one that can't be reached.
  virtual void Put(const std::filesystem::path& file, const std::string& sha256,
                   int64_t bytes) const = 0;
  // Gives the bytes of a file from `offset` on to the sink, at most `bytes` of the whole file. They
  // are what the store has: the caller verifies them. Throws what the sink throws, and
  // MapError(kStoreUnavailable) when the store can't be reached, hasn't got the file or ends early.
  virtual void Fetch(const std::string& sha256, int64_t offset, int64_t bytes,
                     FileSink& sink) const = 0;
};

// The store at a location: a folder (created when something is put there), or the address
// (http:// or https://) of a server. The environment variable WAYSTONE_STORE_TOKEN, where it is
// set, is sent as a bearer token. Throws MapError(kUsage) for another kind of address.
std::unique_ptr<Store> OpenStore(const std::string& location);

// "ab/<64 hex digits>.db" for "sha256:ab...".
std::string StorePath(const std::string& sha256);

// For a file that has another hash by now.
[[noreturn]] void ThrowChanged(const std::filesystem::path& file);

}  // namespace waystone
