// SPDX-License-Identifier: Apache-2.0
#include "api/names_file.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "api/query_request_json.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/layers/poses/horizontal.h"

namespace waystone {
namespace {

constexpr const char* kFormat = "waystone-names";
constexpr int kFormatVersion = 1;
constexpr JsonBounds kFileBounds{.depth = 8, .values = 200'000};
constexpr const char* kLayerFrame = "layer";  // of polygons of the appearance layer

// A keyframe or panorama with its image.
struct MappedImage {
  int64_t id = 0;
  int frame = 0;
  const std::string* source = nullptr;
};

std::vector<MappedImage> ImagesOf(const MapData& map, NamedKind kind, SequenceId sequence) {
  std::vector<MappedImage> images;
  const auto collect = [&](const auto& items) {
    for (const auto& item : items) {
      if (item.sequence == sequence) images.push_back({item.id.value, item.frame, &item.source});
    }
  };
  if (kind == NamedKind::kKeyframes) collect(map.keyframes);
  if (kind == NamedKind::kNodes && map.appearance) collect(map.appearance->nodes);
  return images;
}

// The number of a sequence among those with the same name, from 1.
int NumberAmongNamesakes(const MapData& map, const Sequence& sequence) {
  int number = 0;
  for (const Sequence& other : map.sequences) {
    if (other.name == sequence.name) ++number;
    if (other.id == sequence.id) break;
  }
  return number;
}

const Sequence* FindSequence(const MapData& map, const std::string& name, int number) {
  for (const Sequence& sequence : map.sequences) {
    if (ToUtf8(sequence.name) == name && NumberAmongNamesakes(map, sequence) == number) {
      return &sequence;
    }
  }
  return nullptr;
}

const Sequence* SequenceOf(const MapData& map, SequenceId id) {
  const auto found = std::ranges::find(map.sequences, id, &Sequence::id);
  return found == map.sequences.end() ? nullptr : &*found;
}

// The ranges of those of `images` whose frames are within the bounds.
std::vector<NamedRange> RangesWithin(const MapData& map, NamedKind kind,
                                     const std::vector<MappedImage>& images, int first, int last) {
  std::set<int64_t> held;
  for (const MappedImage& image : images) {
    if (first <= image.frame && image.frame <= last) held.insert(image.id);
  }
  return RangesOf(map, kind, held);
}

// ---- images that a user names

// The frame of an image of a sequence given by name or number; nothing if it isn't among the
// images.
std::optional<int> FindFrame(const std::vector<MappedImage>& images, const std::string& text) {
  for (const MappedImage& image : images) {
    if (*image.source == text) return image.frame;
  }
  const std::optional<int64_t> number = ToInteger(text);
  if (!number || *number < 0 || *number > INT32_MAX) return std::nullopt;
  return static_cast<int>(*number);
}

// Keyframes and panoramas of a sequence.
std::vector<MappedImage> AllImagesOf(const MapData& map, SequenceId sequence) {
  std::vector<MappedImage> images = ImagesOf(map, NamedKind::kKeyframes, sequence);
  const std::vector<MappedImage> nodes = ImagesOf(map, NamedKind::kNodes, sequence);
  images.insert(images.end(), nodes.begin(), nodes.end());
  return images;
}

// The only sequence to which a range can refer.
const Sequence& ChooseSequence(const MapData& map, const ImageRange& range) {
  std::vector<const Sequence*> fitting;
  for (const Sequence& sequence : map.sequences) {
    if (!range.sequence.empty() && sequence.name != range.sequence) continue;
    const std::vector<MappedImage> images = AllImagesOf(map, sequence.id);
    if (FindFrame(images, range.first) && FindFrame(images, range.last)) {
      fitting.push_back(&sequence);
    }
  }
  if (fitting.size() == 1) return *fitting.front();
  if (fitting.empty()) {
    throw MapError(ErrorCode::kNotFound,
                   "no sequence of the map has keyframes or panoramas of the images " +
                       QuoteShortened(range.first) + " and " + QuoteShortened(range.last) +
                       "; specify images that were kept, or numbers of frames");
  }
  throw MapError(ErrorCode::kUsage, QuoteShortened(range.first) + " is in " +
                                        std::to_string(fitting.size()) +
                                        " sequences of the map; specify one with --sequence, or "
                                        "use ids");
}

// ---- the file

Json EndJson(const MappedImage& image) {
  return {{"image", *image.source}, {"frame", image.frame}};
}

Json SequenceRefJson(const MapData& map, const Sequence& sequence) {
  Json json = {{"sequence", sequence.name}};
  const int number = NumberAmongNamesakes(map, sequence);
  if (number > 1) json["sequence_number"] = number;
  return json;
}

void AddImageRanges(const MapData& map, const NamedRange& range, Json& list) {
  for (const Sequence& sequence : map.sequences) {
    const MappedImage* first = nullptr;
    const MappedImage* last = nullptr;
    const std::vector<MappedImage> images = ImagesOf(map, range.kind, sequence.id);
    for (const MappedImage& image : images) {
      if (image.id < range.first || range.last < image.id) continue;
      if (!first || image.frame < first->frame) first = &image;
      if (!last || image.frame > last->frame) last = &image;
    }
    if (!first) continue;
    Json json = SequenceRefJson(map, sequence);
    json["first"] = EndJson(*first);
    json["last"] = EndJson(*last);
    list.push_back(std::move(json));
  }
}

// A point inside a plane's outline, near its middle: the corners' mean if it is inside, else the
// nearest to it of the centroids of three consecutive corners that are inside; every polygon has
// such.
Eigen::Vector2d PointInside(const Plane& plane) {
  const std::vector<Eigen::Vector2d>& corners = plane.outline;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : corners) middle += corner;
  middle /= static_cast<double>(corners.size());
  if (Holds(corners, middle)) return middle;
  std::optional<Eigen::Vector2d> nearest;
  for (size_t i = 0; i < corners.size(); ++i) {
    const size_t j = (i + 1) % corners.size();
    const size_t k = (i + 2) % corners.size();
    const Eigen::Vector2d point = (corners[i] + corners[j] + corners[k]) / 3;
    const bool nearer = !nearest || (point - middle).norm() < (*nearest - middle).norm();
    if (nearer && Holds(corners, point)) nearest = point;
  }
  return nearest.value_or(middle);
}

// A plane is identified by one of its points in its reference image.
void AddPlanes(const MapData& map, const NamedRange& range, Json& list) {
  for (const Plane& plane : map.planes) {
    if (plane.id.value < range.first || range.last < plane.id.value) continue;
    const auto keyframe = std::ranges::find(map.keyframes, plane.reference, &Keyframe::id);
    if (keyframe == map.keyframes.end() || plane.outline.empty()) continue;
    const Sequence* sequence = SequenceOf(map, keyframe->sequence);
    if (!sequence) continue;
    const Eigen::Vector2d middle = PointInside(plane);
    Json json = SequenceRefJson(map, *sequence);
    json["image"] = keyframe->source;
    json["frame"] = keyframe->frame;
    json["at_px"] = {Rounded(middle.x(), 2), Rounded(middle.y(), 2)};
    list.push_back(std::move(json));
  }
}

Json AxisJson(const Eigen::Vector3d& axis) {
  return {Rounded(axis.x(), 6), Rounded(axis.y(), 6), Rounded(axis.z(), 6)};
}

Json CornersJson(const NamedPolygon& polygon) {
  Json corners = Json::array();
  for (const Eigen::Vector2d& corner : polygon) corners.push_back({corner.x(), corner.y()});
  return corners;
}

// An empty place.
Json EmptyPlaceJson(const std::string& name) {
  return {{"name", name},
          {"keyframes", Json::array()},
          {"nodes", Json::array()},
          {"planes", Json::array()},
          {"polygons", Json::array()}};
}

Json PlaceJson(const MapData& map, const NamedPlace& place) {
  Json json = EmptyPlaceJson(place.name);
  for (const NamedRange& range : place.ranges) {
    Json& list = json[std::string(NameOf(range.kind))];
    range.kind == NamedKind::kPlanes ? AddPlanes(map, range, list)
                                     : AddImageRanges(map, range, list);
  }
  for (const NamedPolygon& polygon : place.polygons) {
    Json area = AreaFrameJson(map);
    area["corners"] = CornersJson(polygon);
    json["polygons"].push_back(std::move(area));
  }
  return json;
}

const Json& Field(const Json& object, const std::string& what, const char* name) {
  if (!object.is_object() || !object.contains(name)) {
    RefuseRequest(what + " has no field " + name);
  }
  return object[name];
}

std::string TextField(const Json& object, const std::string& what, const char* name) {
  const Json& value = Field(object, what, name);
  if (!value.is_string()) RefuseRequest(what + ": " + name + " must be a string");
  return value.get<std::string>();
}

int WholeField(const Json& object, const std::string& what, const char* name, int low) {
  const std::optional<int64_t> number = WholeNumber(Field(object, what, name));
  if (!number || *number < low || *number > INT32_MAX) {
    RefuseRequest(what + ": " + name + " must be an integer of " + std::to_string(low) +
                  " or more");
  }
  return static_cast<int>(*number);
}

Eigen::Vector2d PointIn(const Json& value, const std::string& what) {
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number()) {
    RefuseRequest(what + " must be two numbers");
  }
  return {value[0].get<double>(), value[1].get<double>()};
}

const Json& ListField(const Json& object, const std::string& what, const std::string& name) {
  static const Json kNone = Json::array();
  if (!object.contains(name)) return kNone;
  if (!object[name].is_array()) RefuseRequest(what + ": " + name + " must be a list");
  return object[name];
}

// Frames that are levelled only by their images differ a little from build to build.
bool IsNear(const Json& frame, const std::string& what, const char* name,
            const Eigen::Vector3d& axis) {
  constexpr double kMostApart = 0.05;
  const Json& value = Field(frame, what, name);
  Eigen::Vector3d given;
  if (!value.is_array() || value.size() != 3) RefuseRequest(what + ": " + name + " is no axis");
  for (int i = 0; i < 3; ++i) {
    if (!value[i].is_number()) RefuseRequest(what + ": " + name + " is no axis");
    given[i] = value[i].get<double>();
  }
  return (given - axis).norm() <= kMostApart;
}

// The images of a sequence, found by name or number.
struct KnownImages {
  std::vector<MappedImage> images;
  std::unordered_map<std::string, int> frames;   // by name, as JSON has it
  std::unordered_map<int, std::string> sources;  // by frame
};

KnownImages Know(std::vector<MappedImage> images) {
  KnownImages known{std::move(images), {}, {}};
  for (const MappedImage& image : known.images) {
    known.frames.emplace(ToUtf8(*image.source), image.frame);
    known.sources.emplace(image.frame, *image.source);
  }
  return known;
}

// Reads the places of a file, part by part.
class FileReader {
 public:
  explicit FileReader(const MapData& map) : map_(map) {}

  ReadNames Read(const Json& file) {
    for (const Json& place : ListField(file, "the file", "places")) ReadPlace(place);
    result_.places = Canonical(std::move(result_.places));
    return std::move(result_);
  }

 private:
  void ReadPlace(const Json& place) {
    CheckKnownFields(place, "a place", {"name", "keyframes", "nodes", "planes", "polygons"});
    const std::string name = TextField(place, "a place", "name");
    if (const auto problem = FindNameProblem(name)) {
      RefuseRequest("the name " + QuoteShortened(name) + " " + *problem);
    }
    place_ = {name, {}, {}};
    what_ = "place " + QuoteShortened(name);
    for (const NamedKind kind : {NamedKind::kKeyframes, NamedKind::kNodes}) {
      for (const Json& range : ListField(place, what_, std::string(NameOf(kind)))) {
        ReadImageRange(kind, range);
      }
    }
    for (const Json& plane : ListField(place, what_, "planes")) ReadPlane(plane);
    for (const Json& polygon : ListField(place, what_, "polygons")) ReadPolygon(polygon);
    result_.places.push_back(std::move(place_));
  }

  void Miss(const std::string& cause) { result_.misfits.push_back({place_.name, cause}); }

  const Sequence* ReadSequence(const Json& ref) {
    const std::string name = TextField(ref, what_, "sequence");
    const int number =
        ref.contains("sequence_number") ? WholeField(ref, what_, "sequence_number", 1) : 1;
    const Sequence* sequence = FindSequence(map_, name, number);
    if (!sequence) {
      Miss("the map has no sequence " + QuoteShortened(name) +
           (number > 1 ? " number " + std::to_string(number) : ""));
    }
    return sequence;
  }

  const KnownImages& ImagesOf(NamedKind kind, SequenceId sequence) {
    const auto [found, is_new] = known_.try_emplace({kind, sequence});
    if (is_new) found->second = Know(waystone::ImagesOf(map_, kind, sequence));
    return found->second;
  }

  // The frame of an image; nothing where the sequence has another image there.
  std::optional<int> ReadFrame(const Json& end, const KnownImages& known) {
    CheckKnownFields(end, what_, {"image", "frame"});
    const std::string image = TextField(end, what_, "image");
    const int frame = WholeField(end, what_, "frame", 0);
    if (const auto found = known.frames.find(image); found != known.frames.end()) {
      return found->second;
    }
    const auto other = known.sources.find(frame);
    if (other == known.sources.end()) return frame;
    Miss("frame " + std::to_string(frame) + " of the sequence is " + QuoteShortened(other->second) +
         " in this map, not " + QuoteShortened(image));
    return std::nullopt;
  }

  void ReadImageRange(NamedKind kind, const Json& range) {
    CheckKnownFields(range, what_, {"sequence", "sequence_number", "first", "last"});
    CountPart();
    const Sequence* sequence = ReadSequence(range);
    const KnownImages& known = ImagesOf(kind, sequence ? sequence->id : SequenceId{});
    const std::optional<int> first = ReadFrame(Field(range, what_, "first"), known);
    const std::optional<int> last = ReadFrame(Field(range, what_, "last"), known);
    if (!sequence || !first || !last) return;
    const std::vector<NamedRange> ranges = RangesWithin(map_, kind, known.images, *first, *last);
    if (ranges.empty()) {
      Miss("the map has no " + std::string(NameOf(kind)) + " between frames " +
           std::to_string(*first) + " and " + std::to_string(*last) + " of the sequence " +
           QuoteShortened(sequence->name));
    }
    place_.ranges.insert(place_.ranges.end(), ranges.begin(), ranges.end());
  }

  void CountPart() {
    if (++parts_ > kMaxNamedRanges) {
      RefuseRequest("the file has more than " + std::to_string(kMaxNamedRanges) + " ranges");
    }
  }

  void ReadPlane(const Json& ref) {
    CheckKnownFields(ref, what_, {"sequence", "sequence_number", "image", "frame", "at_px"});
    CountPart();
    const Sequence* sequence = ReadSequence(ref);
    const Eigen::Vector2d at = PointIn(Field(ref, what_, "at_px"), what_ + ": at_px");
    const std::string image = TextField(ref, what_, "image");
    WholeField(ref, what_, "frame", 0);
    if (!sequence) return;
    for (const Keyframe& keyframe : map_.keyframes) {
      if (keyframe.sequence != sequence->id || ToUtf8(keyframe.source) != image) continue;
      if (const Plane* plane = FindPlaneAt(keyframe.id, at)) {
        place_.ranges.push_back({NamedKind::kPlanes, plane->id.value, plane->id.value});
        return;
      }
    }
    Miss("the map has no plane at (" + Dump(at.x()) + ", " + Dump(at.y()) + ") of the image " +
         QuoteShortened(image));
  }

  // The plane that a keyframe shows at a point: of several the one with the smallest outline.
  const Plane* FindPlaneAt(KeyframeId keyframe, const Eigen::Vector2d& at) const {
    const Plane* best = nullptr;
    for (const Plane& plane : map_.planes) {
      const auto view = std::ranges::find(plane.views, keyframe, &PlaneView::keyframe);
      if (view == plane.views.end() || plane.outline.size() < 3) continue;
      const Eigen::Vector2d there =
          (view->reference_from_keyframe * at.homogeneous()).hnormalized();
      if (!there.allFinite() || !Holds(plane.outline, there)) continue;
      if (!best || AreaOf(plane.outline) < AreaOf(best->outline)) best = &plane;
    }
    return best;
  }

  void ReadPolygon(const Json& area) {
    CheckKnownFields(area, what_, {"frame", "unit", "right", "top", "corners"});
    NamedPolygon polygon;
    for (const Json& corner : ListField(area, what_, "corners")) {
      polygon.push_back(PointIn(corner, what_ + ": a corner"));
    }
    if (const auto problem = FindPolygonProblem(polygon)) {
      RefuseRequest(what_ + ": a polygon " + *problem);
    }
    if (const auto cause = FindFrameMisfit(area, what_, map_)) {
      Miss("a polygon is " + *cause);
    } else {
      place_.polygons.push_back(std::move(polygon));
    }
  }

  const MapData& map_;
  NamedPlace place_;
  std::string what_;
  size_t parts_ = 0;
  std::map<std::pair<NamedKind, SequenceId>, KnownImages> known_;
  ReadNames result_;
};

// A file whose map shares no sequence with this one is for another building.
void CheckIsForMap(const Json& file, const MapData& map) {
  const Json& of = Field(file, "the file", "map");
  const Json& sequences = Field(of, "map", "sequences");
  if (!sequences.is_array()) RefuseRequest("map: sequences must be a list");
  for (const Json& name : sequences) {
    if (!name.is_string()) RefuseRequest("map: sequences must be names");
    if (FindSequence(map, name.get<std::string>(), 1)) return;
  }
  throw MapError(ErrorCode::kNotAvailable,
                 "these are names for the map " + QuoteShortened(TextField(of, "map", "name")) +
                     ", none of whose " + std::to_string(sequences.size()) +
                     " sequences is in this map; use the file with a map of the same images");
}

}  // namespace

NamedPlace PlaceOfImages(const MapData& map, const std::string& name, const ImageRange& range) {
  const Sequence& sequence = ChooseSequence(map, range);
  NamedPlace place{name, {}, {}};
  const std::vector<MappedImage> both = AllImagesOf(map, sequence.id);
  const int first = *FindFrame(both, range.first), last = *FindFrame(both, range.last);
  if (first > last) {
    throw MapError(ErrorCode::kUsage, QuoteShortened(range.first) + " comes after " +
                                          QuoteShortened(range.last) + " in its sequence");
  }
  for (const NamedKind kind : {NamedKind::kKeyframes, NamedKind::kNodes}) {
    const std::vector<NamedRange> ranges =
        RangesWithin(map, kind, ImagesOf(map, kind, sequence.id), first, last);
    place.ranges.insert(place.ranges.end(), ranges.begin(), ranges.end());
  }
  if (!place.ranges.empty()) return place;
  throw MapError(ErrorCode::kUsage, "the map has no keyframe or panorama between frames " +
                                        std::to_string(first) + " and " + std::to_string(last) +
                                        " of the sequence " + QuoteShortened(sequence.name));
}

Json AreaFrameJson(const MapData& map) {
  if (!map.poses) return {{"frame", kLayerFrame}};
  const Horizontal view = HorizontalOf(*map.poses);
  return {{"frame", map.poses->frame},
          {"unit", NameOf(map.poses->unit)},
          {"right", AxisJson(view.right)},
          {"top", AxisJson(view.top)}};
}

std::optional<std::string> FindFrameMisfit(const Json& frame, const std::string& what,
                                           const MapData& map) {
  const std::string name = TextField(frame, what, "frame");
  if (!map.poses && !map.appearance) {
    return "in the frame " + QuoteShortened(name) + ", and the map has no positions";
  }
  const std::string own = map.poses ? ToUtf8(map.poses->frame) : kLayerFrame;
  if (name != own) {
    return "in the frame " + QuoteShortened(name) + ", and the map in " + QuoteShortened(own);
  }
  if (!map.poses) return std::nullopt;
  const std::string unit = TextField(frame, what, "unit");
  if (unit != NameOf(map.poses->unit)) {
    return "in the unit " + QuoteShortened(unit) + ", and the map in '" +
           std::string(NameOf(map.poses->unit)) + "'";
  }
  const Horizontal view = HorizontalOf(*map.poses);
  if (IsNear(frame, what, "right", view.right) && IsNear(frame, what, "top", view.top)) {
    return std::nullopt;
  }
  return "in another horizontal plane of the frame";
}

Json NamesFileJson(const std::string& map_name, const MapData& map) {
  Json sequences = Json::array();
  std::set<std::string> named;
  for (const Sequence& sequence : map.sequences) {
    if (named.insert(sequence.name).second) sequences.push_back(sequence.name);
  }
  Json json;
  json["format"] = kFormat;
  json["format_version"] = kFormatVersion;
  json["map"] = {
      {"name", map_name}, {"version", map.info.version}, {"sequences", std::move(sequences)}};
  json["places"] = Json::array();
  for (const NamedPlace& place : map.names) json["places"].push_back(PlaceJson(map, place));
  return json;
}

ReadNames ReadNamesFile(std::string_view text, const MapData& map) {
  const Json file = ParseJson(text, kFileBounds);
  CheckKnownFields(file, "the file", {"format", "format_version", "map", "places"});
  const std::string format = TextField(file, "the file", "format");
  if (format != kFormat) {
    RefuseRequest("the file has the format " + QuoteShortened(format) + "; expected " + kFormat);
  }
  const int version = WholeField(file, "the file", "format_version", 1);
  if (version != kFormatVersion) {
    RefuseRequest("the file has the version " + std::to_string(version) +
                  " of its format, and this program reads " + std::to_string(kFormatVersion) +
                  "; use a newer Waystone");
  }
  CheckIsForMap(file, map);
  return FileReader(map).Read(file);
}

Json NamedPlacesJson(const std::vector<NamedPlace>& places) {
  Json list = Json::array();
  for (const NamedPlace& place : places) {
    Json json = EmptyPlaceJson(place.name);
    for (const NamedRange& range : place.ranges) {
      json[std::string(NameOf(range.kind))].push_back({range.first, range.last});
    }
    for (const NamedPolygon& polygon : place.polygons) {
      json["polygons"].push_back(CornersJson(polygon));
    }
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace waystone
