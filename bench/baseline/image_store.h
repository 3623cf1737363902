// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "bench/baseline/image_graph.h"

namespace waystone::bench {

// Writes an image graph as an SQLite file with the tables, blob encodings and page size that a map
// has for the same things, without pictures, so that sizes compare. Replaces a file that is there.
// Throws MapError(kFileUnwritable).
void WriteImageGraph(const ImageGraph& graph, const std::filesystem::path& path);

// Throws MapError(kMapDamaged) for a file that it can't read.
ImageGraph ReadImageGraph(const std::filesystem::path& path);

}  // namespace waystone::bench
