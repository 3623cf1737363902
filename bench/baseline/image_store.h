// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "bench/baseline/image_graph.h"

namespace waystone::bench {

// Writes an image graph as an SQLite file with the tables, blob encodings and page size that a map
// uses for the same things, without pictures, so that sizes are comparable. Replaces an existing
// file. Throws MapError(kFileUnwritable).
void WriteImageGraph(const ImageGraph& graph, const std::filesystem::path& path);

// Throws MapError(kMapDamaged) for a file that can't be read.
ImageGraph ReadImageGraph(const std::filesystem::path& path);

}  // namespace waystone::bench
