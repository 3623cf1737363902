// SPDX-License-Identifier: Apache-2.0
#include "cli/query_set.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <sstream>
#include <string>

#include "cli/csv_file.h"
#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// The keyframes of a map by the names that people give them.
class KeyframeNames {
 public:
  explicit KeyframeNames(const MapIndex& index) : index_(index) {
    for (const Keyframe& keyframe : index.map().keyframes) {
      const std::string& sequence = index.FindSequence(keyframe.sequence)->name;
      by_name_[keyframe.source].push_back(keyframe.id);
      by_name_[sequence + ":" + keyframe.source].push_back(keyframe.id);
    }
  }

  // By source, or by "sequence:source".
  const std::vector<KeyframeId>& Find(const std::string& name) const {
    static const std::vector<KeyframeId> kNone;
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

  // The last keyframe at or before a frame and the first one at or after it.
  std::vector<KeyframeId> Around(SequenceId sequence, int frame) const {
    const Keyframe* before = nullptr;
    const Keyframe* after = nullptr;
    for (const Keyframe& keyframe : index_.map().keyframes) {
      if (keyframe.sequence != sequence) continue;
      if (keyframe.frame <= frame && (!before || keyframe.frame > before->frame))
        before = &keyframe;
      if (keyframe.frame >= frame && (!after || keyframe.frame < after->frame)) after = &keyframe;
    }
    std::vector<KeyframeId> ids;
    if (before) ids.push_back(before->id);
    if (after && (!before || after->id != before->id)) ids.push_back(after->id);
    return ids;
  }

 private:
  const MapIndex& index_;
  std::unordered_map<std::string, std::vector<KeyframeId>> by_name_;
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

KeyframeId KeyframeNamed(const CsvFile& file, int line, const std::string& name,
                         const KeyframeNames& names) {
  const std::vector<KeyframeId>& found = names.Find(name);
  if (found.empty()) {
    FailName(file, line,
             "the map has no keyframe \"" + name + "\"; see GET /v1/maps/{map}/keyframes");
  }
  if (found.size() > 1) {
    FailName(file, line,
             "the map has " + std::to_string(found.size()) + " keyframes \"" + name +
                 "\"; specify it as sequence:source");
  }
  return found.front();
}

// "120" or "kitchen:120".
struct FrameName {
  SequenceId sequence;
  int frame = 0;
};

FrameName ParseFrame(const CsvFile& file, int line, const std::string& cell,
                     const KeyframeNames& names) {
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
  return {sequence->id, std::stoi(number)};
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

std::vector<KeyframeId> TruthOf(const CsvFile& file, const CsvFile::Row& row,
                                const PlaceColumns& columns, const KeyframeNames& names) {
  const std::string& cell = row.cells[columns.keyframe ? *columns.keyframe : *columns.frame];
  std::vector<KeyframeId> truth;
  for (const std::string& name : SplitNames(cell)) {
    if (columns.keyframe) {
      truth.push_back(KeyframeNamed(file, row.line, name, names));
      continue;
    }
    const FrameName frame = ParseFrame(file, row.line, name, names);
    const std::vector<KeyframeId> around = names.Around(frame.sequence, frame.frame);
    if (around.empty())
      FailName(file, row.line, "the sequence of frame " + name + " has no keyframes");
    truth.insert(truth.end(), around.begin(), around.end());
  }
  return truth;
}

using PositionColumns = std::optional<std::array<size_t, 3>>;

PositionColumns FindPositionColumns(const CsvFile& file) {
  const auto x = file.Column("x");
  const auto y = file.Column("y");
  const auto z = file.Column("z");
  if (!x && !y && !z) return std::nullopt;
  if (!x || !y || !z) file.Fail(1, "the header must have all of the columns x, y and z, or none");
  return std::array<size_t, 3>{*x, *y, *z};
}

std::optional<Eigen::Vector3d> PositionIn(const CsvFile& file, const CsvFile::Row& row,
                                          const PositionColumns& columns) {
  if (!columns) return std::nullopt;
  const bool none = std::all_of(columns->begin(), columns->end(),
                                [&](size_t column) { return row.cells[column].empty(); });
  if (none) return std::nullopt;
  return Eigen::Vector3d(file.Number(row, (*columns)[0]), file.Number(row, (*columns)[1]),
                         file.Number(row, (*columns)[2]));
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

bool IsImage(const fs::path& path) {
  static constexpr std::array kEndings = {".jpg", ".jpeg", ".png", ".bmp", ".pgm", ".ppm", ".pnm"};
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

}  // namespace

std::vector<LabelledQuery> ReadQuerySet(const fs::path& path, const MapIndex& index) {
  const CsvFile file(path);
  const std::optional<size_t> image = file.Column("image");
  if (!image) file.Fail(1, "the header has no image column");
  const PlaceColumns place = FindPlaceColumns(file);
  const PositionColumns position = FindPositionColumns(file);
  const KeyframeNames names(index);
  std::vector<LabelledQuery> queries;
  for (const CsvFile::Row& row : file.rows()) {
    queries.push_back({ImageIn(file, row, *image), TruthOf(file, row, place, names),
                       PositionIn(file, row, position)});
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
    if (at->is_regular_file(unknown) && IsImage(at->path()))
      queries.push_back({at->path(), {}, {}});
  }
  if (error) {
    throw MapError(ErrorCode::kFileUnreadable,
                   folder.string() + ": " + error.message() + "; expected a folder of images");
  }
  if (queries.empty()) {
    throw MapError(ErrorCode::kBadSource,
                   folder.string() + " contains no images; expected JPEG, PNG, BMP or PNM files");
  }
  std::sort(queries.begin(), queries.end(),
            [](const LabelledQuery& a, const LabelledQuery& b) { return a.image < b.image; });
  return queries;
}

KeyframePositions ReadPositions(const fs::path& path, const MapIndex& index) {
  const CsvFile file(path);
  const PlaceColumns place = FindPlaceColumns(file);
  const PositionColumns columns = FindPositionColumns(file);
  if (!columns) file.Fail(1, "the header has no columns x, y and z");
  const KeyframeNames names(index);
  KeyframePositions positions;
  for (const CsvFile::Row& row : file.rows()) {
    const std::optional<Eigen::Vector3d> position = PositionIn(file, row, columns);
    if (!position) continue;
    const std::string& cell = row.cells[place.keyframe ? *place.keyframe : *place.frame];
    if (place.keyframe) {
      for (const KeyframeId id : names.Find(cell)) positions[id] = *position;
      continue;
    }
    const FrameName frame = ParseFrame(file, row.line, cell, names);
    const std::vector<KeyframeId> around = names.Around(frame.sequence, frame.frame);
    if (around.size() == 1 && index.FindKeyframe(around.front())->frame == frame.frame) {
      positions[around.front()] = *position;
    }
  }
  return positions;
}

}  // namespace waystone
