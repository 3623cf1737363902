// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>

#include <optional>
#include <vector>

#include "schema/map_data.h"
#include "schema/tables/map_problem.h"
#include "schema/tables/table_writer.h"

// The tables of the layers. Reading adds what is wrong to `problems`, row by row, and reads
// pictures if `images`; writing throws SQLite::Exception. All functions are thread-safe for
// different databases and sinks.
namespace waystone {

// Fills the plane layer's part of `map`, whose info.feature_type has already been read.
void ReadPlaneLayer(SQLite::Database& database, bool images, MapData& map,
                    std::vector<MapProblem>& problems);
// Nothing when the table of the layer has no row. Descriptors are of `type`.
std::optional<AppearanceLayer> ReadAppearance(SQLite::Database& database, FeatureType type,
                                              bool images, std::vector<MapProblem>& problems);
std::optional<OrientationLayer> ReadOrientation(SQLite::Database& database, bool images,
                                                std::vector<MapProblem>& problems);
std::optional<PoseLayer> ReadPoses(SQLite::Database& database, std::vector<MapProblem>& problems);
// Adds the panoramas' part of the pose layer, which has already been read, where the map has tables
// of it.
void ReadNodePoses(SQLite::Database& database, std::optional<PoseLayer>& poses,
                   std::vector<MapProblem>& problems);
// Nothing where the map has no table of them.
std::vector<KeyframeLink> ReadLinks(SQLite::Database& database, std::vector<MapProblem>& problems);
// The same for these.
Looks ReadLooks(SQLite::Database& database, std::vector<MapProblem>& problems);
std::vector<NamedPlace> ReadNames(SQLite::Database& database, std::vector<MapProblem>& problems);
std::vector<FloorPlanImage> ReadFloorPlans(SQLite::Database& database, bool images,
                                           std::vector<MapProblem>& problems);

void WritePlaneLayer(const MapData& map, RowSink& sink);
void WriteAppearance(const AppearanceLayer& layer, RowSink& sink);
void WriteOrientation(const OrientationLayer& layer, RowSink& sink);
void WritePoses(const PoseLayer& layer, RowSink& sink);
// These make the tables that they fill.
void WriteNodePoses(const PoseLayer& layer, RowSink& sink);
void WriteLinks(const std::vector<KeyframeLink>& links, RowSink& sink);
void WriteLooks(const Looks& looks, RowSink& sink);
void WriteNames(const std::vector<NamedPlace>& places, RowSink& sink);
void WriteFloorPlans(const std::vector<FloorPlanImage>& plans, RowSink& sink);

}  // namespace waystone
