// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "builder/build_map.h"
#include "localizer/options.h"

// Options by their full names: what --set changes, and their documentation.
namespace waystone {

// Sets options, each given as "planes.fusion.min_votes=6". Ranges are left to Check(). Throws
// MapError(kUsage) for a name that is given twice, or that no option has, suggesting the nearest
// one, and kBadOptions for a value that isn't of the option's type.
void ApplySettings(const std::vector<std::string>& settings, BuildOptions& options);
void ApplySettings(const std::vector<std::string>& settings, LocalizeOptions& options);

// docs/options.md: every option that --set of `build`, `localize` and `serve` changes, with its
// default, range and meaning; those that nobody should have to touch come last.
std::string OptionsMarkdown();
// The same as plain lines: "planes.fusion.min_votes = 5 (at least 1): ...".
std::string OptionsText();

}  // namespace waystone
