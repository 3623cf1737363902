// SPDX-License-Identifier: Apache-2.0
#include "tests/core/image/made_heic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace waystone {
namespace {

using HeicBytes = std::vector<uint8_t>;

constexpr int kBlock = 16;  // px, coding tree and coding blocks alike

class BitWriter {
 public:
  void Bits(uint32_t value, int count) {
    for (int i = count - 1; i >= 0; --i) {
      if (used_ == 0) bytes_.push_back(0);
      bytes_.back() |= (value >> i & 1) << (7 - used_);
      used_ = (used_ + 1) % 8;
    }
  }
  void Golomb(uint32_t value) {
    int length = 0;
    while ((value + 1) >> (length + 1) != 0) ++length;
    Bits(0, length);
    Bits(value + 1, length + 1);
  }
  void Align() {
    if (used_ != 0) Bits(0, 8 - used_);
  }
  // A one and zeros.
  void Trail() {
    Bits(1, 1);
    Align();
  }
  const HeicBytes& bytes() const { return bytes_; }

 private:
  HeicBytes bytes_;
  int used_ = 0;  // bits of the last byte
};

// Arithmetic coding, 9.3 of H.265: one context and the bins that end things.
class Cabac {
 public:
  explicit Cabac(BitWriter& bits) : bits_(bits) {}

  // part_mode's only bin, always 1, under its context's first state (value 184) as blocks are
  // coded again and again.
  void PartMode() {
    // Table 9-46's row of the states that are met: the least probable symbol never comes.
    const uint32_t less = kRangeLess[state_][range_ >> 6 & 3];
    range_ -= less;
    state_ = std::min(state_ + 1, 62);
    Renormalise();
  }
  void Terminate(bool ends) {
    range_ -= 2;
    if (ends) {
      low_ += range_;
      range_ = 2;
      Renormalise();
      Put(low_ >> 9 & 1);
      bits_.Bits((low_ >> 7 & 3) | 1, 2);  // with a slice's stop bit
      low_ = 0;
      range_ = 510;
      first_ = true;
      outstanding_ = 0;
    } else {
      Renormalise();
    }
  }

 private:
  void Renormalise() {
    while (range_ < 256) {
      if (low_ < 256) {
        Put(0);
      } else if (low_ >= 512) {
        low_ -= 512;
        Put(1);
      } else {
        low_ -= 256;
        ++outstanding_;
      }
      range_ <<= 1;
      low_ <<= 1;
    }
  }
  void Put(uint32_t bit) {
    if (first_) {
      first_ = false;
    } else {
      bits_.Bits(bit, 1);
    }
    for (; outstanding_ > 0; --outstanding_) bits_.Bits(1 - bit, 1);
  }

  // Of table 9-46, for pStateIdx 0 to 62.
  static constexpr std::array<std::array<uint8_t, 4>, 63> kRangeLess{{
      {128, 176, 208, 240}, {128, 167, 197, 227}, {128, 158, 187, 216}, {123, 150, 178, 205},
      {116, 142, 169, 195}, {111, 135, 160, 185}, {105, 128, 152, 175}, {100, 122, 144, 166},
      {95, 116, 137, 158},  {90, 110, 130, 150},  {85, 104, 123, 142},  {81, 99, 117, 135},
      {77, 94, 111, 128},   {73, 89, 105, 122},   {69, 85, 100, 116},   {66, 80, 95, 110},
      {62, 76, 90, 104},    {59, 72, 86, 99},     {56, 69, 81, 94},     {53, 65, 77, 89},
      {51, 62, 73, 85},     {48, 59, 69, 80},     {46, 56, 66, 76},     {43, 53, 63, 72},
      {41, 50, 59, 69},     {39, 48, 56, 65},     {37, 45, 54, 62},     {35, 43, 51, 59},
      {33, 41, 48, 56},     {32, 39, 46, 53},     {30, 37, 43, 50},     {29, 35, 41, 48},
      {27, 33, 39, 45},     {26, 31, 37, 43},     {24, 30, 35, 41},     {23, 28, 33, 39},
      {22, 27, 32, 37},     {21, 26, 30, 35},     {20, 24, 29, 33},     {19, 23, 27, 31},
      {18, 22, 26, 30},     {17, 21, 25, 28},     {16, 20, 23, 27},     {15, 19, 22, 25},
      {14, 18, 21, 24},     {14, 17, 20, 23},     {13, 16, 19, 22},     {12, 15, 18, 21},
      {12, 14, 17, 20},     {11, 14, 16, 19},     {11, 13, 15, 18},     {10, 12, 15, 17},
      {10, 12, 14, 16},     {9, 11, 13, 15},      {9, 11, 12, 14},      {8, 10, 12, 14},
      {8, 9, 11, 13},       {7, 9, 11, 12},       {7, 9, 10, 12},       {7, 8, 10, 11},
      {6, 8, 9, 11},        {6, 7, 9, 10},        {6, 7, 8, 9},
  }};

  BitWriter& bits_;
  uint32_t low_ = 0;
  uint32_t range_ = 510;
  bool first_ = true;
  int outstanding_ = 0;
  int state_ = InitialState();

  // 9.3.2.2 with initValue 184 and SliceQpY 26.
  static int InitialState() {
    constexpr int kSlope = (184 >> 4) * 5 - 45;
    constexpr int kOffset = ((184 & 15) << 3) - 16;
    const int state = std::clamp((kSlope * 26 >> 4) + kOffset, 1, 126);
    EXPECT_GT(state, 63) << "the most probable symbol is a one";
    return state - 64;
  }
};

// A unit: its head, and its bytes with a 3 wherever they could look like a start code.
HeicBytes Unit(int type, const BitWriter& bits) {
  HeicBytes unit{static_cast<uint8_t>(type << 1), 1};
  int zeros = 0;
  for (const uint8_t byte : bits.bytes()) {
    if (zeros >= 2 && byte <= 3) {
      unit.push_back(3);
      zeros = 0;
    }
    zeros = byte == 0 ? zeros + 1 : 0;
    unit.push_back(byte);
  }
  return unit;
}

void PutProfile(BitWriter& bits) {
  bits.Bits(4, 8);            // format range extensions
  bits.Bits(0x08000000, 32);  // compatible with them
  bits.Bits(0, 24);
  bits.Bits(0, 24);
  bits.Bits(186, 8);  // level 6.2
}

HeicBytes VideoSet() {
  BitWriter bits;
  bits.Bits(0, 4);
  bits.Bits(3, 2);
  bits.Bits(0, 6 + 3);
  bits.Bits(1, 1);
  bits.Bits(0xFFFF, 16);
  PutProfile(bits);
  bits.Bits(0, 1);
  for (const int each : {0, 0, 0}) bits.Golomb(each);
  bits.Bits(0, 6);
  bits.Golomb(0);
  bits.Bits(0, 2);
  bits.Trail();
  return Unit(32, bits);
}

HeicBytes SequenceSet(int width, int height, const MadeHeic& made) {
  BitWriter bits;
  bits.Bits(0, 4 + 3);
  bits.Bits(1, 1);
  PutProfile(bits);
  bits.Golomb(0);
  bits.Golomb(made.chroma ? 1 : 0);
  bits.Golomb(made.claimed_width > 0 ? made.claimed_width : width);
  bits.Golomb(made.claimed_height > 0 ? made.claimed_height : height);
  bits.Bits(made.cut > 0 ? 1 : 0, 1);
  if (made.cut > 0) {
    for (const int each : {0, made.chroma ? made.cut / 2 : made.cut, 0, 0}) bits.Golomb(each);
  }
  bits.Golomb(made.bits - 8);
  bits.Golomb(made.bits - 8);
  bits.Golomb(4);  // bits of the picture's number
  bits.Bits(0, 1);
  for (const int each : {0, 0, 0}) bits.Golomb(each);
  bits.Golomb(1);  // coding blocks of 16
  bits.Golomb(0);  // and so are the coding tree's
  bits.Golomb(0);
  bits.Golomb(2);
  for (const int each : {0, 0}) bits.Golomb(each);
  bits.Bits(0, 3);  // no scaling lists, asymmetric parts, sample offsets
  bits.Bits(1, 1);  // stored samples
  bits.Bits(made.bits - 1, 4);
  bits.Bits(made.bits - 1, 4);
  bits.Golomb(1);  // of 16
  bits.Golomb(0);
  bits.Bits(1, 1);  // not to be deblocked
  bits.Golomb(0);
  bits.Bits(0, 1 + 1 + 1);
  bits.Bits(1, 1);  // usability information
  bits.Bits(0, 1 + 1);
  bits.Bits(1, 1);  // about the signal
  bits.Bits(5, 3);
  bits.Bits(made.full_range ? 1 : 0, 1);
  bits.Bits(0, 1);
  bits.Bits(0, 1 + 3 + 1 + 1 + 1);
  bits.Bits(0, 1);
  bits.Trail();
  return Unit(33, bits);
}

HeicBytes PictureSet() {
  BitWriter bits;
  bits.Golomb(0);
  bits.Golomb(0);
  bits.Bits(0, 2 + 3 + 2);
  bits.Golomb(0);
  bits.Golomb(0);
  bits.Golomb(0);  // quantisation 26
  bits.Bits(0, 3);
  bits.Golomb(0);
  bits.Golomb(0);
  bits.Bits(0, 6);
  bits.Bits(0, 1);  // no filter across slices
  bits.Bits(0, 1 + 1 + 1);
  bits.Golomb(0);
  bits.Bits(0, 2);
  bits.Trail();
  return Unit(34, bits);
}

void PutSamples(BitWriter& bits, const cv::Mat& grey, cv::Point at, const MadeHeic& made) {
  for (int y = 0; y < kBlock; ++y) {
    for (int x = 0; x < kBlock; ++x) {
      bits.Bits(grey.at<uint8_t>(at.y + y, at.x + x) << (made.bits - 8), made.bits);
    }
  }
  for (int i = 0; made.chroma && i < kBlock * kBlock / 2; ++i) {
    bits.Bits(128 << (made.bits - 8), made.bits);
  }
}

HeicBytes Slice(const cv::Mat& grey, const MadeHeic& made) {
  BitWriter bits;
  bits.Bits(1, 1);
  bits.Bits(0, 1);
  bits.Golomb(0);
  bits.Golomb(2);  // intra
  bits.Golomb(0);  // quantisation as the picture's
  bits.Trail();
  Cabac coder(bits);
  for (int y = 0; y < grey.rows; y += kBlock) {
    for (int x = 0; x < grey.cols; x += kBlock) {
      coder.PartMode();
      coder.Terminate(true);  // stored samples follow
      bits.Align();
      PutSamples(bits, grey, {x, y}, made);
      coder.Terminate(x + kBlock == grey.cols && y + kBlock == grey.rows);
    }
  }
  bits.Align();
  return Unit(19, bits);
}

void PutHeicNumber(HeicBytes& to, uint64_t value, int size) {
  for (int i = size - 1; i >= 0; --i) to.push_back(static_cast<uint8_t>(value >> 8 * i));
}

void AppendHeic(HeicBytes& to, const HeicBytes& bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

HeicBytes HeicText(std::string_view text) { return {text.begin(), text.end()}; }

HeicBytes JoinedHeic(const std::vector<HeicBytes>& parts) {
  HeicBytes all;
  for (const HeicBytes& part : parts) AppendHeic(all, part);
  return all;
}

HeicBytes HeicNumbers(const std::vector<std::pair<uint64_t, int>>& numbers) {
  HeicBytes all;
  for (const auto& [value, size] : numbers) PutHeicNumber(all, value, size);
  return all;
}

HeicBytes HeicBox(std::string_view name, const std::vector<HeicBytes>& parts) {
  const HeicBytes data = JoinedHeic(parts);
  return JoinedHeic({HeicNumbers({{data.size() + 8, 4}}), HeicText(name), data});
}

HeicBytes Configuration(const std::vector<HeicBytes>& sets) {
  HeicBytes data(21);
  data[0] = 1;
  PutHeicNumber(data, 3, 1);  // lengths of four bytes
  PutHeicNumber(data, sets.size(), 1);
  for (const HeicBytes& set : sets) {
    PutHeicNumber(data, set[0] >> 1, 1);
    PutHeicNumber(data, 1, 2);
    PutHeicNumber(data, set.size(), 2);
    AppendHeic(data, set);
  }
  return HeicBox("hvcC", {data});
}

struct ItemOf {
  std::string_view type;
  HeicBytes data;
  std::vector<uint8_t> properties;  // from 1
};

// The items' box "meta", with their data behind `data_at`.
HeicBytes Meta(const std::vector<ItemOf>& items, const std::vector<HeicBytes>& properties,
               int primary, bool grid, size_t data_at) {
  HeicBytes infos;
  HeicBytes locations;
  HeicBytes associations;
  size_t at = data_at;
  for (size_t i = 0; i < items.size(); ++i) {
    AppendHeic(infos, HeicBox("infe", {HeicNumbers({{2 << 24, 4}, {i + 1, 2}, {0, 2}}),
                                       HeicText(items[i].type), HeicBytes(1)}));
    AppendHeic(locations,
               HeicNumbers({{i + 1, 2}, {0, 2}, {1, 2}, {at, 4}, {items[i].data.size(), 4}}));
    AppendHeic(associations, HeicNumbers({{i + 1, 2}, {items[i].properties.size(), 1}}));
    AppendHeic(associations, items[i].properties);
    at += items[i].data.size();
  }
  HeicBytes references;
  if (grid) {
    HeicBytes tiles = HeicNumbers({{primary, 2}, {primary - 1, 2}});
    for (int i = 1; i < primary; ++i) PutHeicNumber(tiles, i, 2);
    references = HeicBox("iref", {HeicBytes(4), HeicBox("dimg", {tiles})});
  }
  return HeicBox(
      "meta",
      {HeicBytes(4), HeicBox("hdlr", {HeicBytes(8), HeicText("pict"), HeicBytes(13)}),
       HeicBox("pitm", {HeicNumbers({{0, 4}, {primary, 2}})}),
       HeicBox("iinf", {HeicNumbers({{0, 4}, {items.size(), 2}}), infos}), references,
       HeicBox("iprp", {HeicBox("ipco", properties),
                        HeicBox("ipma", {HeicNumbers({{0, 4}, {items.size(), 4}}), associations})}),
       HeicBox("iloc", {HeicNumbers({{0, 4}, {0x4400, 2}, {items.size(), 2}}), locations})});
}

}  // namespace

std::vector<uint8_t> MakeHeic(const cv::Mat& grey, const MadeHeic& made) {
  const int width = grey.cols / made.columns;
  const int height = grey.rows / made.rows;
  EXPECT_EQ(width % kBlock + height % kBlock, 0);
  const std::vector<HeicBytes> properties{
      Configuration({VideoSet(), SequenceSet(width, height, made), PictureSet()}),
      HeicBox("ispe", {HeicNumbers({{0, 4}, {grey.cols, 4}, {grey.rows, 4}})}),
      HeicBox("irot", {HeicNumbers({{1, 1}})}), HeicBox("imir", {HeicNumbers({{0, 1}})})};
  const std::vector<uint8_t> shown =
      made.turned ? std::vector<uint8_t>{2, 3, 4} : std::vector<uint8_t>{2};
  const bool grid = made.columns * made.rows > 1;
  std::vector<ItemOf> items;
  for (int i = 0; i < made.columns * made.rows; ++i) {
    const cv::Rect part(i % made.columns * width, i / made.columns * height, width, height);
    const HeicBytes slice = Slice(grey(part), made);
    items.push_back({"hvc1", JoinedHeic({HeicNumbers({{slice.size(), 4}}), slice}), {1}});
  }
  if (grid) {
    items.push_back(
        {"grid",
         HeicNumbers(
             {{0, 2}, {made.rows - 1, 1}, {made.columns - 1, 1}, {grey.cols, 2}, {grey.rows, 2}}),
         {}});
  }
  const int primary = static_cast<int>(items.size());
  HeicBytes& of_primary = items.back().properties;
  of_primary.insert(of_primary.end(), shown.begin(), shown.end());
  if (!made.exif.empty()) {
    items.push_back({"Exif", JoinedHeic({HeicNumbers({{0, 4}}), made.exif}), {}});
  }
  const HeicBytes brands = HeicBox("ftyp", {HeicText("heic"), HeicBytes(4), HeicText("mif1heic")});
  const size_t meta_bytes = Meta(items, properties, primary, grid, 0).size();
  HeicBytes data;
  for (const ItemOf& item : items) AppendHeic(data, item.data);
  return JoinedHeic({brands, Meta(items, properties, primary, grid, brands.size() + meta_bytes + 8),
                     HeicBox("mdat", {data})});
}

}  // namespace waystone
