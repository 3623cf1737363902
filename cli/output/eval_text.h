// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "api/json.h"
#include "quality/evaluation.h"

namespace waystone {

// An evaluation as tables for people, and as JSON, whose fields docs/evaluation.md lists.
std::string EvaluationText(const Evaluation& evaluation);
Json EvaluationJson(const Evaluation& evaluation);

// The false answers: localized at another place, or although they aren't in the map.
std::string MistakesText(const MapIndex& index, const std::vector<ScoredQuery>& queries);
// Every query that wasn't answered as it should be: false, missed or unsure.
Json FailuresJson(const MapIndex& index, const std::vector<ScoredQuery>& queries);

}  // namespace waystone
