// SPDX-License-Identifier: Apache-2.0
#include "localizer/undecided.h"

namespace waystone {

Answer Undecided(const std::string& stage) {
  Answer answer;
  answer.verdict = Verdict::kUndecided;
  answer.decided_by = "deadline";
  answer.stage = stage;
  answer.message = "the deadline passed after the stage '" + stage + "'; ask with a later one";
  return answer;
}

}  // namespace waystone
