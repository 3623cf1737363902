// SPDX-License-Identifier: Apache-2.0
#include "builder/frames/frame_report.h"

namespace waystone {
namespace {

constexpr size_t kMaxNamedSkips = 20;

}  // namespace

void FrameReport::Count(const FrameInfo& info, const std::string& error) {
  ++frames;
  if (error.empty()) return;
  ++skipped;
  if (skipped_names.size() < kMaxNamedSkips) skipped_names.push_back(info.source + ": " + error);
}

void FrameReport::Append(const FrameReport& other) {
  frames += other.frames;
  skipped += other.skipped;
  for (const std::string& name : other.skipped_names) {
    if (skipped_names.size() < kMaxNamedSkips) skipped_names.push_back(name);
  }
  decode_s += other.decode_s;
  observe_s += other.observe_s;
  add_s += other.add_s;
}

}  // namespace waystone
