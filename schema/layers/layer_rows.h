// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>

#include <optional>
#include <vector>

#include "schema/file/map_store.h"
#include "schema/layers/appearance/appearance_layer.h"
#include "schema/layers/orientation/orientation_layer.h"

// The tables of the layers beside the planes. Reading adds what is wrong to `problems`, row by row;
// writing throws SQLite::Exception.
namespace waystone {

// Nothing when the table of the layer has no row. Descriptors are of `type`.
std::optional<AppearanceLayer> ReadAppearance(SQLite::Database& database, FeatureType type,
                                              const ReadOptions& options,
                                              std::vector<MapProblem>& problems);
std::optional<OrientationLayer> ReadOrientation(SQLite::Database& database,
                                                const ReadOptions& options,
                                                std::vector<MapProblem>& problems);

void WriteAppearance(const AppearanceLayer& layer, SQLite::Database& database);
void WriteOrientation(const OrientationLayer& layer, SQLite::Database& database);

}  // namespace waystone
