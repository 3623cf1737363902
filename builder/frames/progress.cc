// SPDX-License-Identifier: Apache-2.0
#include "builder/frames/progress.h"

#include "core/base/error.h"

namespace waystone {

void ProgressReporter::Report(const std::string& stage, int done, int total) {
  if (!callback_) return;
  const std::lock_guard lock(calling_);
  if (callback_({stage, done, total, keyframes_, planes_, panoramas_})) return;
  throw MapError(ErrorCode::kInterrupted, "interrupted; nothing was written");
}

void ProgressReporter::SetPlanes(int keyframes, int planes) {
  keyframes_ = keyframes;
  planes_ = planes;
}

}  // namespace waystone
