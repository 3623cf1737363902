// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "core/base/options.h"
#include "core/camera/camera.h"
#include "core/image/decode.h"
#include "localizer/appearance/panorama_query_options.h"
#include "localizer/appearance/panorama_series.h"
#include "localizer/orientation/building_options.h"
#include "localizer/planes/plane_query_options.h"
#include "localizer/poses/pose_query_options.h"
#include "localizer/verdict/answer.h"
#include "localizer/verdict/deadline.h"

namespace waystone {

// How a query is answered: the options of the layers, and what is known of this query.
struct LocalizeOptions {
  DecodeLimits limits;
  PlaneQueryOptions planes;
  PanoramaQueryOptions panorama;
  BuildingOptions building;
  // Used on maps with poses alone: the record of one without has nothing of it.
  PoseQueryOptions pose;

  // A panorama is answered as the next one of a series with it, and by itself without.
  std::optional<SeriesContext> series;
  // The camera of a perspective photo, where it is known: what a map of panoramas answers it by,
  // and what its rotation in the building and its pose take.
  std::optional<Camera> camera;
  // Say in the answer what became of every shortlisted plane. Changes nothing else; makes the
  // answer some 50 KB larger.
  bool explain = false;
  // It is looked at between stages, between planes and between panoramas; the verdict is kUndecided
  // from then on. An answer depends on the machine's speed with it, and not without.
  Deadline deadline;
  // Is told each stage that was finished, for whoever stops waiting at the deadline; of several
  // images the one at hand. May be null.
  std::shared_ptr<std::atomic<Stage>> finished;

  // Limits of decoding, and what is known of one query: a map doesn't depend on them.
  static constexpr int kUnlistedMembers = 7;
  static constexpr auto Fields(const auto& use) {
    return use(OptionGroup{"planes", &LocalizeOptions::planes},
               OptionGroup{"panorama", &LocalizeOptions::panorama},
               OptionGroup{"building", &LocalizeOptions::building});
  }
  void Check() const;  // throws MapError(kBadOptions)

  // Whether there is a deadline and it has passed.
  bool TooLate() const { return HasPassed(deadline); }
  void Finish(Stage stage) const {
    if (finished) *finished = stage;
  }
};

}  // namespace waystone
