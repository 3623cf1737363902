// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz_targets.h"

#include <array>

namespace waystone {

std::span<const FuzzTarget> FuzzTargets() {
  static constexpr std::array kTargets{
      FuzzTarget{"base64", FuzzBase64, 100'000, 4096},
      FuzzTarget{"camera_file", FuzzCameraFile, 4000, 4096},
      FuzzTarget{"chunked_body", FuzzChunkedBody, 50'000, 4096},
      FuzzTarget{"coarse_entry", FuzzCoarseEntry, 100'000, 4096},
      FuzzTarget{"dataset_list", FuzzDatasetList, 2000, 4096},
      FuzzTarget{"edit_list", FuzzEditList, 20'000, 4096},
      FuzzTarget{"exif", FuzzExif, 100'000, 4096},
      FuzzTarget{"http_head", FuzzHttpHead, 30'000, 16'384},
      FuzzTarget{"image", FuzzImage, 10'000, 16'384, MutateImage},
      FuzzTarget{"localize_request", FuzzLocalizeRequest, 20'000, 4096},
      FuzzTarget{"map", FuzzMap, 50, 65'536, MutateMap},
      FuzzTarget{"multipart", FuzzMultipart, 50'000, 4096},
      FuzzTarget{"names_file", FuzzNamesFile, 5000, 4096},
      FuzzTarget{"pose_file", FuzzPoseFile, 10'000, 4096},
      FuzzTarget{"query_log", FuzzQueryLog, 5000, 4096},
      FuzzTarget{"request_json", FuzzRequestJson, 20'000, 4096},
      FuzzTarget{"rig_file", FuzzRigFile, 3000, 4096},
      FuzzTarget{"server_names", FuzzServerNames, 50'000, 512},
  };
  return kTargets;
}

}  // namespace waystone
