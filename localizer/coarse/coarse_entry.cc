// SPDX-License-Identifier: Apache-2.0
#include "localizer/coarse/coarse_entry.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/features/descriptor_codes.h"
#include "schema/file/sha256.h"

namespace waystone {
namespace {

// The file, little-endian: the header, then one byte per place (its number of codes), then a
// two-byte word per code, then an eight-byte signature per code. Frozen.
constexpr std::string_view kMagic = "waystone coarse\n";
constexpr int kCoarseFormat = 1;
constexpr std::string_view kHashPrefix = "sha256:";
constexpr size_t kHashDigits = 64;
// Magic, hash, and five numbers of four bytes: format, feature type, working pixels, keyframes,
// places.
constexpr size_t kHeadBytes = kMagic.size() + kHashDigits + 5 * 4;
constexpr size_t kWordBytes = 2;
constexpr size_t kSignatureBytes = 8;
constexpr int kFeatureTypeCount = 3;
// How many of a place's codes may be planes' features where there are enough landmarks.
constexpr int kPlaneCodes = kMaxPlaceCodes / 2;

void AddNumber(std::string& bytes, uint64_t value, size_t size) {
  for (size_t i = 0; i < size; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xFF));
}

uint64_t NumberAt(std::string_view bytes, size_t at, size_t size) {
  uint64_t value = 0;
  for (size_t i = 0; i < size; ++i) {
    value |= static_cast<uint64_t>(static_cast<uint8_t>(bytes[at + i])) << (8 * i);
  }
  return value;
}

bool IsBefore(const WordCode& a, const WordCode& b) {
  return std::tie(a.word, a.signature) < std::tie(b.word, b.signature);
}

// Adds rows of descriptors as codes, at most one per word, in the given order.
void AddCodes(const Vocabulary& words, const Descriptors& rows, const std::vector<int>& order,
              int count, std::vector<WordCode>& codes) {
  for (const int row : order) {
    if (count <= 0) return;
    const WordCode code = words.Encode(rows.row(row));
    if (std::ranges::count(codes, code.word, &WordCode::word) > 0) continue;
    codes.push_back(code);
    --count;
  }
}

// The rows 0 to `count` - 1 in an order whose every prefix is spread over them: by their reversed
// bits.
std::vector<int> SpreadOrder(int count) {
  std::vector<int> order;
  order.reserve(count);
  int steps = 1;
  while (steps < count) steps *= 2;
  for (int i = 0; i < steps; ++i) {
    int reversed = 0;
    for (int bit = 1, back = steps / 2; back > 0; bit *= 2, back /= 2) {
      if ((i & bit) != 0) reversed += back;
    }
    if (reversed < count) order.push_back(reversed);
  }
  return order;
}

// A feature of a plane: rows of its descriptors.
struct DealtFeature {
  int plane = 0;
  int row = 0;
};

// Features of planes by the keyframe to which they are assigned, the most often seen ones first.
std::vector<std::vector<DealtFeature>> DealFeatures(const MapIndex& index) {
  const MapData& map = index.map();
  std::vector<std::vector<DealtFeature>> dealt(map.keyframes.size());
  for (int p = 0; p < static_cast<int>(map.planes.size()); ++p) {
    const Plane& plane = map.planes[p];
    std::vector<int> order(plane.features.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, std::ranges::greater{},
                             [&](int row) { return plane.features[row].votes; });
    for (size_t i = 0; i < order.size() && !plane.views.empty(); ++i) {
      const PlaneView& view = plane.views[i % plane.views.size()];
      dealt[index.IndexOf(view.keyframe)].push_back({p, order[i]});
    }
  }
  return dealt;
}

void AddPlace(std::vector<WordCode> codes, CoarseEntry& entry) {
  std::ranges::sort(codes, IsBefore);
  entry.codes_of.push_back(static_cast<uint8_t>(codes.size()));
  for (const WordCode& code : codes) {
    entry.words.push_back(code.word);
    entry.signatures.push_back(code.signature);
  }
}

void AddKeyframes(const MapIndex& index, const Vocabulary& words, CoarseEntry& entry) {
  const MapData& map = index.map();
  std::vector<Descriptors> of_planes;
  for (int p = 0; p < static_cast<int>(map.planes.size()); ++p) {
    of_planes.push_back(index.DescriptorsOf(p));
  }
  const std::vector<std::vector<DealtFeature>> dealt = DealFeatures(index);
  for (int k = 0; k < static_cast<int>(map.keyframes.size()); ++k) {
    // Alternates between the planes' best ones, since rows come plane by plane.
    Descriptors rows(DescriptorBytes(entry.feature_type));
    for (const DealtFeature& one : dealt[k]) rows.Append(of_planes[one.plane].row(one.row));
    const std::vector<int> spread = SpreadOrder(rows.rows());
    const Descriptors landmarks = index.LandmarkDescriptorsOf(k);
    std::vector<WordCode> codes;
    AddCodes(words, rows, spread, std::max(kPlaneCodes, kMaxPlaceCodes - landmarks.rows()), codes);
    AddCodes(words, landmarks, SpreadOrder(landmarks.rows()),
             kMaxPlaceCodes - static_cast<int>(codes.size()), codes);
    AddPlace(std::move(codes), entry);
    const Keyframe& keyframe = map.keyframes[k];
    const int64_t pixels = int64_t{keyframe.width} * keyframe.height;
    entry.working_pixels = static_cast<int>(
        std::clamp<int64_t>(pixels, entry.working_pixels, FeatureOptions{}.working_pixels));
  }
  entry.keyframes = entry.places();
}

void AddNodes(const MapIndex& index, const Vocabulary& words, CoarseEntry& entry) {
  for (const AppearanceNode& node : index.map().appearance->nodes) {
    const Descriptors rows = DecodeDescriptors(node.features.codes, entry.feature_type);
    std::vector<WordCode> codes;
    AddCodes(words, rows, SpreadOrder(rows.rows()), kMaxPlaceCodes, codes);
    AddPlace(std::move(codes), entry);
  }
}

[[noreturn]] void FailEntry(const std::string& where, const std::string& cause) {
  throw MapError(ErrorCode::kFileUnreadable, where + " is not an entry of the coarse index: " +
                                                 cause + "; publish the map again");
}

}  // namespace

CoarseEntry MakeCoarseEntry(const MapIndex& index) {
  const MapData& map = index.map();
  CoarseEntry entry;
  entry.map_version = map.info.version;
  entry.feature_type = map.info.feature_type;
  const Vocabulary& words = Vocabulary::Of(entry.feature_type);
  AddKeyframes(index, words, entry);
  if (map.appearance && !map.appearance->mirror) AddNodes(index, words, entry);
  return entry;
}

std::string EncodeCoarseEntry(const CoarseEntry& entry) {
  WS_CHECK(IsSha256(entry.map_version), "the entry is of no map file");
  std::string bytes(kMagic);
  bytes += entry.map_version.substr(kHashPrefix.size());
  for (const int number : {kCoarseFormat, static_cast<int>(entry.feature_type),
                           entry.working_pixels, entry.keyframes, entry.places()}) {
    AddNumber(bytes, static_cast<uint64_t>(number), 4);
  }
  for (const uint8_t count : entry.codes_of) bytes.push_back(static_cast<char>(count));
  for (const uint16_t word : entry.words) AddNumber(bytes, word, kWordBytes);
  for (const uint64_t signature : entry.signatures) AddNumber(bytes, signature, kSignatureBytes);
  return bytes;
}

CoarseEntry DecodeCoarseEntry(std::string_view bytes, const std::string& where) {
  if (bytes.size() < kHeadBytes || !bytes.starts_with(kMagic)) {
    FailEntry(where, "it doesn't begin as one");
  }
  const auto number = [&](size_t i) {
    return NumberAt(bytes, kMagic.size() + kHashDigits + 4 * i, 4);
  };
  CoarseEntry entry;
  entry.map_version =
      std::string(kHashPrefix) + std::string(bytes.substr(kMagic.size(), kHashDigits));
  if (!IsSha256(entry.map_version)) FailEntry(where, "it names no map file");
  if (number(0) != kCoarseFormat) {
    FailEntry(where, "its format is " + std::to_string(number(0)) + ", this program reads " +
                         std::to_string(kCoarseFormat));
  }
  if (number(1) >= kFeatureTypeCount) FailEntry(where, "its features are of no known type");
  entry.feature_type = static_cast<FeatureType>(number(1));
  const uint64_t places = number(4);
  if (number(2) > static_cast<uint64_t>(FeatureOptions{}.working_pixels)) {
    FailEntry(where, "its keyframes have " + std::to_string(number(2)) + " pixels");
  }
  entry.working_pixels = static_cast<int>(number(2));
  if (places > kMaxCoarsePlaces || number(3) > places || bytes.size() - kHeadBytes < places) {
    FailEntry(where, "it has " + std::to_string(places) + " places, " + std::to_string(number(3)) +
                         " keyframes and " + std::to_string(bytes.size()) + " bytes");
  }
  entry.keyframes = static_cast<int>(number(3));
  size_t codes = 0;
  for (size_t i = 0; i < places; ++i) {
    entry.codes_of.push_back(static_cast<uint8_t>(bytes[kHeadBytes + i]));
    if (entry.codes_of.back() > kMaxPlaceCodes) {
      FailEntry(where, "place " + std::to_string(i) + " has " +
                           std::to_string(entry.codes_of.back()) + " codes");
    }
    codes += entry.codes_of.back();
  }
  const size_t words = kHeadBytes + places;
  const size_t signatures = words + kWordBytes * codes;
  if (bytes.size() != signatures + kSignatureBytes * codes) {
    FailEntry(where, "its places have " + std::to_string(codes) + " codes, which don't fill its " +
                         std::to_string(bytes.size()) + " bytes");
  }
  entry.words.reserve(codes);
  entry.signatures.reserve(codes);
  for (size_t i = 0; i < codes; ++i) {
    entry.words.push_back(
        static_cast<uint16_t>(NumberAt(bytes, words + kWordBytes * i, kWordBytes)));
    entry.signatures.push_back(NumberAt(bytes, signatures + kSignatureBytes * i, kSignatureBytes));
  }
  return entry;
}

}  // namespace waystone
