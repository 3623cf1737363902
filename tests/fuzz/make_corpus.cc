// SPDX-License-Identifier: Apache-2.0
// make_corpus FOLDER: writes the inputs of tests/fuzz/corpus that aren't text into that folder, all
// but image/coded.heic, which is what heif-enc -q 50 (libheif-examples) makes of image/grey.png.
#include <fstream>
#include <iostream>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "localizer/coarse/coarse_entry.h"
#include "schema/file/map_store.h"
#include "tests/builder/sources/made_movie.h"
#include "tests/core/image/made_heic.h"
#include "tests/fuzz/compressed.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;
using Encoded = std::vector<uint8_t>;

void Save(const fs::path& path, const Encoded& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

// A gradient with a circle, small as an icon.
cv::Mat Picture(int type) {
  cv::Mat picture(24, 32, CV_8UC3);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      picture.at<cv::Vec3b>(y, x) = {uint8_t(x * 8), uint8_t(y * 10), uint8_t(x * y)};
    }
  }
  cv::circle(picture, {16, 12}, 7, {250, 20, 90}, cv::FILLED);
  cv::Mat converted = picture;
  if (CV_MAT_CN(type) == 1) cv::cvtColor(picture, converted, cv::COLOR_BGR2GRAY);
  if (CV_MAT_CN(type) == 4) cv::cvtColor(picture, converted, cv::COLOR_BGR2BGRA);
  if (CV_MAT_DEPTH(type) == CV_16U) converted.convertTo(converted, CV_16U, 257);
  return converted;
}

Encoded Encode(const std::string& extension, int type, const std::vector<int>& flags = {}) {
  Encoded bytes;
  cv::imencode(extension, Picture(type), bytes, flags);
  return bytes;
}

void PutBig(Encoded& bytes, uint32_t value, int size) {
  for (int i = size - 1; i >= 0; --i) bytes.push_back(static_cast<uint8_t>(value >> 8 * i));
}

// A focal length of 28 mm on film, of 3200 by 2400 pixels.
Encoded FocalTiff() {
  Encoded tiff = {'M', 'M', 0, 42, 0, 0, 0, 8};
  const auto entry = [&tiff](uint32_t tag, uint32_t type, uint32_t value) {
    constexpr uint32_t kShortType = 3;
    PutBig(tiff, tag, 2);
    PutBig(tiff, type, 2);
    PutBig(tiff, 1, 4);
    PutBig(tiff, type == kShortType ? value << 16 : value, 4);
  };
  PutBig(tiff, 1, 2);
  entry(0x8769, 4, 26);
  PutBig(tiff, 0, 4);
  PutBig(tiff, 3, 2);
  entry(0xA002, 4, 3200);
  entry(0xA003, 3, 2400);
  entry(0xA405, 3, 28);
  PutBig(tiff, 0, 4);
  return tiff;
}

Encoded NamedExif() {
  Encoded exif = {'E', 'x', 'i', 'f', 0, 0};
  const Encoded tiff = FocalTiff();
  exif.insert(exif.end(), tiff.begin(), tiff.end());
  return exif;
}

// A JPEG with an APP1 segment.
Encoded WithExif(Encoded jpeg) {
  const Encoded tiff = NamedExif();
  Encoded segment = {0xFF, 0xE1};
  PutBig(segment, static_cast<uint32_t>(tiff.size()) + 2, 2);
  segment.insert(segment.end(), tiff.begin(), tiff.end());
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}

// Behind a marker without a length stands an application segment, within it a frame header: who
// takes the next two bytes for a length meets that frame first.
Encoded WithHiddenFrame(Encoded jpeg) {
  const Encoded hidden = {0xFF, 0xD0, 0, 6, 0xFF, 0xE2, 0, 15, 0xFF, 0xC0, 0,
                          11,   8,    3, 0, 4,    0,    1, 1,  0x11, 0};
  const auto behind_exif = jpeg.begin() + 4 + jpeg[4] * 256 + jpeg[5];
  jpeg.insert(behind_exif, hidden.begin(), hidden.end());
  return jpeg;
}

// A WebP in its extended form, with EXIF data.
Encoded ExtendedWebp() {
  const Encoded webp = Encode(".webp", CV_8UC3, {cv::IMWRITE_WEBP_QUALITY, 80});
  const Encoded exif = NamedExif();
  Encoded file = {'R', 'I', 'F', 'F', 0, 0, 0, 0, 'W', 'E', 'B', 'P', 'V', 'P', '8',
                  'X', 10,  0,   0,   0, 8, 0, 0, 0,   31,  0,   0,   23,  0,   0};
  file.insert(file.end(), webp.begin() + 12, webp.end());
  file.insert(file.end(), {'E', 'X', 'I', 'F', static_cast<uint8_t>(exif.size()), 0, 0, 0});
  file.insert(file.end(), exif.begin(), exif.end());
  file[4] = static_cast<uint8_t>((file.size() - 8) & 255);
  file[5] = static_cast<uint8_t>((file.size() - 8) >> 8);
  return file;
}

void SaveHeics(const fs::path& folder) {
  const cv::Mat icon = Picture(CV_8UC1)(cv::Rect(0, 0, 32, 16));
  Save(folder / "image/stored.heic", MakeHeic(icon));
  Save(folder / "image/deep.heic", MakeHeic(icon, {.bits = 10, .chroma = true, .turned = true}));
  Save(folder / "image/grid.heic",
       MakeHeic(cv::Mat(64, 128, CV_8UC1, cv::Scalar(9)), {.columns = 2}));
  Save(folder / "exif/photo.heic", MakeHeic(icon, {.exif = FocalTiff()}));
}

void SaveImages(const fs::path& folder) {
  Save(folder / "image/lossy.webp", Encode(".webp", CV_8UC3, {cv::IMWRITE_WEBP_QUALITY, 80}));
  Save(folder / "image/lossless.webp", Encode(".webp", CV_8UC3));
  Save(folder / "image/extended.webp", ExtendedWebp());
  Save(folder / "exif/photo.webp", ExtendedWebp());
  const std::vector<int> progressive{cv::IMWRITE_JPEG_PROGRESSIVE, 1};
  const std::vector<int> restarts{cv::IMWRITE_JPEG_RST_INTERVAL, 2};
  Save(folder / "image/grey.jpg", Encode(".jpg", CV_8UC1));
  Save(folder / "image/colour.jpg", Encode(".jpg", CV_8UC3, restarts));
  Save(folder / "image/progressive.jpg", Encode(".jpg", CV_8UC3, progressive));
  Save(folder / "image/grey.png", Encode(".png", CV_8UC1));
  Save(folder / "image/alpha.png", Encode(".png", CV_8UC4));
  Save(folder / "image/deep.png", Encode(".png", CV_16UC3));
  Save(folder / "image/bits.png", Encode(".png", CV_8UC1, {cv::IMWRITE_PNG_BILEVEL, 1}));
  Save(folder / "image/colour.bmp", Encode(".bmp", CV_8UC3));
  Save(folder / "image/grey.pgm", Encode(".pgm", CV_8UC1));
  Save(folder / "image/colour.ppm", Encode(".ppm", CV_16UC3));
  Save(folder / "exif/photo.jpg", WithExif(Encode(".jpg", CV_8UC1)));
  Save(folder / "exif/hidden_frame.jpg", WithHiddenFrame(WithExif(Encode(".jpg", CV_8UC1))));
  Save(folder / "exif/plain.jpg", Encode(".jpg", CV_8UC1));
}

void SaveMaps(const fs::path& folder) {
  const TemporaryFolder made;
  MapShape small{.sequences = 1, .keyframes = 2, .planes = 2, .max_features = 3, .jpeg_bytes = 20};
  for (const uint64_t seed : {1, 2, 3}) {
    MapData map = MadeMap(seed, small);
    if (seed == 2) map.orientation.reset();
    if (seed == 3) map.appearance.reset();
    WriteMap(map, made / "m.db", {.overwrite = true});
    const std::string bytes = Compress(ReadFile(made / "m.db"));
    Save(folder / ("map/made" + std::to_string(seed)), Encoded(bytes.begin(), bytes.end()));
  }
  // What only some maps have: names, links, what was looked for, and a floor plan.
  small.keyframes = 3;
  MapData map = MadeMap(4, small);
  map.orientation.reset();
  map.appearance.reset();
  const KeyframeId first = map.keyframes[0].id, last = map.keyframes[2].id;
  map.links = {{first, last}};
  const Plane& plane_of_looks = map.planes.front();
  map.looks.planes = {{plane_of_looks.id, map.sequences.front().id,
                       std::vector<FeatureLooks>(plane_of_looks.features.size(), {3, 1})}};
  map.names = {{"Desk", {{NamedKind::kKeyframes, first.value, last.value}}, {}},
               {"Kitchen", {}, {{{0, 0}, {2, 0}, {2, 2}}}}};
  FloorPlanImage plan{"Ground", 32, 24, {{{0, 24}, {0, 0}}, {{32, 24}, {3, 0}}}, {}, {}};
  plan.heights = PlanHeights{-1, 2};
  plan.image = Encode(".png", CV_8UC1);
  map.floor_plans = {plan};
  WriteMap(map, made / "m.db", {.overwrite = true});
  const std::string bytes = Compress(ReadFile(made / "m.db"));
  Save(folder / "map/extras", Encoded(bytes.begin(), bytes.end()));
}

// One track that was trimmed, and one beside sound that begins with a pause.
void SaveMovies(const fs::path& folder) {
  const auto save = [&folder](const std::string& name, const std::string& movie) {
    Save(folder / "edit_list" / name, Encoded(movie.begin(), movie.end()));
  };
  save("trimmed.mp4", Movie(Track("vide", Edit(4000, 90'000), 1)));
  save("paused.mp4", Movie(Track("soun", Edit(1000, 0), 1) +
                           Track("vide", Edit(9000, 0xffffffff) + Edit(2000, 0), 2)));
}

// An entry of the coarse index with so many codes a place.
void SaveEntry(const fs::path& path, FeatureType type, int keyframes,
               const std::vector<uint8_t>& codes_of) {
  CoarseEntry entry;
  entry.map_version = "sha256:" + std::string("0123456789abcdef0123456789abcdef") +
                      "0123456789abcdef0123456789abcdef";
  entry.feature_type = type;
  entry.working_pixels = keyframes > 0 ? 640 * 480 : 0;
  entry.keyframes = keyframes;
  entry.codes_of = codes_of;
  const int codes = std::accumulate(codes_of.begin(), codes_of.end(), 0);
  for (int i = 0; i < codes; ++i) {
    entry.words.push_back(static_cast<uint16_t>(i * 977));
    entry.signatures.push_back(static_cast<uint64_t>(i) * 0x9E3779B97F4A7C15);
  }
  const std::string bytes = EncodeCoarseEntry(entry);
  Save(path, Encoded(bytes.begin(), bytes.end()));
}

void SaveEntries(const fs::path& folder) {
  SaveEntry(folder / "coarse_entry/photos", FeatureType::kSift, 3, {5, 0, 7});
  SaveEntry(folder / "coarse_entry/panoramas", FeatureType::kOrb, 0, {3, 4});
}

}  // namespace
}  // namespace waystone

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: make_corpus FOLDER\n";
    return 2;
  }
  waystone::SaveImages(argv[1]);
  waystone::SaveHeics(argv[1]);
  waystone::SaveMaps(argv[1]);
  waystone::SaveEntries(argv[1]);
  waystone::SaveMovies(argv[1]);
  return 0;
}
