// SPDX-License-Identifier: Apache-2.0
// Panoramas in files: recognised by themselves, and refused with a remedy.
#include <opencv2/imgproc.hpp>

#include "builder/layer_choice.h"

#include "core/camera/cube_faces.h"
#include "tests/builder/appearance/drive.h"
#include "tests/builder/sources/temporary_folder.h"

namespace waystone {
namespace {

class PanoramaSourcesTest : public TemporaryFolder {
 protected:
  void WritePanorama(const std::string& name, const cv::Mat& image) {
    ASSERT_TRUE(cv::imwrite((folder_ / name).string(), image));
  }
  // The faces of a panorama under a name each, such as "000/front.png" for "000/%.png".
  void WriteFaces(const std::string& pattern, const cv::Mat& panorama, int faces = kCubeFaces) {
    for (int i = 0; i < faces; ++i) {
      const auto face = static_cast<CubeFace>(i);
      std::string name = pattern;
      name.replace(name.find('%'), 1, NameOf(face));
      std::filesystem::create_directories((folder_ / name).parent_path());
      ASSERT_TRUE(cv::imwrite((folder_ / name).string(), FaceOf(panorama, face, 64)));
    }
  }
};

TEST_F(PanoramaSourcesTest, AFolderOfPanoramasLooksPanoramic) {
  WritePanorama("a.png", TheDrive().panoramas[0]);
  EXPECT_TRUE(LooksPanoramic(*Open()));
}

TEST_F(PanoramaSourcesTest, AFolderOfPhotosDoesNot) {
  WriteImage("a.png", 100, {64, 48});
  EXPECT_FALSE(LooksPanoramic(*Open()));
}

TEST_F(PanoramaSourcesTest, NumberedRigFoldersArePanoramas) {
  for (int i = 0; i < 3; ++i)
    WriteFaces("00" + std::to_string(i) + "/%.png", TheDrive().panoramas[i]);
  const auto source = Open();
  EXPECT_EQ(source->kind(), "rig");
  EXPECT_TRUE(LooksPanoramic(*source));
  EXPECT_EQ(source->Announcement(), "Rig of 6 faces, 3 panoramas");
  const std::vector<Frame> frames = AllFrames(*source);
  EXPECT_EQ(NamesOf(frames), (std::vector<std::string>{"000", "001", "002"}));
  cv::Mat truth;
  cv::resize(TheDrive().panoramas[1], truth, frames[1].grey.size(), 0, 0, cv::INTER_LINEAR);
  EXPECT_LT(cv::norm(frames[1].grey, truth, cv::NORM_L1) / static_cast<double>(truth.total()), 12);
}

TEST_F(PanoramaSourcesTest, AFolderAFaceIsARigTooAndNeedsNoUpAndDown) {
  for (int i = 0; i < 2; ++i)
    WriteFaces("%/0" + std::to_string(i) + ".png", TheDrive().panoramas[i], 4);
  const auto source = Open();
  EXPECT_EQ(source->Announcement(), "Rig of 4 faces, 2 panoramas");
  const BuiltAppearance result = BuildAppearance({source.get()});
  EXPECT_EQ(result.layer.nodes.size(), 2);
  EXPECT_LT(result.layer.described.band.top_rad, 0.62);
}

TEST_F(PanoramaSourcesTest, AMissingFaceIsNamed) {
  for (int i = 0; i < 2; ++i)
    WriteFaces("%/0" + std::to_string(i) + ".png", TheDrive().panoramas[i]);
  std::filesystem::remove(folder_ / "left" / "01.png");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"2 images of front", "1 of left"});
}

TEST_F(PanoramaSourcesTest, DifferentSizesInASequenceAreNamedAndRefused) {
  WritePanorama("0.png", TheDrive().panoramas[0]);
  cv::Mat larger;
  cv::resize(TheDrive().panoramas[1], larger, {512, 256}, 0, 0, cv::INTER_LINEAR);
  WritePanorama("1.png", larger);
  const auto source = Open();
  ExpectError([&] { BuildAppearance({source.get()}); }, ErrorCode::kBadSource,
              {"1 usable panorama of 2 frames", "1.png: it is 512x256", "256x128"});
}

}  // namespace
}  // namespace waystone
