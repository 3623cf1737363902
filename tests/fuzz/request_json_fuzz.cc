// SPDX-License-Identifier: Apache-2.0
#include "api/query_request_json.h"

#include <cmath>

#include "tests/fuzz/fuzz_targets.h"

namespace waystone {

// A request is written and read to the same.
bool FuzzRequestJson(FuzzInput input) {
  const auto object = ReadOrRefuse([&] { return ParseJson(TextOf(input)); });
  if (!object) return false;
  const auto request = ReadOrRefuse([&] { return ParseQueryRequest(*object, {}); });
  if (!request) return false;
  Json written = ToJson(*request);
  const QueryRequest read = ReadBack([&] { return ParseQueryRequest(written, {}); }, Dump(written));
  Json again = ToJson(read);
  if (request->fov_rad) {  // in degrees there, rounded
    Require(std::abs(*read.fov_rad - *request->fov_rad) < 1e-12, "a field of view stays the same");
    written.erase("fov_deg");
    again.erase("fov_deg");
  }
  Require(Dump(again) == Dump(written), "a request is written and read to the same");
  return true;
}

}  // namespace waystone
