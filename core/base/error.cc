// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"

namespace waystone {

const ErrorInfo& InfoOf(ErrorCode code) {
  static constexpr ErrorInfo kUsage{"usage", "Invalid command line", 2, 400};
  static constexpr ErrorInfo kBadOptions{"bad_options", "Option out of range", 2, 400};
  static constexpr ErrorInfo kBadSource{"bad_source", "No usable image in the source", 3, 422};
  static constexpr ErrorInfo kFrames{"unreadable_frames", "Too many unreadable frames", 4, 422};
  static constexpr ErrorInfo kBadCamera{"bad_camera", "Invalid camera", 3, 422};
  static constexpr ErrorInfo kBadImage{"bad_image", "Image can't be decoded", 3, 422};
  static constexpr ErrorInfo kImageTooLarge{"image_too_large", "Image too large", 3, 413};
  static constexpr ErrorInfo kNotAMap{"not_a_map", "Not a Waystone map", 3, 500};
  static constexpr ErrorInfo kMapDamaged{"map_damaged", "Map damaged", 3, 500};
  static constexpr ErrorInfo kMapVersion{"map_version", "Unsupported map version", 3, 500};
  static constexpr ErrorInfo kFileExists{"file_exists", "File already exists", 3, 409};
  static constexpr ErrorInfo kFileUnreadable{"file_unreadable", "File can't be read", 3, 500};
  static constexpr ErrorInfo kFileUnwritable{"file_unwritable", "File can't be written", 3, 500};
  static constexpr ErrorInfo kNotFound{"not_found", "Not found", 3, 404};
  static constexpr ErrorInfo kNoLayer{"no_layer", "Layer not in this map", 3, 404};
  static constexpr ErrorInfo kBadRequest{"bad_request", "Invalid request", 3, 400};
  static constexpr ErrorInfo kPayload{"payload_too_large", "Request body too large", 3, 413};
  static constexpr ErrorInfo kHead{"head_too_large", "Request headers too large", 3, 431};
  static constexpr ErrorInfo kMedia{"unsupported_media_type", "Unsupported media type", 3, 415};
  static constexpr ErrorInfo kMethod{"method_not_allowed", "Method not allowed", 3, 405};
  static constexpr ErrorInfo kBusy{"busy", "Too many concurrent queries", 3, 429};
  static constexpr ErrorInfo kUnauthorized{"unauthorized", "Authentication required", 3, 401};
  static constexpr ErrorInfo kForeignPage{"foreign_page", "Request from another site", 3, 403};
  static constexpr ErrorInfo kMisdirected{"misdirected", "Unknown host name", 3, 421};
  static constexpr ErrorInfo kTooSlow{"too_slow", "Request timed out", 3, 408};
  static constexpr ErrorInfo kNotAvailable{"not_available", "Not available in this map", 3, 422};
  static constexpr ErrorInfo kNotReady{"not_ready", "Server not ready", 3, 503};
  static constexpr ErrorInfo kRegistry{"registry_unavailable", "Registry can't be reached", 6, 503};
  static constexpr ErrorInfo kStore{"store_unavailable", "Store of maps can't be reached", 6, 503};
  static constexpr ErrorInfo kStoreDamaged{"store_damaged", "File in the store damaged", 3, 503};
  static constexpr ErrorInfo kNoRoom{"no_room", "No room for the map", 3, 503};
  static constexpr ErrorInfo kOutOfMemory{"out_of_memory", "Out of memory", 3, 503};
  static constexpr ErrorInfo kInterrupted{"interrupted", "Interrupted", 130, 503};
  static constexpr ErrorInfo kInternal{"internal", "Internal error", 5, 500};
  switch (code) {
    case ErrorCode::kUsage:
      return kUsage;
    case ErrorCode::kBadOptions:
      return kBadOptions;
    case ErrorCode::kBadSource:
      return kBadSource;
    case ErrorCode::kUnreadableFrames:
      return kFrames;
    case ErrorCode::kBadCamera:
      return kBadCamera;
    case ErrorCode::kBadImage:
      return kBadImage;
    case ErrorCode::kImageTooLarge:
      return kImageTooLarge;
    case ErrorCode::kNotAMap:
      return kNotAMap;
    case ErrorCode::kMapDamaged:
      return kMapDamaged;
    case ErrorCode::kMapVersion:
      return kMapVersion;
    case ErrorCode::kFileExists:
      return kFileExists;
    case ErrorCode::kFileUnreadable:
      return kFileUnreadable;
    case ErrorCode::kFileUnwritable:
      return kFileUnwritable;
    case ErrorCode::kNotFound:
      return kNotFound;
    case ErrorCode::kNoLayer:
      return kNoLayer;
    case ErrorCode::kBadRequest:
      return kBadRequest;
    case ErrorCode::kPayloadTooLarge:
      return kPayload;
    case ErrorCode::kHeadTooLarge:
      return kHead;
    case ErrorCode::kUnsupportedMedia:
      return kMedia;
    case ErrorCode::kMethodNotAllowed:
      return kMethod;
    case ErrorCode::kBusy:
      return kBusy;
    case ErrorCode::kUnauthorized:
      return kUnauthorized;
    case ErrorCode::kForeignPage:
      return kForeignPage;
    case ErrorCode::kMisdirected:
      return kMisdirected;
    case ErrorCode::kTooSlow:
      return kTooSlow;
    case ErrorCode::kNotAvailable:
      return kNotAvailable;
    case ErrorCode::kNotReady:
      return kNotReady;
    case ErrorCode::kRegistryUnavailable:
      return kRegistry;
    case ErrorCode::kStoreUnavailable:
      return kStore;
    case ErrorCode::kStoreDamaged:
      return kStoreDamaged;
    case ErrorCode::kNoRoom:
      return kNoRoom;
    case ErrorCode::kOutOfMemory:
      return kOutOfMemory;
    case ErrorCode::kInterrupted:
      return kInterrupted;
    case ErrorCode::kInternal:
      return kInternal;
  }
  return kInternal;
}

}  // namespace waystone
