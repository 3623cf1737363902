// SPDX-License-Identifier: Apache-2.0
#include "localizer/undecided.h"

namespace waystone {

Answer Undecided(const std::string& stage) {
  Answer answer;
  answer.verdict = Verdict::kUndecided;
  answer.decided_by = "deadline";
  answer.stage = stage;
  answer.message = "the deadline expired after stage '" + stage + "'; use a longer deadline";
  return answer;
}

}  // namespace waystone
