// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "builder/joining/recognise_keyframes.h"
#include "builder/planes/keyframe_sample.h"
#include "core/features/features.h"
#include "schema/map_data.h"

namespace waystone {

// Predicts where a keyframe's features are in another image of the same place from matched features
// of both. A prediction uses the nearest matches on all sides, which must move by one affinity:
// where they don't, there is a depth edge, and what was seen beside it may be hidden now. Immutable
// after construction.
class LocalMotion {
 public:
  // Pixels of the keyframe and of the image, row by row; the image is `width` px wide.
  LocalMotion(std::vector<Eigen::Vector2d> in_keyframe, std::vector<Eigen::Vector2d> in_image,
              int width);

  // Nothing where the matches don't surround `x`, don't agree, or say that it would be seen from
  // much nearer, farther or more obliquely.
  std::optional<Eigen::Vector2d> Predict(const Eigen::Vector2d& x) const;

 private:
  std::vector<int> NearestAround(const Eigen::Vector2d& x) const;

  std::vector<Eigen::Vector2d> in_keyframe_;
  std::vector<Eigen::Vector2d> in_image_;
  double width_;
};

struct LookCounts {
  int looked = 0;  // features that some image should have shown
  int found = 0;   // of them, in one image or more
};

// Looks in the images of a walk for the features of a map. Each image that is localized in the map
// is compared with the keyframes around the place; features that should be well inside the image
// and look as before are looked for, and found where a similar feature is near. An image in which
// few were found is ignored: it is dark or blurred, something is in front of it, or it is of
// another place. `images` are some of those of `walk`; `asked` is AskMap's result for them and the
// map. Adds what was found to map.looks, by the ids that AppendMap will give the sequences of
// `walk`. Deterministic, on any number of threads.
LookCounts LookAgain(const AskedMap& asked, const MapData& walk,
                     const std::vector<WalkImage>& images, MapData& map);

}  // namespace waystone
