// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/link_revisits.h"

#include <gtest/gtest.h>

#include "builder/joining/append_map.h"
#include "tests/builder/map/stage.h"

namespace waystone {
namespace {

// The keyframes of a walk and their images. Each is in a stretch of its own, and no plane is seen
// by two of them.
struct Photos {
  MapData map;
  std::vector<SampledKeyframe> images;
};
Photos TakePhotos(bool in_one_sequence) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenStage(45));
  BuildResult built = BuildMap(sources, {}, {}, std::nullopt, BuiltFeatures::kKeep);
  Photos photos{std::move(built.map), {}};
  MapData& map = photos.map;
  map.edges.clear();
  map.links.clear();
  for (Plane& plane : map.planes) {
    std::erase_if(plane.views,
                  [&](const PlaneView& view) { return view.keyframe != plane.reference; });
  }
  for (Keyframe& keyframe : map.keyframes) {
    keyframe.stretch = static_cast<int>(keyframe.id.value);
    for (WalkImage& image : built.features) {
      if (image.frame == keyframe.frame) photos.images.push_back({keyframe.id, image.features});
    }
    if (in_one_sequence) continue;
    keyframe.sequence = SequenceId{keyframe.id.value};
    map.sequences.resize(map.keyframes.size(), map.sequences.front());
    map.sequences[keyframe.id.value - 1].id = keyframe.sequence;
  }
  return photos;
}

int LinksOf(Photos photos) {
  ProgressReporter nobody;
  LinkRevisits(photos.images, {}, photos.map, nobody);
  return static_cast<int>(photos.map.links.size());
}

// Most are found by the next one, and no other image of their stretch confirms it.
TEST(LinkRevisits, ReachesAcrossTheEndOfAStretch) {
  const Photos photos = TakePhotos(true);
  ASSERT_GE(photos.images.size(), 3u);
  EXPECT_GE(2 * LinksOf(photos), static_cast<int>(photos.images.size()));
}

TEST(LinkRevisits, OneImageOfAnotherWalkIsNoProof) { EXPECT_EQ(LinksOf(TakePhotos(false)), 0); }

// Photos, and a second visit whose images show them. Only its images are at hand.
Photos VisitAgain(Photos photos) {
  Photos visit = TakePhotos(true);
  const auto behind = static_cast<int64_t>(photos.map.keyframes.size());
  for (SampledKeyframe& image : visit.images) image.keyframe.value += behind;
  AppendMap(std::move(visit.map), photos.map);
  photos.images = std::move(visit.images);
  return photos;
}

// The images before and after were found just before and after.
TEST(LinkRevisits, PhotosInARowConfirmEachOther) {
  EXPECT_GT(LinksOf(VisitAgain(TakePhotos(true))), 0);
}

}  // namespace
}  // namespace waystone
