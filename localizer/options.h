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

// How a query is answered: the options of the layers, and what is known about this query.
struct LocalizeOptions {
  DecodeLimits limits;
  PlaneQueryOptions planes;
  PanoramaQueryOptions panorama;
  BuildingOptions building;
  // Only used on maps with poses; maps don't record it.
  PoseQueryOptions pose;

  // With it a panorama is answered as the next one of a series, without it by itself.
  std::optional<SeriesContext> series;
  // The camera of a perspective photo, where it is known: a map of panoramas needs it to answer, as
  // do the photo's rotation in the building and its pose.
  std::optional<Camera> camera;
  // Explain in the answer what became of every shortlisted plane. Changes nothing else; makes the
  // answer some 50 KB larger.
  bool explain = false;
  // Checked between stages, between planes and between panoramas; once it has passed, the verdict
  // is kUndecided. Only with a deadline do answers depend on the machine's speed.
  Deadline deadline;
  // Receives each finished stage (of several images, those of the current one), for callers that
  // stop waiting at the deadline. Any thread may read it. May be null.
  std::shared_ptr<std::atomic<Stage>> finished;

  // Limits of decoding, and what is known about one query: a map doesn't depend on them.
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
