// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"

namespace waystone {

const ErrorInfo& InfoOf(ErrorCode code) {
  static constexpr ErrorInfo kUsage{"usage", "The command line makes no sense", 2, 400};
  static constexpr ErrorInfo kBadOptions{"bad_options", "An option is out of its range", 2, 400};
  static constexpr ErrorInfo kBadSource{"bad_source", "The source has no usable image", 3, 422};
  static constexpr ErrorInfo kBadCamera{"bad_camera", "The camera can't be used", 3, 422};
  static constexpr ErrorInfo kBadImage{"bad_image", "The image can't be read", 3, 422};
  static constexpr ErrorInfo kImageTooLarge{"image_too_large", "The image is too large", 3, 413};
  static constexpr ErrorInfo kNotAMap{"not_a_map", "The file is not a Waystone map", 3, 500};
  static constexpr ErrorInfo kMapDamaged{"map_damaged", "The map is damaged", 3, 500};
  static constexpr ErrorInfo kMapVersion{"map_version", "The map has another version", 3, 500};
  static constexpr ErrorInfo kFileExists{"file_exists", "The file exists already", 3, 409};
  static constexpr ErrorInfo kFileUnreadable{"file_unreadable", "A file can't be read", 3, 500};
  static constexpr ErrorInfo kFileUnwritable{"file_unwritable", "A file can't be written", 3, 500};
  static constexpr ErrorInfo kNotFound{"not_found", "There is no such thing here", 3, 404};
  static constexpr ErrorInfo kNoLayer{"no_layer", "The map has no such layer", 3, 404};
  static constexpr ErrorInfo kBadRequest{"bad_request", "The request makes no sense", 3, 400};
  static constexpr ErrorInfo kPayload{"payload_too_large", "The body is too large", 3, 413};
  static constexpr ErrorInfo kMedia{"unsupported_media_type", "Send the image itself", 3, 415};
  static constexpr ErrorInfo kMethod{"method_not_allowed", "Use another method", 3, 405};
  static constexpr ErrorInfo kBusy{"busy", "Too many queries at once", 3, 429};
  static constexpr ErrorInfo kUnauthorized{"unauthorized", "Show who you are", 3, 401};
  static constexpr ErrorInfo kTooSlow{"too_slow", "The body came too slowly", 3, 408};
  static constexpr ErrorInfo kNotAvailable{"not_available", "The map doesn't have this", 3, 422};
  static constexpr ErrorInfo kNotReady{"not_ready", "The server is not ready", 3, 503};
  static constexpr ErrorInfo kInterrupted{"interrupted", "Interrupted", 130, 503};
  static constexpr ErrorInfo kInternal{"internal", "A bug in Waystone", 5, 500};
  switch (code) {
    case ErrorCode::kUsage:
      return kUsage;
    case ErrorCode::kBadOptions:
      return kBadOptions;
    case ErrorCode::kBadSource:
      return kBadSource;
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
    case ErrorCode::kUnsupportedMedia:
      return kMedia;
    case ErrorCode::kMethodNotAllowed:
      return kMethod;
    case ErrorCode::kBusy:
      return kBusy;
    case ErrorCode::kUnauthorized:
      return kUnauthorized;
    case ErrorCode::kTooSlow:
      return kTooSlow;
    case ErrorCode::kNotAvailable:
      return kNotAvailable;
    case ErrorCode::kNotReady:
      return kNotReady;
    case ErrorCode::kInterrupted:
      return kInterrupted;
    case ErrorCode::kInternal:
      return kInternal;
  }
  return kInternal;
}

}  // namespace waystone
