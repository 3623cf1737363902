// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "builder/orientation/orientation_layer.h"
#include "builder/orientation/view.h"
#include "builder/sources/source.h"

namespace waystone {

// A calibrated source whose frames are also looked at for the orientation layer where they are
// decoded, on the thread that decodes them: another layer is built of it, and each image is decoded
// once for both. The builder gets the views in order; one thread at a time hands over those that
// are ready, while the others go on. As Source otherwise.
class LookedAtSource : public Source {
 public:
  // All three must outlive it and the frames that it gives. Throws MapError(kBadCamera) for a
  // source without a calibration.
  LookedAtSource(SequenceId id, Source& source, const OrientationOptions& options,
                 OrientationBuilder& builder);

  const std::string& kind() const override { return source_.kind(); }
  const std::string& name() const override { return source_.name(); }
  int size() const override { return source_.size(); }
  const std::optional<Camera>& camera() const override { return source_.camera(); }
  cv::Size frame_size() const override { return source_.frame_size(); }
  std::optional<Rig> faces() const override { return source_.faces(); }
  std::string Announcement() const override { return source_.Announcement(); }
  std::optional<EncodedFrame> NextEncoded() override;

  double look_s() const { return look_s_; }  // summed over threads; after the last frame

 private:
  std::vector<cv::Mat> LoadAndLook(const EncodedFrame& frame, int place);
  void HandOver(int place, OrientationViewPtr view, double look_s);

  SequenceId id_;
  Source& source_;
  SourceRig head_;
  OrientationOptions options_;
  OrientationBuilder& builder_;
  int given_ = 0;  // frames

  std::mutex mutex_;  // guards the following
  std::map<int, OrientationViewPtr> waiting_;
  int next_ = 0;  // place of the view that the builder takes next
  bool handing_over_ = false;
  double look_s_ = 0;
};

}  // namespace waystone
