// SPDX-License-Identifier: Apache-2.0
#include "core/image/heic.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <string>
#include <string_view>

#include "core/image/hevc_size.h"

namespace waystone {
namespace {

// More than the 64 x 64 tiles of 50 megapixels.
constexpr size_t kMaxItems = 20'000;

[[noreturn]] void RefuseDamage(const std::string& what) {
  RefuseImage("the HEIC " + what + "; it is damaged");
}

// Reads big-endian numbers front to back and never leaves the bytes.
class Cursor {
 public:
  Cursor(Bytes bytes, std::string_view box) : bytes_(bytes), box_(box) {}

  size_t left() const { return bytes_.size() - at_; }
  Bytes rest() const { return bytes_.subspan(at_); }
  Bytes Take(uint64_t size) {
    if (size > left()) RefuseDamage("has a box \"" + std::string(box_) + "\" that is too short");
    at_ += size;
    return bytes_.subspan(at_ - size, size);
  }
  uint64_t Number(int size) {
    uint64_t value = 0;
    for (const uint8_t byte : Take(size)) value = value << 8 | byte;
    return value;
  }
  std::string_view Name() {
    const Bytes name = Take(4);
    return {reinterpret_cast<const char*>(name.data()), name.size()};
  }

 private:
  Bytes bytes_;
  std::string_view box_;
  size_t at_ = 0;
};

struct Box {
  std::string_view name;
  Bytes data;
};

// Consecutive boxes. `file` is true at the top level of the file, where an incomplete box means
// that the end was cut off; within a box it is damage.
class Boxes {
 public:
  explicit Boxes(Bytes bytes, bool file = false) : bytes_(bytes), file_(file) {}

  std::optional<Box> Next() {
    if (at_ == bytes_.size()) return std::nullopt;
    Cursor cursor(bytes_.subspan(at_), "box");
    constexpr size_t kHead = 8;
    constexpr size_t kLongHead = 16;
    if (cursor.left() < kHead) RefuseEnd("box");
    uint64_t size = cursor.Number(4);
    Box box{.name = cursor.Name(), .data = {}};
    size_t head = kHead;
    if (size == 1) {
      if (cursor.left() < 8) RefuseEnd(box.name);
      size = cursor.Number(8);
      head = kLongHead;
    } else if (size == 0) {
      size = bytes_.size() - at_;
    }
    if (size > bytes_.size() - at_) RefuseEnd(box.name);
    if (size < head) RefuseDamage("has a box of " + std::to_string(size) + " bytes");
    box.data = bytes_.subspan(at_ + head, size - head);
    at_ += size;
    return box;
  }

 private:
  [[noreturn]] void RefuseEnd(std::string_view name) const {
    if (file_) RefuseCutOff("HEIC", bytes_, "the end of a box");
    RefuseDamage("has a box \"" + std::string(name) + "\" that is longer than what holds it");
  }

  Bytes bytes_;
  bool file_;
  size_t at_ = 0;
};

// The only box of this name: with two of them, readers could differ in their choice.
std::optional<Bytes> FindBox(Boxes boxes, std::string_view name) {
  std::optional<Bytes> found;
  while (const std::optional<Box> box = boxes.Next()) {
    if (box->name != name) continue;
    if (found) RefuseDamage("has two boxes \"" + std::string(name) + "\"");
    found = box->data;
  }
  return found;
}

Bytes NeedBox(Bytes boxes, std::string_view name) {
  const std::optional<Bytes> found = FindBox(Boxes(boxes), name);
  if (!found) RefuseDamage("has no box \"" + std::string(name) + "\"");
  return *found;
}

struct Extent {
  uint64_t source = 0;  // 0: the file, 1: the box "idat"
  uint64_t offset = 0;
  uint64_t length = 0;  // 0: up to the end
  bool whole = true;    // false: in several pieces, or elsewhere
};

struct Item {
  std::string_view type;
  std::optional<Extent> extent;
  std::optional<std::vector<size_t>> properties;  // indices, from 0
  std::optional<std::vector<uint32_t>> tiles;     // items
};

// The box "meta": which items there are, what each is and where its bytes lie.
class HeicFile {
 public:
  explicit HeicFile(Bytes bytes) : bytes_(bytes) {
    const std::optional<Bytes> found = FindBox(Boxes(bytes, true), "meta");
    if (!found) RefuseDamage("has no box \"meta\"");
    Cursor meta(*found, "meta");
    meta.Number(4);  // version and flags
    const Bytes boxes = meta.rest();
    idat_ = FindBox(Boxes(boxes), "idat").value_or(Bytes());
    ReadItems(NeedBox(boxes, "iinf"));
    ReadPrimary(NeedBox(boxes, "pitm"));
    ReadLocations(NeedBox(boxes, "iloc"));
    const Bytes properties = NeedBox(boxes, "iprp");
    ReadProperties(NeedBox(properties, "ipco"));
    ReadAssociations(NeedBox(properties, "ipma"));
    if (const auto references = FindBox(Boxes(boxes), "iref")) ReadReferences(*references);
  }

  const Item& Primary() const { return Get(primary_); }

  const Item& Get(uint32_t id) const {
    const auto found = items_.find(id);
    if (found == items_.end()) RefuseDamage("refers to item " + std::to_string(id));
    return found->second;
  }

  // The first item of this type.
  const Item* Find(std::string_view type) const {
    for (const auto& [id, item] : items_) {
      if (item.type == type) return &item;
    }
    return nullptr;
  }

  Bytes Data(const Item& item) const {
    if (!item.extent) RefuseDamage("doesn't say where its image data are");
    const Extent& extent = *item.extent;
    if (!extent.whole) {
      RefuseImage("the HEIC keeps its image in pieces, which is not supported; save it as JPEG");
    }
    const Bytes source = extent.source == 0 ? bytes_ : idat_;
    if (extent.offset > source.size() || extent.length > source.size() - extent.offset) {
      RefuseCutOff("HEIC", bytes_, "the end of its image data");
    }
    return extent.length == 0 ? source.subspan(extent.offset)
                              : source.subspan(extent.offset, extent.length);
  }

  // The item's property of this name; the first, and nothing without one.
  std::optional<Bytes> Property(const Item& item, std::string_view name) const {
    if (!item.properties) return std::nullopt;
    for (const size_t index : *item.properties) {
      if (index < properties_.size() && properties_[index].name == name) {
        return properties_[index].data;
      }
    }
    return std::nullopt;
  }

 private:
  // Item ids have two bytes before version `four_from` of the box, and four from it on.
  static int IdBytes(uint64_t version, uint64_t four_from) { return version < four_from ? 2 : 4; }

  static void CheckCount(uint64_t count, const std::string& what) {
    if (count <= kMaxItems) return;
    RefuseImage("the HEIC has " + std::to_string(count) + " " + what + ", more than the limit of " +
                std::to_string(kMaxItems) + "; save it as JPEG");
  }

  void ReadItems(Bytes data) {
    Cursor cursor(data, "iinf");
    const uint64_t version = cursor.Number(4) >> 24;
    const uint64_t count = cursor.Number(version == 0 ? 2 : 4);
    CheckCount(count, "items");
    Boxes boxes(cursor.rest());
    for (uint64_t i = 0; i < count; ++i) {
      const std::optional<Box> box = boxes.Next();
      if (!box || box->name != "infe") RefuseDamage("lists fewer items than it says");
      Cursor entry(box->data, "infe");
      const uint64_t entry_version = entry.Number(4) >> 24;
      if (entry_version < 2) RefuseDamage("has an item without a type");
      const auto id = static_cast<uint32_t>(entry.Number(IdBytes(entry_version, 3)));
      entry.Number(2);  // protection
      const auto [item, added] = items_.try_emplace(id);
      if (!added) RefuseTwice(id);
      item->second.type = entry.Name();
    }
  }

  void ReadPrimary(Bytes data) {
    Cursor cursor(data, "pitm");
    const uint64_t version = cursor.Number(4) >> 24;
    primary_ = static_cast<uint32_t>(cursor.Number(IdBytes(version, 1)));
  }

  void ReadLocations(Bytes data) {
    Cursor cursor(data, "iloc");
    const uint64_t version = cursor.Number(4) >> 24;
    const uint64_t sizes = cursor.Number(2);
    const int offset_size = sizes >> 12;
    const int length_size = sizes >> 8 & 15;
    const int base_size = sizes >> 4 & 15;
    const int index_size = version == 0 ? 0 : sizes & 15;
    if (std::max({offset_size, length_size, base_size, index_size}) > 8) {
      RefuseDamage("has a table of locations with numbers of more than 8 bytes");
    }
    const uint64_t count = cursor.Number(IdBytes(version, 2));
    CheckCount(count, "locations");
    for (uint64_t i = 0; i < count; ++i) {
      const auto id = static_cast<uint32_t>(cursor.Number(IdBytes(version, 2)));
      Extent extent;
      extent.source = version == 0 ? 0 : cursor.Number(2) & 15;
      const bool elsewhere = cursor.Number(2) != 0;
      const uint64_t base = cursor.Number(base_size);
      const uint64_t extents = cursor.Number(2);
      // Empty extents could be repeated without end.
      if (extents > 1 && index_size + offset_size + length_size == 0) {
        RefuseDamage("has image data in " + std::to_string(extents) +
                     " places without saying where");
      }
      extent.whole = extents == 1 && !elsewhere && extent.source <= 1;
      for (uint64_t each = 0; each < extents; ++each) {
        cursor.Number(index_size);
        const uint64_t offset = cursor.Number(offset_size);
        const bool beyond = offset > std::numeric_limits<uint64_t>::max() - base;
        extent.offset = beyond ? std::numeric_limits<uint64_t>::max() : base + offset;
        extent.length = cursor.Number(length_size);
      }
      const auto item = items_.find(id);
      if (item == items_.end()) continue;
      if (item->second.extent) RefuseTwice(id);
      item->second.extent = extent;
    }
  }

  void ReadProperties(Bytes data) {
    Boxes boxes(data);
    while (const std::optional<Box> box = boxes.Next()) {
      properties_.push_back(*box);
      CheckCount(properties_.size(), "properties");
    }
  }

  void ReadAssociations(Bytes data) {
    Cursor cursor(data, "ipma");
    const uint64_t full = cursor.Number(4);
    const int index_bytes = full % 2 == 0 ? 1 : 2;
    const uint64_t count = cursor.Number(4);
    CheckCount(count, "lists of properties");
    for (uint64_t i = 0; i < count; ++i) {
      const auto id = static_cast<uint32_t>(cursor.Number(IdBytes(full >> 24, 1)));
      std::vector<size_t> indices;
      for (uint64_t each = cursor.Number(1); each > 0; --each) {
        const uint64_t essential = index_bytes == 1 ? 0x80 : 0x8000;
        const uint64_t index = cursor.Number(index_bytes) & ~essential;
        if (index > 0) indices.push_back(index - 1);
      }
      const auto item = items_.find(id);
      if (item == items_.end()) continue;
      if (item->second.properties) RefuseTwice(id);
      item->second.properties = std::move(indices);
    }
  }

  void ReadReferences(Bytes data) {
    Cursor cursor(data, "iref");
    const uint64_t version = cursor.Number(4) >> 24;
    const int id_bytes = IdBytes(version, 1);
    Boxes boxes(cursor.rest());
    while (const std::optional<Box> box = boxes.Next()) {
      if (box->name != "dimg") continue;
      Cursor reference(box->data, "dimg");
      const auto id = static_cast<uint32_t>(reference.Number(id_bytes));
      const auto item = items_.find(id);
      if (item == items_.end()) continue;
      if (item->second.tiles) RefuseTwice(id);
      const uint64_t count = reference.Number(2);
      CheckCount(count, "tiles");
      std::vector<uint32_t> tiles;
      for (uint64_t i = 0; i < count; ++i) {
        tiles.push_back(static_cast<uint32_t>(reference.Number(id_bytes)));
      }
      item->second.tiles = std::move(tiles);
    }
  }

  [[noreturn]] static void RefuseTwice(uint32_t id) {
    RefuseDamage("describes item " + std::to_string(id) + " twice");
  }

  Bytes bytes_;
  Bytes idat_;
  std::map<uint32_t, Item> items_;
  std::vector<Box> properties_;
  uint32_t primary_ = 0;
};

// Refuses a file of boxes that isn't HEIC, naming its brands.
void CheckBrands(Bytes bytes) {
  Boxes boxes(bytes, true);
  const Box type = *boxes.Next();
  bool heic = false;
  bool avif = false;
  for (size_t at = 0; at + 4 <= type.data.size(); at += 4) {
    if (at == 4) continue;  // the minor version
    const std::string_view brand(reinterpret_cast<const char*>(&type.data[at]), 4);
    heic |= brand == "heic" || brand == "heix" || brand == "mif1";
    avif |= brand == "avif" || brand == "avis";
  }
  if (avif) RefuseImage("AVIF is not supported; save it as JPEG or HEIC");
  if (!heic) {
    RefuseImage("the " + std::to_string(bytes.size()) +
                " bytes are a video or an image that isn't HEIC; save a frame as JPEG");
  }
}

// Consecutive network units, each preceded by its length.
class Units {
 public:
  Units(Bytes bytes, int length_bytes) : cursor_(bytes, "mdat"), length_bytes_(length_bytes) {}

  std::optional<Bytes> Next() {
    if (cursor_.left() == 0) return std::nullopt;
    return cursor_.Take(cursor_.Number(length_bytes_));
  }

 private:
  Cursor cursor_;
  int length_bytes_;
};

// The parameter sets of a picture, from its property "hvcC": one of each kind, since a decoder
// prepares tables of the picture's size for each.
int TakeParameterSets(Bytes configuration, HevcPicture& picture, HevcSize& size) {
  constexpr size_t kFixed = 21;
  constexpr size_t kMost = 4096;  // cameras write 100; all tiles may share them
  if (configuration.size() > kMost) {
    RefuseDamage("has parameter sets of " + std::to_string(configuration.size()) + " bytes");
  }
  Cursor cursor(configuration, "hvcC");
  cursor.Take(kFixed);
  const int length_bytes = static_cast<int>(cursor.Number(1) & 3) + 1;
  std::array<int, 64> seen{};
  for (uint64_t arrays = cursor.Number(1); arrays > 0; --arrays) {
    cursor.Number(1);  // the units' own type counts
    for (uint64_t count = cursor.Number(2); count > 0; --count) {
      const Bytes unit = cursor.Take(cursor.Number(2));
      const int type = HevcUnitType(unit);
      if (type < kHevcVideoSet || type > kHevcPictureSet) continue;
      if (++seen.at(type) > 1) {
        RefuseImage("the HEIC has several parameter sets, which is not supported; save it as JPEG");
      }
      if (type == kHevcSequenceSet) size = ReadHevcSize(unit);
      picture.units.push_back(unit);
    }
  }
  if (seen[kHevcSequenceSet] == 0 || seen[kHevcPictureSet] == 0) {
    RefuseDamage("has no parameter sets");
  }
  return length_bytes;
}

// A picture's slices. HEVC has at most 600 of them; each costs a decoder kilobytes.
void TakeSlices(Bytes data, int length_bytes, HevcPicture& picture) {
  constexpr int kMaxSlices = 600;
  Units units(data, length_bytes);
  int slices = 0;
  while (const std::optional<Bytes> unit = units.Next()) {
    const int type = HevcUnitType(*unit);
    if (type < 0 || type > kHevcLastSlice) continue;
    const bool first = unit->size() > 2 && (*unit)[2] >> 7 != 0;
    if (type < kHevcFirstIntra || type > kHevcLastIntra || first != (slices == 0)) {
      RefuseImage("the HEIC's image is not a single intra picture; save it as JPEG");
    }
    if (++slices > kMaxSlices) {
      RefuseImage("the HEIC has a picture of more than " + std::to_string(kMaxSlices) +
                  " slices; save it as JPEG");
    }
    picture.units.push_back(*unit);
  }
  if (slices == 0) RefuseDamage("has no image data");
}

// Adds a picture to the image, whose pictures are all of one kind.
void AddTile(const HeicFile& file, const Item& item, HeicImage& image) {
  if (item.type != "hvc1") {
    RefuseImage("the HEIC's image is of type \"" + std::string(item.type) +
                "\", which is not supported; save it as JPEG");
  }
  const std::optional<Bytes> configuration = file.Property(item, "hvcC");
  if (!configuration) RefuseDamage("has no parameter sets");
  HevcPicture picture;
  HevcSize size;
  const int length_bytes = TakeParameterSets(*configuration, picture, size);
  TakeSlices(file.Data(item), length_bytes, picture);
  if (image.tiles.empty()) {
    image.tile_width = size.width;
    image.tile_height = size.height;
    image.chroma = size.chroma;
    image.bits = size.bits;
    image.coded_pixels = size.coded_pixels;
  } else if (size.width != image.tile_width || size.height != image.tile_height ||
             size.chroma != image.chroma || size.bits != image.bits ||
             size.coded_pixels != image.coded_pixels) {
    RefuseDamage("has tiles of different sizes");
  }
  image.tiles.push_back(std::move(picture));
}

void AddGrid(const HeicFile& file, const Item& grid, size_t file_bytes, HeicImage& image) {
  Cursor cursor(file.Data(grid), "grid");
  cursor.Number(1);  // version
  const int side_bytes = cursor.Number(1) % 2 == 0 ? 2 : 4;
  const size_t rows = cursor.Number(1) + 1;
  image.columns = static_cast<int>(cursor.Number(1)) + 1;
  constexpr uint64_t kMaxSide = std::numeric_limits<int>::max();
  image.width = static_cast<int>(std::min(cursor.Number(side_bytes), kMaxSide));
  image.height = static_cast<int>(std::min(cursor.Number(side_bytes), kMaxSide));
  if (!grid.tiles || grid.tiles->size() != rows * image.columns) {
    RefuseDamage("has fewer or more tiles than its grid");
  }
  // Tiles that share their bytes would cost more than the bytes do.
  size_t tile_bytes = 0;
  for (const uint32_t id : *grid.tiles) {
    tile_bytes += file.Data(file.Get(id)).size();
    if (tile_bytes > file_bytes) RefuseDamage("has tiles that share their data");
    AddTile(file, file.Get(id), image);
  }
  // No tile is of another size, nor lies beyond the image.
  const auto fits = [](int64_t size, int64_t tile, int64_t count) {
    return tile * count >= size && tile * (count - 1) < size;
  };
  constexpr int kMinTile = 64;  // px: smaller ones cost more than their pixels
  const bool small =
      image.tiles.size() > 1 && std::min(image.tile_width, image.tile_height) < kMinTile;
  if (small || !fits(image.width, image.tile_width, image.columns) ||
      !fits(image.height, image.tile_height, static_cast<int64_t>(rows))) {
    RefuseDamage("claims " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                 " pixels in " + std::to_string(image.columns) + "x" + std::to_string(rows) +
                 " tiles of " + std::to_string(image.tile_width) + "x" +
                 std::to_string(image.tile_height));
  }
}

std::optional<bool> FullRange(const HeicFile& file) {
  const std::optional<Bytes> colour = file.Property(file.Primary(), "colr");
  if (!colour) return std::nullopt;
  Cursor cursor(*colour, "colr");
  if (cursor.Name() != "nclx") return std::nullopt;
  cursor.Take(6);
  return cursor.Number(1) >> 7 != 0;
}

}  // namespace

HeicImage ReadHeic(Bytes bytes) {
  CheckBrands(bytes);
  const HeicFile file(bytes);
  HeicImage image;
  if (file.Primary().type == "grid") {
    AddGrid(file, file.Primary(), bytes.size(), image);
  } else {
    AddTile(file, file.Primary(), image);
    image.width = image.tile_width;
    image.height = image.tile_height;
  }
  image.full_range = FullRange(file);
  return image;
}

Bytes HeicExif(Bytes bytes) {
  CheckBrands(bytes);
  const HeicFile file(bytes);
  const Item* item = file.Find("Exif");
  if (item == nullptr) return {};
  Cursor cursor(file.Data(*item), "Exif");
  cursor.Take(cursor.Number(4));  // what stands before the TIFF
  return cursor.rest();
}

ImageHeader ReadHeicHeader(Bytes bytes) {
  const HeicImage image = ReadHeic(bytes);
  return {.format = "heic",
          .width = image.width,
          .height = image.height,
          .decode_bytes = image.DecodeBytes(),
          .hevc_bytes = image.HevcBytes()};
}

int64_t HeicImage::HevcBytes() const {
  int64_t bytes = 0;
  for (const HevcPicture& tile : tiles) {
    for (const Bytes unit : tile.units) bytes += std::ssize(unit);
  }
  return bytes;
}

int64_t HeicImage::DecodeBytes() const {
  // Samples of a picture, in quarters of its pixels: 4:0:0, 4:2:0, 4:2:2, 4:4:4.
  constexpr std::array<int64_t, 4> kQuarters{4, 6, 8, 12};
  const int64_t samples = coded_pixels * kQuarters.at(chroma) / 4 * (bits > 8 ? 2 : 1);
  constexpr int kPictures = 2;  // one before and one after deblocking
  return kPictures * samples + coded_pixels + int64_t{width} * height;
}

}  // namespace waystone
