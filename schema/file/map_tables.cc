// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_tables.h"

#include "schema/layers/appearance/appearance_tables.h"
#include "schema/layers/orientation/orientation_tables.h"
#include "schema/layers/planes/plane_tables.h"

namespace waystone {

const std::vector<TableView>& AllTables() {
  static const std::vector<TableView> tables{kMapTable,
                                             kSequencesTable,
                                             kKeyframesTable,
                                             kKeyframeImagesTable,
                                             kPlanesTable,
                                             kPlaneFeaturesTable,
                                             kPlaneViewsTable,
                                             kEdgesTable,
                                             kSearchIndexTable,
                                             kVerdictModelTable,
                                             kAppearanceLayerTable,
                                             kAppearanceNodesTable,
                                             kAppearanceSignaturesTable,
                                             kAppearanceFeaturesTable,
                                             kAppearanceImagesTable,
                                             kAppearanceEdgesTable,
                                             kAppearanceVerdictTable,
                                             kAppearanceVerdictTermsTable,
                                             kOrientationLayerTable,
                                             kOrientationFramesTable,
                                             kOrientationTurnsTable,
                                             kOrientationNodesTable,
                                             kOrientationImagesTable,
                                             kOrientationEdgesTable,
                                             kCorridorsTable,
                                             kContentsTable};
  return tables;
}

}  // namespace waystone
