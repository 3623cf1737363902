// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/camera/camera.h"
#include "core/features/features.h"
#include "core/search/inverted_file.h"
#include "schema/layers/appearance/appearance_layer.h"
#include "schema/layers/floor_plans/floor_plan.h"
#include "schema/layers/links/keyframe_link.h"
#include "schema/layers/looks/looks.h"
#include "schema/layers/names/place_names.h"
#include "schema/layers/orientation/orientation_layer.h"
#include "schema/layers/planes/plane_layer.h"
#include "schema/layers/poses/pose_layer.h"
#include "schema/sequence_kinds.h"

// A map as plain values: what the builder passes to map_store.h and what the localizer gets from
// it. FORMAT.md says how each field is stored.
namespace waystone {

// One image sequence that the map was built from.
struct Sequence {
  SequenceId id;
  std::string name;  // of the folder or file, without its path
  std::string kind;  // one of kSequenceKinds (sequence_kinds.h)
  int frames = 0;    // read from the source
  int skipped = 0;   // of them, could not be decoded
  std::optional<Camera> camera;

  bool operator==(const Sequence&) const = default;
};

// Whether a sequence's images see all around: panoramas and rigs. Pure; thread-safe. One camera
// that looks ahead sees as many lines across a corridor as along it, in floor and ceiling, so the
// orientation layer can't distinguish corridors from rooms with it.
inline bool SeesAllAround(const Sequence& sequence) {
  return sequence.kind == kRigKind || sequence.kind == kCamerasKind || !sequence.camera ||
         sequence.camera->model == CameraModel::kEquirectangular;
}

struct MapInfo {
  std::string name;     // for people; the file's name without extension by default
  std::string program;  // "waystone 0.1.0": what wrote it
  FeatureType feature_type = FeatureType::kSift;
  std::string options_json;  // the builder's options, for people and for building the same again
  std::string version;       // "sha256:..." of the file; filled on reading, ignored on writing

  bool operator==(const MapInfo&) const = default;
};

struct MapData {
  MapInfo info;
  std::vector<Sequence> sequences;  // each list is ordered by id
  std::vector<Keyframe> keyframes;
  std::vector<Plane> planes;
  std::vector<Edge> edges;          // ordered by (a, b)
  std::vector<KeyframeLink> links;  // ordered, each once
  Looks looks;                      // of later walks; only maps that walks were added to have any
  // The descriptors of all planes and landmarks sorted for searching (IndexFeatures). Nothing for a
  // map that is small or whose index has a format that this program doesn't know.
  std::optional<InvertedFile> index;
  std::optional<VerdictModel> verdict;          // nothing for a map that was never calibrated
  std::optional<AppearanceLayer> appearance;    // nothing for a map without panoramas
  std::optional<OrientationLayer> orientation;  // nothing for a map without a calibrated camera
  std::optional<PoseLayer> poses;               // nothing for a map that was built without poses
  std::vector<NamedPlace> names;                // canonical (Canonical)
  std::vector<FloorPlanImage> floor_plans;      // ordered by name, each once

  bool operator==(const MapData&) const = default;
};

}  // namespace waystone
