// SPDX-License-Identifier: Apache-2.0
#include "core/image/decode.h"

#include <gtest/gtest.h>

#include <cstdio>  // before jpeglib.h, which needs it
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include <jpeglib.h>

#include "core/base/error.h"
#include "core/base/random.h"

namespace waystone {
namespace {

using Bytes = std::vector<uint8_t>;

// 31 x 17 pixels, so that rows need padding in a BMP; smooth, so that JPEG keeps it.
cv::Mat Colours() {
  cv::Mat image(17, 31, CV_8UC3);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      image.at<cv::Vec3b>(y, x) = cv::Vec3b(8 * x, 15 * y, 128);
    }
  }
  return image;
}

Bytes Encoded(const std::string& extension, const cv::Mat& image = Colours(),
              const std::vector<int>& flags = {}) {
  Bytes bytes;
  // Without a quality a WebP is lossless.
  const std::vector<int> lossy{cv::IMWRITE_WEBP_QUALITY, 95};
  EXPECT_TRUE(cv::imencode(extension, image, bytes, extension == ".webp" ? lossy : flags));
  return bytes;
}

Bytes AsBytes(std::string_view text) { return Bytes(text.begin(), text.end()); }

struct Refusal {
  ErrorCode code = ErrorCode::kInternal;
  std::string message = "nothing was thrown";
};

Refusal RefusalOf(const Bytes& bytes, const DecodeLimits& limits = {}) {
  try {
    DecodeGrey(bytes, limits);
  } catch (const MapError& error) {
    return {error.code(), error.what()};
  }
  return {};
}

void ExpectRefusal(const Bytes& bytes, ErrorCode code, const std::string& part,
                   const DecodeLimits& limits = {}) {
  const Refusal refusal = RefusalOf(bytes, limits);
  EXPECT_EQ(refusal.code, code);
  EXPECT_NE(refusal.message.find(part), std::string::npos) << refusal.message;
}

class EachFormat : public testing::TestWithParam<const char*> {};

TEST_P(EachFormat, HeaderTellsTheSize) {
  const ImageHeader header = ReadImageHeader(Encoded(GetParam()));
  EXPECT_EQ(header.width, 31);
  EXPECT_EQ(header.height, 17);
  EXPECT_EQ(header.scans, 1);
}

TEST_P(EachFormat, DecodesToGreyAndColour) {
  const Bytes bytes = Encoded(GetParam());
  const cv::Mat colour = DecodeColour(bytes);
  ASSERT_EQ(colour.type(), CV_8UC3);
  EXPECT_LT(cv::norm(colour, Colours(), cv::NORM_L1) / colour.total(), 12);
  const cv::Mat grey = DecodeGrey(bytes);
  ASSERT_EQ(grey.type(), CV_8UC1);
  EXPECT_EQ(grey.size(), cv::Size(31, 17));
  // Rec. 601 luma.
  const cv::Vec3b pixel = Colours().at<cv::Vec3b>(8, 15);
  EXPECT_NEAR(grey.at<uint8_t>(8, 15), 0.114 * pixel[0] + 0.587 * pixel[1] + 0.299 * pixel[2], 4);
}

TEST_P(EachFormat, EveryPrefixIsRefused) {
  const Bytes bytes = Encoded(GetParam());
  for (size_t length = 0; length < bytes.size(); ++length) {
    // A copy of its own, so that a sanitizer sees any read behind the end.
    const Bytes prefix(bytes.begin(), bytes.begin() + length);
    ASSERT_EQ(RefusalOf(prefix).code, ErrorCode::kBadImage) << length << " of " << bytes.size();
  }
}

TEST_P(EachFormat, BytesBehindTheEndAreAllowed) {
  Bytes bytes = Encoded(GetParam());
  bytes.insert(bytes.end(), 100, 0xFF);
  EXPECT_EQ(DecodeGrey(bytes).size(), cv::Size(31, 17));
}

// Any damage gives an image of the claimed size or a MapError: never a crash or another exception.
TEST_P(EachFormat, FlippedBytesNeverCrash) {
  const Bytes bytes = Encoded(GetParam());
  Random random(7);
  testing::internal::CaptureStderr();  // libjpeg and libpng comment on it
  for (int i = 0; i < 2000; ++i) {
    Bytes damaged = bytes;
    for (int flips = 1 + random.Below(4); flips > 0; --flips) {
      damaged[random.Below(static_cast<int>(bytes.size()))] ^= 1 << random.Below(8);
    }
    try {
      const cv::Mat image = DecodeGrey(damaged, {.max_pixels = 1'000'000, .max_scans = 10});
      EXPECT_EQ(image.type(), CV_8UC1);
    } catch (const MapError& error) {
      EXPECT_TRUE(error.code() == ErrorCode::kBadImage ||
                  error.code() == ErrorCode::kImageTooLarge);
    }
  }
  testing::internal::GetCapturedStderr();
}

INSTANTIATE_TEST_SUITE_P(Formats, EachFormat,
                         testing::Values(".jpg", ".png", ".webp", ".bmp", ".ppm"),
                         [](const auto& each) { return std::string(each.param + 1); });

TEST(DecodeTest, GreyFilesStayAsTheyAre) {
  cv::Mat grey;
  cv::extractChannel(Colours(), grey, 0);
  for (const char* extension : {".png", ".bmp", ".pgm"}) {
    EXPECT_EQ(cv::norm(DecodeGrey(Encoded(extension, grey)), grey, cv::NORM_INF), 0) << extension;
  }
}

TEST(DecodeTest, SixteenBitsBecomeEight) {
  const cv::Mat deep(5, 6, CV_16UC1, cv::Scalar(0x1234));
  for (const char* extension : {".png", ".pgm"}) {
    const cv::Mat grey = DecodeGrey(Encoded(extension, deep));
    ASSERT_EQ(grey.type(), CV_8UC1) << extension;
    EXPECT_EQ(grey.at<uint8_t>(2, 3), 0x12) << extension;
  }
}

TEST(DecodeTest, WhatIsNoImageIsNamed) {
  ExpectRefusal({}, ErrorCode::kBadImage, "empty (0 bytes)");
  ExpectRefusal(AsBytes("Dear robot, you are here.\n"), ErrorCode::kBadImage, "26 bytes are text");
  ExpectRefusal(AsBytes("GIF89a\x01\x02"), ErrorCode::kBadImage, "a GIF");
  ExpectRefusal(AsBytes("RIFF\1\2\3\4WAVE"), ErrorCode::kBadImage, "no known image format");
  ExpectRefusal(AsBytes("P2 1 1 255 7"), ErrorCode::kBadImage, "plain-text PNM");
}

TEST(DecodeTest, RandomBytesAreRefused) {
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    Bytes bytes(random.Below(200));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random.Below(256));
    EXPECT_EQ(RefusalOf(bytes).code, ErrorCode::kBadImage);
    // And behind each signature, where the parsers are.
    for (const std::string_view start : {"\xff\xd8\xff", "\x89PNG\r\n\x1a\n", "BM", "P5", "P6 9 9",
                                         "....ftypheic", "RIFF....WEBPVP8 "}) {
      Bytes armed = AsBytes(start);
      armed.insert(armed.end(), bytes.begin(), bytes.end());
      EXPECT_NE(RefusalOf(armed).code, ErrorCode::kInternal);
    }
  }
}

// Position of the SOF's height; what follows is the width.
size_t FrameSizeAt(const Bytes& jpeg) {
  for (size_t i = 0; i + 9 < jpeg.size(); ++i) {
    if (jpeg[i] == 0xFF && (jpeg[i + 1] == 0xC0 || jpeg[i + 1] == 0xC2)) return i + 5;
  }
  ADD_FAILURE() << "no frame header";
  return 0;
}

TEST(DecodeTest, HugeClaimsAreRefusedBeforeDecoding) {
  Bytes jpeg = Encoded(".jpg");
  const size_t at = FrameSizeAt(jpeg);
  jpeg[at] = jpeg[at + 2] = 0x75;  // 30000
  jpeg[at + 1] = jpeg[at + 3] = 0x30;
  ExpectRefusal(jpeg, ErrorCode::kImageTooLarge, "30000x30000 = 900000000 pixels");
  Bytes png = Encoded(".png");
  png[16] = png[20] = 0x7F;
  ExpectRefusal(png, ErrorCode::kImageTooLarge, "the limit of 50000000");
  Bytes bmp = Encoded(".bmp");
  bmp[21] = bmp[25] = 0x7F;
  ExpectRefusal(bmp, ErrorCode::kBadImage, "truncated");
  ExpectRefusal(AsBytes("P5 99999999999999 99999999 255 "), ErrorCode::kBadImage, "truncated");
}

TEST(DecodeTest, TheLimitIsInclusive) {
  const Bytes png = Encoded(".png");
  EXPECT_NO_THROW(DecodeGrey(png, {.max_pixels = 31 * 17}));
  ExpectRefusal(png, ErrorCode::kImageTooLarge, "31x17 = 527", {.max_pixels = 31 * 17 - 1});
}

TEST(DecodeTest, ZeroSizesAreDamage) {
  Bytes jpeg = Encoded(".jpg");
  jpeg[FrameSizeAt(jpeg)] = jpeg[FrameSizeAt(jpeg) + 1] = 0;
  ExpectRefusal(jpeg, ErrorCode::kBadImage, "31x0");
  ExpectRefusal(AsBytes("P5 0 0 255 "), ErrorCode::kBadImage, "0x0");
}

TEST(JpegTest, CountsTheScansOfAProgressiveOne) {
  const Bytes jpeg = Encoded(".jpg", Colours(), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  const int scans = ReadImageHeader(jpeg).scans;
  EXPECT_GT(scans, 4);
  EXPECT_NO_THROW(DecodeGrey(jpeg, {.max_scans = scans}));
  ExpectRefusal(jpeg, ErrorCode::kImageTooLarge, std::to_string(scans) + " scans",
                {.max_scans = scans - 1});
}

// Noise of four colours, as print shops have.
Bytes CmykJpeg(int side) {
  jpeg_compress_struct codec = {};
  jpeg_error_mgr messages = {};
  codec.err = jpeg_std_error(&messages);
  jpeg_create_compress(&codec);
  unsigned char* file = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): libjpeg's
  jpeg_mem_dest(&codec, &file, &size);
  codec.image_width = codec.image_height = side;
  codec.input_components = 4;
  codec.in_color_space = JCS_CMYK;
  jpeg_set_defaults(&codec);
  jpeg_start_compress(&codec, TRUE);
  cv::RNG random(3);
  cv::Mat row(1, side, CV_8UC4);
  while (codec.next_scanline < codec.image_height) {
    random.fill(row, cv::RNG::UNIFORM, 0, 256);
    JSAMPROW samples = row.data;
    jpeg_write_scanlines(&codec, &samples, 1);
  }
  jpeg_finish_compress(&codec);
  jpeg_destroy_compress(&codec);
  Bytes bytes(file, file + size);
  std::free(file);  // NOLINT: libjpeg's malloc
  return bytes;
}

TEST(JpegTest, OfFourColoursIsWholeOrRefused) {
  const Bytes jpeg = CmykJpeg(200);
  EXPECT_EQ(DecodeGrey(jpeg).size(), cv::Size(200, 200));
  EXPECT_EQ(DecodeColour(jpeg).size(), cv::Size(200, 200));
  Bytes half(jpeg.begin(), jpeg.begin() + std::ssize(jpeg) / 2);
  ExpectRefusal(half, ErrorCode::kBadImage, "truncated");
  half.insert(half.end(), {0xFF, 0xD9});  // with an end
  ExpectRefusal(half, ErrorCode::kBadImage, "ends too early");
}

// The last scan, again and again: still a JPEG to libjpeg, at the price of a pass each.
TEST(JpegTest, ManyScansAreRefused) {
  Bytes jpeg = Encoded(".jpg", Colours(), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  const Bytes pattern = {0xFF, 0xDA};
  const auto last = std::find_end(jpeg.begin(), jpeg.end(), pattern.begin(), pattern.end());
  const Bytes scan(last, jpeg.end() - 2);
  Bytes many(jpeg.begin(), last);
  for (int i = 0; i < 700; ++i) many.insert(many.end(), scan.begin(), scan.end());
  many.insert(many.end(), {0xFF, 0xD9});
  ExpectRefusal(many, ErrorCode::kImageTooLarge, "save it again as a baseline JPEG");
}

// A segment put behind the start marker.
Bytes WithSegment(Bytes jpeg, uint8_t marker, const Bytes& content) {
  const size_t length = content.size() + 2;
  Bytes segment = {0xFF, marker, static_cast<uint8_t>(length / 256),
                   static_cast<uint8_t>(length % 256)};
  segment.insert(segment.end(), content.begin(), content.end());
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}

TEST(JpegTest, AThumbnailInsideASegmentIsNotTheImage) {
  const Bytes thumbnail = Encoded(".jpg", cv::Mat(4, 5, CV_8UC1, cv::Scalar(9)));
  const Bytes jpeg = WithSegment(Encoded(".jpg"), 0xE1, thumbnail);
  EXPECT_EQ(ReadImageHeader(jpeg).width, 31);
  EXPECT_EQ(DecodeGrey(jpeg).size(), cv::Size(31, 17));
  // Its end marker doesn't stand in for the image's.
  ExpectRefusal(Bytes(jpeg.begin(), jpeg.end() - 2), ErrorCode::kBadImage, "truncated");
}

TEST(JpegTest, ExifOrientationIsNotApplied) {
  const std::string_view exif(
      "Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0", 32);
  const Bytes jpeg = WithSegment(Encoded(".jpg"), 0xE1, AsBytes(exif));
  EXPECT_EQ(DecodeGrey(jpeg).size(), cv::Size(31, 17));
  EXPECT_EQ(cv::imdecode(jpeg, cv::IMREAD_GRAYSCALE).size(), cv::Size(17, 31));  // is a test at all
}

TEST(JpegTest, RestartMarkersAndFillBytesAreSteppedOver) {
  const cv::Mat larger(200, 300, CV_8UC1, cv::Scalar(50));
  Bytes jpeg = Encoded(".jpg", larger, {cv::IMWRITE_JPEG_RST_INTERVAL, 2});
  jpeg.insert(jpeg.end() - 2, 3, 0xFF);
  jpeg.insert(jpeg.begin() + 2, 5, 0xFF);
  EXPECT_EQ(ReadImageHeader(jpeg).scans, 1);
  EXPECT_EQ(DecodeGrey(jpeg).size(), cv::Size(300, 200));
}

cv::Mat NoisyColours(int width, int height) {
  cv::Mat noise(height, width, CV_8UC3);
  cv::setRNGSeed(5);
  cv::randu(noise, 0, 255);
  return noise;
}

// Maps of the same images have the same bytes, whoever calls libjpeg.
TEST(JpegTest, PixelsAreThoseThatOpenCvGives) {
  cv::Mat grey;
  cv::extractChannel(NoisyColours(77, 50), grey, 1);
  for (const Bytes& jpeg :
       {Encoded(".jpg", NoisyColours(77, 50)),
        Encoded(".jpg", NoisyColours(64, 33), {cv::IMWRITE_JPEG_QUALITY, 30}),
        Encoded(".jpg", NoisyColours(301, 200), {cv::IMWRITE_JPEG_PROGRESSIVE, 1}),
        Encoded(".jpg", NoisyColours(301, 200), {cv::IMWRITE_JPEG_RST_INTERVAL, 3}),
        Encoded(".jpg", grey)}) {
    const cv::Mat colour_by_opencv = cv::imdecode(jpeg, cv::IMREAD_COLOR);
    const cv::Mat grey_by_opencv = cv::imdecode(jpeg, cv::IMREAD_GRAYSCALE);
    EXPECT_EQ(cv::norm(DecodeColour(jpeg), colour_by_opencv, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(DecodeGrey(jpeg), grey_by_opencv, cv::NORM_INF), 0);
  }
}

TEST(JpegTest, DataThatEndsEarlyIsDamage) {
  testing::internal::CaptureStderr();
  for (const int progressive : {0, 1}) {
    const Bytes jpeg =
        Encoded(".jpg", NoisyColours(200, 160), {cv::IMWRITE_JPEG_PROGRESSIVE, progressive});
    Bytes cut(jpeg.begin(), jpeg.end() - static_cast<std::ptrdiff_t>(jpeg.size() / 3));
    cut.insert(cut.end(), {0, 0xFF, 0xD9});
    ExpectRefusal(cut, ErrorCode::kBadImage, "its image data ends too early; copy or send");
    Bytes larger = jpeg;
    larger[FrameSizeAt(larger)] += 1;  // by 256 rows
    ExpectRefusal(larger, ErrorCode::kBadImage, "its image data ends too early; copy or send");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "a log may be there";
}

TEST(JpegTest, SegmentsThatCouldHideScansAreRefused) {
  ExpectRefusal(WithSegment(Encoded(".jpg"), 0x02, {0, 0}), ErrorCode::kBadImage,
                "unknown segment 2");
  ExpectRefusal(WithSegment(Encoded(".jpg"), 0xF3, {0, 0}), ErrorCode::kBadImage,
                "unknown segment 243");
  Bytes two = Encoded(".jpg");
  two.insert(two.begin() + 2, {0xFF, 0xD8});
  ExpectRefusal(two, ErrorCode::kBadImage, "second start marker");
  ExpectRefusal(WithSegment(Encoded(".jpg"), 0xC3, {8, 0, 9, 0, 9, 1}), ErrorCode::kBadImage,
                "SOF3");
  ExpectRefusal(WithSegment(Encoded(".jpg"), 0xC0, {8, 0, 9, 0, 9, 1}), ErrorCode::kBadImage,
                "two frame headers");
}

TEST(PngTest, NeedsItsHeaderAndItsData) {
  const Bytes png = Encoded(".png");
  Bytes headless = png;
  headless[12] = 'J';
  ExpectRefusal(headless, ErrorCode::kBadImage, "header chunk");
  Bytes empty(png.begin(), png.begin() + 33);  // signature and IHDR
  empty.insert(empty.end(), png.end() - 12, png.end());
  ExpectRefusal(empty, ErrorCode::kBadImage, "no image data");
}

TEST(PngTest, DamageIsSaidByTheRefusalAlone) {
  Bytes png = Encoded(".png");
  png[png.size() - 12 - 10] ^= 1;  // in the data, before IEND
  testing::internal::CaptureStderr();
  ExpectRefusal(png, ErrorCode::kBadImage, "the checksum of its chunk IDAT is wrong");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(BmpTest, TopDownAndCompressedOnes) {
  Bytes bmp = Encoded(".bmp");
  for (int i = 22; i < 26; ++i) bmp[i] = i == 22 ? 256 - 17 : 0xFF;  // height -17
  EXPECT_EQ(ReadImageHeader(bmp).height, 17);
  bmp[30] = 1;
  ExpectRefusal(bmp, ErrorCode::kBadImage, "compressed");
}

TEST(PnmTest, CommentsInTheHeader) {
  const Bytes pgm = AsBytes("P5 # made by hand\n2 # wide\n1\n255\nab");
  EXPECT_EQ(ReadImageHeader(pgm).width, 2);
  EXPECT_EQ(DecodeGrey(pgm).at<uint8_t>(0, 1), 'b');
  ExpectRefusal(AsBytes("P5 2 1 70000 abcd"), ErrorCode::kBadImage, "70000");
  ExpectRefusal(AsBytes("P5 two 1 255 ab"), ErrorCode::kBadImage, "number is missing");
}

TEST(PnmTest, ACommentEndsAtACarriageReturn) {
  const Bytes pgm = AsBytes("P5 #\r2 1 #9 9\r255 ab");
  EXPECT_EQ(ReadImageHeader(pgm).width, 2);
  EXPECT_EQ(DecodeGrey(pgm).at<uint8_t>(0, 1), 'b');
}

Bytes Pnm(const std::string& header, std::initializer_list<int> samples, int sample_bytes) {
  Bytes bytes = AsBytes(header);
  for (const int sample : samples) {
    if (sample_bytes == 2) bytes.push_back(sample >> 8);
    bytes.push_back(sample & 0xFF);
  }
  return bytes;
}

// Industrial cameras write 10 and 12 bits.
TEST(PnmTest, TheMaximumIsWhite) {
  const Bytes grey = Pnm("P5 4 1 4095\n", {0, 2048, 4095, 5000}, 2);
  EXPECT_EQ(
      cv::norm(DecodeGrey(grey), cv::Mat(cv::Matx<uint8_t, 1, 4>(0, 128, 255, 255)), cv::NORM_INF),
      0);
  EXPECT_EQ(DecodeColour(grey).at<cv::Vec3b>(0, 1), cv::Vec3b(128, 128, 128));
  const Bytes colour = Pnm("P6 # ten bits\n1 1 1023\n", {1023, 512, 0}, 2);
  EXPECT_EQ(DecodeColour(colour).at<cv::Vec3b>(0, 0), cv::Vec3b(0, 128, 255));
  EXPECT_EQ(DecodeGrey(colour).at<uint8_t>(0, 0), 151);  // 0.299 * 255 + 0.587 * 128
  EXPECT_EQ(DecodeGrey(Pnm("P5 2 1 100\n", {100, 50}, 1)).at<uint8_t>(0, 1), 128);
  EXPECT_EQ(DecodeGrey(Pnm("P5 2 1 1\n", {0, 1}, 1)).at<uint8_t>(0, 1), 255);
}

TEST(PnmTest, AFullRangeStaysAsItIs) {
  EXPECT_EQ(DecodeGrey(Pnm("P5 1 1 65535\n", {0x12FF}, 2)).at<uint8_t>(0, 0), 0x12);
  EXPECT_EQ(DecodeGrey(Pnm("P5 1 1 255\n", {77}, 1)).at<uint8_t>(0, 0), 77);
}

// OpenCV would take the size behind the '#', which the limits haven't seen.
TEST(PnmTest, ANumberNeedsWhiteSpaceBehindIt) {
  ExpectRefusal(AsBytes("P5 2#9000 \n1 255 ab"), ErrorCode::kBadImage, "white space");
  ExpectRefusal(AsBytes("P52 1 32 ab"), ErrorCode::kBadImage, "white space");
  ExpectRefusal(AsBytes("P5 2 1 255#\nab"), ErrorCode::kBadImage, "white space");
}

// Limits hold only if the header's size is that of the image which OpenCV would make.
TEST(PnmTest, HeaderAndDecoderAgreeOnAnyHeader) {
  constexpr std::string_view kBytes = "0123 \n\r#\t2x";
  Random random(11);
  int decoded = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string text = "P5";
    for (int length = random.Below(12); length > 0; --length) {
      text += kBytes[random.Below(static_cast<int>(kBytes.size()))];
    }
    text += (random.Below(2) != 0 ? " 2 3 255\n" : " 255\n") + std::string(200, 'a');
    Bytes bytes = AsBytes(text);
    try {
      const ImageHeader header = ReadImageHeader(bytes);
      const cv::Mat image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
      if (image.empty()) continue;
      ++decoded;
      ASSERT_EQ(image.size(), cv::Size(header.width, header.height)) << text;
    } catch (const MapError&) {
      continue;
    } catch (const cv::Exception&) {
      continue;
    }
  }
  EXPECT_GT(decoded, 1000);
}

TEST(DecodeLimitsTest, RefusesWhatIsOutOfRange) {
  EXPECT_NO_THROW(DecodeLimits{}.Check());
  for (const DecodeLimits& limits :
       {DecodeLimits{.max_pixels = 0}, DecodeLimits{.max_pixels = int64_t{1} << 40},
        DecodeLimits{.max_scans = 0}, DecodeLimits{.max_scans = 1 << 20}}) {
    try {
      limits.Check();
      ADD_FAILURE() << limits.max_pixels << " " << limits.max_scans;
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
    }
  }
}

}  // namespace
}  // namespace waystone
