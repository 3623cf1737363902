// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/mutate_bytes.h"

// Readers of what strangers send, each with what must hold whatever it is given. libFuzzer looks
// for inputs that break them (`make fuzz`); replay_test.cc tries those of corpus/ and simple
// mutations of them (`make test`). A target throws what breaks it.
namespace waystone {

void FuzzBase64(FuzzInput input);
void FuzzCameraFile(FuzzInput input);
void FuzzChunkedBody(FuzzInput input);
void FuzzCoarseEntry(FuzzInput input);
void FuzzExif(FuzzInput input);
void FuzzHttpHead(FuzzInput input);
void FuzzImage(FuzzInput input);
void FuzzLocalizeRequest(FuzzInput input);
void FuzzMap(FuzzInput input);
void FuzzMultipart(FuzzInput input);
void FuzzNamesFile(FuzzInput input);
void FuzzPoseFile(FuzzInput input);
void FuzzQueryLog(FuzzInput input);
void FuzzRequestJson(FuzzInput input);
void FuzzRigFile(FuzzInput input);
void FuzzServerNames(FuzzInput input);

struct FuzzTarget {
  std::string_view name;  // its folder in corpus/
  void (*run)(FuzzInput);
  int mutations;     // of the short form: about a second's worth
  size_t max_bytes;  // of an input
  std::string (*mutate)(std::string bytes, size_t max_bytes, uint32_t seed,
                        const MutateBytes& mutate) = nullptr;  // for what has checksums
};

std::span<const FuzzTarget> FuzzTargets();

}  // namespace waystone
