// SPDX-License-Identifier: Apache-2.0
#include "cli/files/query_set.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <sstream>
#include <string>
#include <unordered_map>

#include "cli/files/csv_file.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/image/extensions.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// An image of the map.
struct MappedImage {
  PlaceId place;
  SequenceId sequence;
  int frame = 0;
  std::string source;
  std::optional<double> time_s;
};

std::vector<MappedImage> ImagesOf(const MapData& map) {
  std::vector<MappedImage> images;
  for (const Keyframe& k : map.keyframes) {
    images.push_back({PlaceIdOf(k.id), k.sequence, k.frame, k.source, k.time_s});
  }
  if (!map.appearance) return images;
  for (const AppearanceNode& n : map.appearance->nodes) {
    images.push_back({PlaceIdOf(n.id), n.sequence, n.frame, n.source, n.time_s});
  }
  return images;
}

// Inclusive.
struct FrameNumbers {
  int64_t first = 0;
  int64_t last = std::numeric_limits<int64_t>::max();
};

// The images of the map by the names that people use.
class ImageNames {
 public:
  explicit ImageNames(const MapIndex& index) : index_(index), images_(ImagesOf(index.map())) {
    for (const MappedImage& image : images_) {
      const std::string& sequence = index.FindSequence(image.sequence)->name;
      by_name_[image.source].push_back(image.place);
      by_name_[sequence + ":" + image.source].push_back(image.place);
    }
  }

  // By source, or by "sequence:source".
  const std::vector<PlaceId>& Find(const std::string& name) const {
    static const std::vector<PlaceId> kNone;
    const auto found = by_name_.find(name);
    return found == by_name_.end() ? kNone : found->second;
  }

  // The sequence with a name; without one, the map's only sequence.
  const Sequence* FindSequence(const std::string& name) const {
    const std::vector<Sequence>& all = index_.map().sequences;
    if (name.empty()) return all.size() == 1 ? &all.front() : nullptr;
    const auto found = std::find_if(
        all.begin(), all.end(), [&](const Sequence& sequence) { return sequence.name == name; });
    return found == all.end() ? nullptr : &*found;
  }

  // The numbers that frames of a sequence may have. The map has how many there were, but not which
  // (--from, --every): the step between them divides the distances of those it still has.
  FrameNumbers NumbersOf(const Sequence& sequence) const {
    std::vector<int64_t> known;
    for (const MappedImage& image : images_) {
      if (image.sequence == sequence.id) known.push_back(image.frame);
    }
    if (const auto& orientation = index_.map().orientation) {
      for (const OrientationFrame& frame : orientation->frames) {
        if (frame.sequence == sequence.id) known.push_back(frame.frame);
      }
    }
    if (known.empty()) return {};
    const auto [first, last] = std::ranges::minmax(known);
    int64_t step = 0;
    for (const int64_t number : known) step = std::gcd(step, number - first);
    if (step == 0) return {};  // a single one
    return {std::clamp<int64_t>(last - step * (sequence.frames - 1), 0, first),
            std::max(last, first + step * sequence.frames - 1)};
  }

  // Of each layer, the last image at or before a frame and the first one at or after it.
  std::vector<PlaceId> Around(SequenceId sequence, int frame) const {
    std::vector<PlaceId> ids;
    for (const PlaceLayer layer : {PlaceLayer::kPlanes, PlaceLayer::kAppearance}) {
      const MappedImage* before = nullptr;
      const MappedImage* after = nullptr;
      for (const MappedImage& image : images_) {
        if (image.sequence != sequence || image.place.layer != layer) continue;
        if (image.frame <= frame && (!before || image.frame > before->frame)) before = &image;
        if (image.frame >= frame && (!after || image.frame < after->frame)) after = &image;
      }
      if (before) ids.push_back(before->place);
      if (after && after != before) ids.push_back(after->place);
    }
    return ids;
  }

 private:
  const MapIndex& index_;
  std::vector<MappedImage> images_;
  std::unordered_map<std::string, std::vector<PlaceId>> by_name_;
};

std::vector<std::string> SplitNames(const std::string& cell) {
  std::vector<std::string> names;
  std::istringstream text(cell);
  for (std::string name; std::getline(text, name, '|');) {
    if (!name.empty()) names.push_back(name);
  }
  return names;
}

[[noreturn]] void FailName(const CsvFile& file, int line, const std::string& cause) {
  throw MapError(ErrorCode::kNotFound,
                 file.path().string() + ", line " + std::to_string(line) + ": " + cause);
}

// One image, which both layers may have.
std::vector<PlaceId> ImageNamed(const CsvFile& file, int line, const std::string& name,
                                const ImageNames& names) {
  const std::vector<PlaceId>& found = names.Find(name);
  if (found.empty()) {
    FailName(file, line,
             "the map has no image \"" + name +
                 "\"; GET /v1/maps/{map}/keyframes and /appearance/nodes list them");
  }
  const auto of_layer = std::ranges::count(found, found.front().layer, &PlaceId::layer);
  if (of_layer > 1) {
    FailName(file, line,
             "the map has " + std::to_string(of_layer) + " images \"" + name +
                 "\"; specify it as sequence:source");
  }
  return found;
}

// "120" or "kitchen:120".
struct FrameName {
  SequenceId sequence;
  int frame = 0;
};

FrameName ParseFrame(const CsvFile& file, int line, const std::string& cell,
                     const ImageNames& names) {
  const size_t colon = cell.rfind(':');
  const std::string sequence_name = colon == std::string::npos ? "" : cell.substr(0, colon);
  const std::string number = colon == std::string::npos ? cell : cell.substr(colon + 1);
  const bool whole = !number.empty() && number.size() < 10 &&
                     std::all_of(number.begin(), number.end(),
                                 [](unsigned char c) { return std::isdigit(c) != 0; });
  if (!whole) file.Fail(line, "frame is \"" + cell + "\"; it must be a frame number");
  const Sequence* sequence = names.FindSequence(sequence_name);
  if (sequence == nullptr) {
    FailName(file, line,
             sequence_name.empty()
                 ? "the map has several sequences; specify the frame as sequence:frame"
                 : "the map has no sequence \"" + sequence_name + "\"; `waystone info` lists them");
  }
  const int frame = std::stoi(number);
  const FrameNumbers numbers = names.NumbersOf(*sequence);
  if (frame < numbers.first || frame > numbers.last) {
    FailName(file, line,
             "frame " + cell + " is outside of the mapped sequence, whose frames are " +
                 std::to_string(numbers.first) + " to " + std::to_string(numbers.last));
  }
  return {sequence->id, frame};
}

// How a file says where a row belongs.
struct PlaceColumns {
  std::optional<size_t> keyframe;
  std::optional<size_t> frame;
};

PlaceColumns FindPlaceColumns(const CsvFile& file) {
  const PlaceColumns columns{file.Column("keyframe"), file.Column("frame")};
  if (columns.keyframe.has_value() == columns.frame.has_value()) {
    file.Fail(1, "the header must have either a keyframe or a frame column");
  }
  return columns;
}

std::vector<PlaceId> TruthOf(const CsvFile& file, const CsvFile::Row& row,
                             const PlaceColumns& columns, const ImageNames& names) {
  const std::string& cell = row.cells[columns.keyframe ? *columns.keyframe : *columns.frame];
  std::vector<PlaceId> truth;
  const std::vector<std::string> place_names = SplitNames(cell);
  if (place_names.empty() && !cell.empty()) {
    file.Fail(row.line, "\"" + cell +
                            "\" names no keyframe or frame; leave the field empty if the image is "
                            "not in the map");
  }
  for (const std::string& name : place_names) {
    if (columns.keyframe) {
      const std::vector<PlaceId> named = ImageNamed(file, row.line, name, names);
      truth.insert(truth.end(), named.begin(), named.end());
      continue;
    }
    const FrameName frame = ParseFrame(file, row.line, name, names);
    const std::vector<PlaceId> around = names.Around(frame.sequence, frame.frame);
    if (around.empty())
      FailName(file, row.line, "the sequence of frame " + name + " has no images in the map");
    truth.insert(truth.end(), around.begin(), around.end());
  }
  return truth;
}

fs::path ImageIn(const CsvFile& file, const CsvFile::Row& row, size_t column) {
  if (row.cells[column].empty()) file.Fail(row.line, "the image field is empty");
  fs::path image = file.path().parent_path() / row.cells[column];
  std::error_code error;
  if (fs::is_regular_file(image, error)) return image;
  throw MapError(ErrorCode::kFileUnreadable, file.path().string() + ", line " +
                                                 std::to_string(row.line) +
                                                 ": file not found: " + image.string() +
                                                 "; paths are relative to the CSV file");
}

// The numbers in a text; a point between two digits is part of one.
std::vector<std::string> NumbersIn(const std::string& text) {
  constexpr const char* kDigits = "0123456789";
  const auto end_of_digits = [&](size_t from) {
    return std::min(text.find_first_not_of(kDigits, from), text.size());
  };
  std::vector<std::string> numbers;
  for (size_t at = text.find_first_of(kDigits); at != std::string::npos;) {
    size_t end = end_of_digits(at);
    if (end < text.size() && text[end] == '.' && end_of_digits(end + 1) > end + 1) {
      end = end_of_digits(end + 1);
    }
    numbers.push_back(text.substr(at, end - at));
    at = text.find_first_of(kDigits, end);
  }
  return numbers;
}

// What the name of an image says about when it was taken.
struct NameNumber {
  std::string text;
  std::optional<double> time_s;
  std::optional<int> frame;
};

// A number with a fraction is a time stamp, and a whole one a frame number; where it is the whole
// name, it may be either. Nothing where the name has no number, or several.
std::optional<NameNumber> FindNumber(const std::string& stem) {
  constexpr int64_t kMostFrames = 1'000'000'000;  // larger numbers can only be times
  const std::vector<std::string> numbers = NumbersIn(stem);
  if (numbers.size() != 1) return std::nullopt;
  NameNumber found{numbers.front(), std::nullopt, std::nullopt};
  const std::optional<int64_t> whole = ToInteger(found.text);
  if (whole && *whole < kMostFrames) found.frame = static_cast<int>(*whole);
  if (!found.frame || found.text == stem) found.time_s = ToNumber(found.text);
  return found;
}

// Throws MapError(kNotFound) where none is found: a query's place in its folder says nothing.
TruePose FindTruth(const fs::path& image, const ImagePoses& truth) {
  const auto number = FindNumber(image.stem().string());
  if (!number && !truth.AreNamed()) {
    throw MapError(
        ErrorCode::kNotFound,
        image.string() +
            " has no pose in the file of --truth: its name must have exactly one number, "
            "a frame number or a time in seconds; rename it or add names to the file "
            "(CSV with a column image)");
  }
  const NameNumber sought = number.value_or(NameNumber{});
  if (const auto pose = truth.Find(image.string(), sought.time_s, sought.frame)) return *pose;
  const std::string kind = !sought.frame ? "time " : sought.time_s ? "" : "frame ";
  const std::string by = truth.AreNamed() ? "its name" : kind + sought.text;
  throw MapError(ErrorCode::kNotFound, image.string() + " has no pose in the file of --truth (by " +
                                           by + "); add it or remove the image");
}

}  // namespace

std::vector<LabelledQuery> ReadQuerySet(const fs::path& path, const MapIndex& index) {
  const CsvFile file(path);
  const std::optional<size_t> image = file.Column("image");
  if (!image) file.Fail(1, "the header has no image column");
  const PlaceColumns place = FindPlaceColumns(file);
  const std::optional<PoseColumns> pose = PoseColumns::Find(file);
  const ImageNames names(index);
  std::vector<LabelledQuery> queries;
  for (const CsvFile::Row& row : file.rows()) {
    queries.push_back({ImageIn(file, row, *image), TruthOf(file, row, place, names),
                       pose ? pose->Read(file, row) : std::nullopt});
  }
  if (queries.empty()) file.Fail(1, "no queries; add one line per image after the header");
  return queries;
}

std::vector<LabelledQuery> ReadNegatives(const fs::path& folder) {
  std::error_code error;
  std::vector<LabelledQuery> queries;
  fs::recursive_directory_iterator at(folder, error);
  for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    std::error_code unknown;
    if (at->is_regular_file(unknown) && HasImageExtension(at->path()))
      queries.push_back({at->path(), {}, {}});
  }
  if (error) {
    throw MapError(ErrorCode::kFileUnreadable,
                   folder.string() + ": " + error.message() + "; expected a folder of images");
  }
  if (queries.empty()) {
    throw MapError(ErrorCode::kBadSource,
                   folder.string() + " contains no images; expected " + ImageExtensionsText());
  }
  std::sort(queries.begin(), queries.end(),
            [](const LabelledQuery& a, const LabelledQuery& b) { return a.image < b.image; });
  return queries;
}

std::vector<LabelledQuery> ReadPosedImages(const fs::path& folder, const ImagePoses& truth,
                                           const PlacePoses& places, double near_m) {
  std::vector<LabelledQuery> queries = ReadNegatives(folder);
  for (LabelledQuery& query : queries) {
    query.pose = FindTruth(query.image, truth);
    const Eigen::Vector3d at = query.pose->world_from_camera.translation();
    for (const auto& [place, of_place] : places) {
      const double apart = (of_place.world_from_camera.translation() - at).norm();
      if (apart <= near_m) query.truth.push_back(place);
    }
  }
  return queries;
}

PlacePoses PosesOfPlaces(const ImagePoses& poses, const MapIndex& index) {
  PlacePoses of_places;
  for (const MappedImage& image : ImagesOf(index.map())) {
    const std::optional<TruePose> pose = poses.Find(image.source, image.time_s, image.frame);
    if (pose) of_places.emplace(image.place, *pose);
  }
  if (!of_places.empty()) return of_places;
  throw MapError(ErrorCode::kNotFound,
                 "the file of --poses has no pose of an image of the map; poses are associated by "
                 "image name, time stamp or frame number");
}

}  // namespace waystone
