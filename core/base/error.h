// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <string>
#include <string_view>

namespace waystone {

// What can go wrong with a user's input. The one table in error.cc gives each its stable name (the
// `code` of a problem+json), its exit code and its HTTP status.
enum class ErrorCode {
  kUsage,                // a flag or argument that makes no sense
  kBadOptions,           // an option out of its range
  kBadSource,            // an image sequence with no usable frame, or of no known kind
  kUnreadableFrames,     // an image sequence of which too many frames can't be read
  kBadCamera,            // a camera file that can't be read, or a model we don't know
  kBadImage,             // bytes that are not an image, or a damaged one
  kImageTooLarge,        // an image whose header claims more pixels than we decode
  kNotAMap,              // a file that is not a Waystone map
  kMapDamaged,           // a map that fails a check
  kMapVersion,           // a map of another schema version
  kFileExists,           // the output is there and --force isn't given
  kFileUnreadable,       // missing, or no permission
  kFileUnwritable,       // read-only folder, full disk
  kNotFound,             // no such map, plane or keyframe
  kNoLayer,              // a layer that this map was built without
  kBadRequest,           // an HTTP request that can't be understood
  kPayloadTooLarge,      // a body over the limit
  kHeadTooLarge,         // an HTTP request whose request line or headers are over the limits
  kUnsupportedMedia,     // a body of a kind that is not taken
  kMethodNotAllowed,     // a known path requested with another method
  kBusy,                 // the queue of queries is full
  kUnauthorized,         // no token, or not one of ours
  kForeignPage,          // a request made by a web page of another site
  kMisdirected,          // an HTTP request with a host name that isn't the server's
  kTooSlow,              // a body that takes longer than the server waits
  kNotAvailable,         // what this map's layers can't give
  kNotReady,             // a server that has no map yet, or ends
  kRegistryUnavailable,  // a registry of maps that can't be reached now
  kStoreUnavailable,     // a store of map files that can't be reached, or hasn't got the file
  kStoreDamaged,         // a store that sends other bytes than were published
  kNoRoom,               // a map that doesn't fit into the memory or cache bounds, or onto the disk
  kOutOfMemory,          // not enough memory for a map, an image or a build
  kInterrupted,          // Ctrl-C
  kInternal,             // a bug of ours
};

struct ErrorInfo {
  std::string_view name;   // stable, snake_case
  std::string_view title;  // a short sentence for people
  // Of the program: 2 usage, 3 input or output, 4 no usable result, 5 internal, 6 registry or
  // store.
  int exit_code;
  int http_status;
};

// The row of the table for `code`. Never fails. Thread-safe.
const ErrorInfo& InfoOf(ErrorCode code);

// A bad file, map, option or request. `what()` is one line: the cause with the number at fault,
// then the remedy. "Not in this map" is a result, never an error.
class MapError : public std::exception {
 public:
  MapError(ErrorCode code, std::string message) : code_(code), message_(std::move(message)) {}

  ErrorCode code() const { return code_; }
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  ErrorCode code_;
  std::string message_;
};

}  // namespace waystone
