// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "registry/registry.h"

namespace waystone {

// A registry in a folder, opened by OpenRegistry. Internal to registry. Several machines may share
// the folder:
//   registry.json          {"format": "waystone-registry", "version", "id", "store"}
//   current/NAME.json      {"retired", "version": the manifest}: replaced as a whole
//   versions/NAME/N.json   the manifests: written once
//   files/                 the store, unless another one was given
//   lock                   locked (flock) by whoever changes anything
// Throws as OpenRegistry does.
std::unique_ptr<Registry> OpenFolderRegistry(const std::filesystem::path& folder,
                                             const std::optional<NewRegistry>& create);

}  // namespace waystone
