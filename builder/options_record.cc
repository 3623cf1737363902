// SPDX-License-Identifier: Apache-2.0
#include "builder/options_record.h"

#include "builder/build_options.h"

namespace waystone {
std::string RecordOptions(const BuildOptions& options) { return RecordFields(options).dump(); }

}  // namespace waystone
