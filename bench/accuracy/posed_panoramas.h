// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "builder/build_options.h"

namespace waystone::bench {

// Made flats, each a map of its own, built with the true poses of three quarters of its panoramas
// and queried with the others; and the same with maps built without poses, whose frame is aligned
// to the truth.
nlohmann::ordered_json MeasurePosedFlats(uint64_t first_seed, int flats,
                                         const BuildOptions& options);

// The same for a folder of panoramas with poses (ReadPlaces).
nlohmann::ordered_json MeasurePosedPlaces(const std::filesystem::path& folder,
                                          const BuildOptions& options);

}  // namespace waystone::bench
