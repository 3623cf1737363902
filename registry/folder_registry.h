// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "registry/registry.h"

namespace waystone {

// A registry in a folder, by OpenRegistry: inside registry only. The folder may be shared by
// several machines:
//   registry.json          {"format": "waystone-registry", "version", "id", "store"}
//   current/NAME.json      {"retired", "version": the manifest}: replaced as a whole
//   versions/NAME/N.json   the manifests: written once
//   files/                 the store, where no other was given
//   lock                   locked (flock) by who changes anything
std::unique_ptr<Registry> OpenFolderRegistry(const std::filesystem::path& folder,
                                             const std::optional<NewRegistry>& create);

}  // namespace waystone
