// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/mutate_bytes.h"

// Readers of what strangers send, each with what must hold whatever it is given. libFuzzer looks
// for inputs that break them (`make fuzz`); replay_test.cc tries those of corpus/ and simple
// mutations of them (`make test`). A target throws what breaks it, and returns whether the
// input was accepted.
namespace waystone {

bool FuzzBase64(FuzzInput input);
bool FuzzCameraFile(FuzzInput input);
bool FuzzChunkedBody(FuzzInput input);
bool FuzzCoarseEntry(FuzzInput input);
bool FuzzDatasetList(FuzzInput input);
bool FuzzEditList(FuzzInput input);
bool FuzzExif(FuzzInput input);
bool FuzzHttpHead(FuzzInput input);
bool FuzzImage(FuzzInput input);
bool FuzzLocalizeRequest(FuzzInput input);
bool FuzzMap(FuzzInput input);
bool FuzzMultipart(FuzzInput input);
bool FuzzNamesFile(FuzzInput input);
bool FuzzPoseFile(FuzzInput input);
bool FuzzQueryLog(FuzzInput input);
bool FuzzRequestJson(FuzzInput input);
bool FuzzRigFile(FuzzInput input);
bool FuzzServerNames(FuzzInput input);

struct FuzzTarget {
  std::string_view name;  // its folder in corpus/
  bool (*run)(FuzzInput);
  int mutations;     // of the short form: about a second's worth
  size_t max_bytes;  // of an input
  std::string (*mutate)(std::string bytes, size_t max_bytes, uint32_t seed,
                        const MutateBytes& mutate) = nullptr;  // for what has checksums
};

std::span<const FuzzTarget> FuzzTargets();

}  // namespace waystone
