// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "builder/sources/source.h"
#include "schema/sequence_kinds.h"

namespace waystone {

// A sequence that is made by a program rather than read from files.
struct MemorySequence {
  std::string name;
  std::vector<EncodedFrame> frames = {};
  std::optional<Camera> camera = {};
  std::optional<Rig> faces = {};
  cv::Size frame_size = {};  // px; 0 by 0 where it isn't known
};

// Gives the frames of such a sequence. Not thread-safe, as Source.
class MemorySource : public Source {
 public:
  explicit MemorySource(MemorySequence sequence) : sequence_(std::move(sequence)) {}

  const std::string& kind() const override { return kind_; }
  const std::string& name() const override { return sequence_.name; }
  int size() const override { return static_cast<int>(sequence_.frames.size()); }
  const std::optional<Camera>& camera() const override { return sequence_.camera; }
  cv::Size frame_size() const override { return sequence_.frame_size; }
  std::optional<Rig> faces() const override { return sequence_.faces; }
  std::string Announcement() const override;
  std::optional<EncodedFrame> NextEncoded() override;

 private:
  std::string kind_ = kFolderKind;
  MemorySequence sequence_;
  int next_ = 0;
};

}  // namespace waystone
