// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/looked_at_source.h"

#include <utility>

#include "core/base/clock.h"
#include "core/base/error.h"

namespace waystone {
namespace {

SourceRig RequireRig(const Source& source) {
  std::optional<SourceRig> head = RigOfSource(source);
  if (head) return std::move(*head);
  throw MapError(ErrorCode::kBadCamera, source.name() + " has no camera; use --camera");
}

OrientationViewPtr Unreadable(const FrameInfo& info, const std::string& error) {
  auto view = std::make_shared<OrientationView>();
  view->info = info;
  view->error = error;
  return view;
}

}  // namespace

LookedAtSource::LookedAtSource(SequenceId id, Source& source, const OrientationOptions& options,
                               OrientationBuilder& builder)
    : id_(id), source_(source), head_(RequireRig(source)), options_(options), builder_(builder) {}

std::optional<EncodedFrame> LookedAtSource::NextEncoded() {
  if (given_ == 0) builder_.StartSequence(id_);
  const std::optional<EncodedFrame> frame = source_.NextEncoded();
  if (!frame) return std::nullopt;
  const int place = given_++;
  return EncodedFrame(
      frame->info(), [this, frame = *frame, place] { return LoadAndLook(frame, place); },
      [frame = *frame](const std::vector<cv::Mat>& images) { return frame.Join(images); });
}

std::vector<cv::Mat> LookedAtSource::LoadAndLook(const EncodedFrame& frame, int place) {
  std::vector<cv::Mat> images;
  try {
    images = frame.Load();
  } catch (const MapError& error) {
    HandOver(place, Unreadable(frame.info(), error.what()), 0);
    throw;
  }
  const Clock::time_point start = Clock::now();
  const auto load = [&] { return head_.ImagesOf(images); };
  auto view = std::make_shared<OrientationView>(
      LookAt(head_.rig, {.info = frame.info(), .load = load}, options_));
  HandOver(place, std::move(view), SecondsSince(start));
  return images;
}

// A frame that is decoded again has been handed over before.
void LookedAtSource::HandOver(int place, OrientationViewPtr view, double look_s) {
  std::unique_lock lock(mutex_);
  if (place < next_ || !waiting_.emplace(place, std::move(view)).second) return;
  look_s_ += look_s;
  if (handing_over_) return;
  handing_over_ = true;
  for (auto at = waiting_.begin(); at != waiting_.end() && at->first == next_;
       at = waiting_.begin()) {
    const OrientationViewPtr ready = std::move(at->second);
    waiting_.erase(at);
    ++next_;
    lock.unlock();
    builder_.Add(ready);
    lock.lock();
  }
  handing_over_ = false;
}

}  // namespace waystone
