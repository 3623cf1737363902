// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/layers.h"

#include <algorithm>

#include "schema/layers/appearance/appearance_tables.h"
#include "schema/layers/floor_plans/floor_plan_tables.h"
#include "schema/layers/layer_problems.h"
#include "schema/layers/layer_rows.h"
#include "schema/layers/links/link_tables.h"
#include "schema/layers/looks/look_tables.h"
#include "schema/layers/names/name_tables.h"
#include "schema/layers/orientation/orientation_tables.h"
#include "schema/layers/planes/plane_tables.h"
#include "schema/layers/poses/pose_tables.h"

namespace waystone {
namespace {

// The length of descriptors without rows is meaningless, so it may differ.
bool SamePlane(const Plane& a, const Plane& b) {
  return a.id == b.id && a.reference == b.reference && a.features == b.features &&
         a.descriptors.data() == b.descriptors.data() && a.outline == b.outline &&
         a.views == b.views;
}

bool SamePlaneLayer(const MapData& a, const MapData& b) {
  return a.keyframes == b.keyframes && a.edges == b.edges && a.index == b.index &&
         a.verdict == b.verdict && std::ranges::equal(a.planes, b.planes, SamePlane);
}

StoredLayer StoredPlanes() {
  return {.tables = {kKeyframesTable, kKeyframeImagesTable, kKeyframeLandmarksTable, kPlanesTable,
                     kPlaneFeaturesTable, kPlaneViewsTable, kEdgesTable, kSearchIndexTable,
                     kVerdictModelTable},
          .optional_tables = {},
          .read = ReadPlaneLayer,
          .write = WritePlaneLayer,
          .find_problems = FindPlaneProblems,
          .equal = SamePlaneLayer};
}

StoredLayer StoredAppearance() {
  return {.tables = {kAppearanceLayerTable, kAppearanceMirrorTable, kAppearanceNodesTable,
                     kAppearanceSignaturesTable, kAppearanceFeaturesTable, kAppearanceImagesTable,
                     kAppearanceEdgesTable, kAppearanceVerdictTable, kAppearanceVerdictTermsTable},
          .optional_tables = {},
          .read =
              [](SQLite::Database& database, bool images, MapData& map,
                 std::vector<MapProblem>& problems) {
                map.appearance = ReadAppearance(database, map.info.feature_type, images, problems);
              },
          .write =
              [](const MapData& map, RowSink& sink) {
                if (map.appearance) WriteAppearance(*map.appearance, sink);
              },
          .find_problems =
              [](const MapData& map, std::vector<MapProblem>& problems) {
                if (map.appearance) FindAppearanceProblems(map, problems);
              },
          .equal = [](const MapData& a, const MapData& b) { return a.appearance == b.appearance; }};
}

StoredLayer StoredOrientation() {
  return {
      .tables = {kOrientationLayerTable, kOrientationFramesTable, kOrientationTurnsTable,
                 kOrientationNodesTable, kOrientationImagesTable, kOrientationEdgesTable,
                 kCorridorsTable},
      .optional_tables = {},
      .read =
          [](SQLite::Database& database, bool images, MapData& map,
             std::vector<MapProblem>& problems) {
            map.orientation = ReadOrientation(database, images, problems);
          },
      .write =
          [](const MapData& map, RowSink& sink) {
            if (map.orientation) WriteOrientation(*map.orientation, sink);
          },
      .find_problems =
          [](const MapData& map, std::vector<MapProblem>& problems) {
            if (map.orientation) FindOrientationProblems(map, problems);
          },
      .equal = [](const MapData& a, const MapData& b) { return a.orientation == b.orientation; }};
}

StoredLayer StoredPoses() {
  return {
      .tables = {kPoseLayerTable, kKeyframePosesTable, kPlanePosesTable, kPlaneDepthsTable,
                 kLandmarkDepthsTable},
      .optional_tables = {},
      .read = [](SQLite::Database& database, bool /*images*/, MapData& map,
                 std::vector<MapProblem>& problems) { map.poses = ReadPoses(database, problems); },
      .write =
          [](const MapData& map, RowSink& sink) {
            if (map.poses) WritePoses(*map.poses, sink);
          },
      .find_problems =
          [](const MapData& map, std::vector<MapProblem>& problems) {
            if (map.poses) FindPoseProblems(map, problems);
          },
      .equal = [](const MapData& a, const MapData& b) { return a.poses == b.poses; }};
}

// A part of the pose layer, which checks and compares it; separate because only this part is
// written when optional tables are rewritten.
StoredLayer StoredNodePoses() {
  return {
      .tables = {},
      .optional_tables = {{kNodePosesTable, kNodePosesSql},
                          {kNodePoseErrorsTable, kNodePoseErrorsSql}},
      .read =
          [](SQLite::Database& database, bool /*images*/, MapData& map,
             std::vector<MapProblem>& problems) { ReadNodePoses(database, map.poses, problems); },
      .write =
          [](const MapData& map, RowSink& sink) {
            if (map.poses) WriteNodePoses(*map.poses, sink);
          },
      .find_problems = [](const MapData&, std::vector<MapProblem>&) {},
      .equal = [](const MapData&, const MapData&) { return true; }};
}

StoredLayer StoredLinks() {
  return {
      .tables = {},
      .optional_tables = {{kKeyframeLinksTable, kKeyframeLinksSql}},
      .read = [](SQLite::Database& database, bool /*images*/, MapData& map,
                 std::vector<MapProblem>& problems) { map.links = ReadLinks(database, problems); },
      .write = [](const MapData& map, RowSink& sink) { WriteLinks(map.links, sink); },
      .find_problems = FindLinkProblems,
      .equal = [](const MapData& a, const MapData& b) { return a.links == b.links; }};
}

StoredLayer StoredLooks() {
  return {
      .tables = {},
      .optional_tables = {{kPlaneLooksTable, kPlaneLooksSql},
                          {kLandmarkLooksTable, kLandmarkLooksSql}},
      .read = [](SQLite::Database& database, bool /*images*/, MapData& map,
                 std::vector<MapProblem>& problems) { map.looks = ReadLooks(database, problems); },
      .write = [](const MapData& map, RowSink& sink) { WriteLooks(map.looks, sink); },
      .find_problems = FindLookProblems,
      .equal = [](const MapData& a, const MapData& b) { return a.looks == b.looks; }};
}

StoredLayer StoredNames() {
  return {
      .tables = {},
      .optional_tables = {{kPlaceRangesTable, kPlaceRangesSql},
                          {kPlacePolygonsTable, kPlacePolygonsSql}},
      .read = [](SQLite::Database& database, bool /*images*/, MapData& map,
                 std::vector<MapProblem>& problems) { map.names = ReadNames(database, problems); },
      .write = [](const MapData& map, RowSink& sink) { WriteNames(map.names, sink); },
      .find_problems = FindNameProblems,
      .equal = [](const MapData& a, const MapData& b) { return a.names == b.names; }};
}

StoredLayer StoredFloorPlans() {
  return {
      .tables = {},
      .optional_tables = {{kFloorPlansTable, kFloorPlansSql}},
      .read =
          [](SQLite::Database& database, bool images, MapData& map,
             std::vector<MapProblem>& problems) {
            map.floor_plans = ReadFloorPlans(database, images, problems);
          },
      .write = [](const MapData& map, RowSink& sink) { WriteFloorPlans(map.floor_plans, sink); },
      .find_problems = FindFloorPlanProblems,
      .equal = [](const MapData& a, const MapData& b) { return a.floor_plans == b.floor_plans; }};
}

}  // namespace

const std::vector<StoredLayer>& StoredLayers() {
  static const std::vector<StoredLayer> layers{
      StoredPlanes(), StoredAppearance(), StoredOrientation(), StoredPoses(),     StoredNodePoses(),
      StoredLinks(),  StoredLooks(),      StoredNames(),       StoredFloorPlans()};
  return layers;
}

const std::vector<OptionalTable>& OptionalTables() {
  static const std::vector<OptionalTable> tables = [] {
    std::vector<OptionalTable> all;
    for (const StoredLayer& layer : StoredLayers()) {
      all.insert(all.end(), layer.optional_tables.begin(), layer.optional_tables.end());
    }
    return all;
  }();
  return tables;
}

}  // namespace waystone
