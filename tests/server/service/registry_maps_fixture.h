// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "registry/store.h"
#include "schema/file/map_store.h"
#include "server/service/registry_maps.h"
#include "tests/registry/test_folder.h"
#include "tests/server/service/made_map.h"

namespace waystone {

// A registry with made maps, and the maps of it as a server holds them.
class RegistryMapsTest : public testing::Test {
 protected:
  static constexpr double kPollS = 0.05;
  static constexpr int kPatienceS = 20;

  RegistryMapsTest() {
    options_.registry = (folder_ / "registry").string();
    options_.cache = folder_ / "cache";
    options_.poll_s = kPollS;
    registry_ = OpenRegistry(options_.registry, NewRegistry{(folder_ / "store").string()});
  }

  // Puts a map of that many planes into the store.
  MapVersion Prepare(const std::string& name, int planes) {
    MapData map = MadeMap(planes);
    map.edges.clear();  // their homologies are made up
    const std::filesystem::path file = folder_ / "made.db";
    WriteMap(map, file, {.overwrite = true});
    const auto index = MapIndex::Build(ReadMap(file));
    MapVersion version =
        MakeVersion(name, *index, static_cast<int64_t>(std::filesystem::file_size(file)), {});
    OpenStore(registry_->store())->Put(file, version.sha256, version.bytes);
    return version;
  }
  MapVersion Publish(const std::string& name, int planes) {
    return registry_->Publish(Prepare(name, planes));
  }
  std::filesystem::path Stored(const MapVersion& version) const {
    return folder_.path() / "store" / StorePath(version.sha256);
  }

  void Start() {
    maps_.reset();
    maps_ = std::make_unique<RegistryMaps>(options_, [this](const std::string& line) {
      const std::lock_guard lock(mutex_);
      log_ += line + "\n";
    });
  }
  std::string log() {
    const std::lock_guard lock(mutex_);
    return log_;
  }
  size_t Planes(const std::string& name) {
    return maps_->Find(name, std::nullopt)->index().map().planes.size();
  }
  std::string Failure(const std::string& name, ErrorCode code = ErrorCode::kNotReady) {
    try {
      maps_->Find(name, std::nullopt);
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      return error.what();
    }
    ADD_FAILURE() << name << " was found";
    return "";
  }
  RegistryHoldings Held() { return maps_->holdings().registry.value(); }

  bool HasLogged(const std::string& text) { return log().find(text) != std::string::npos; }
  template <class Holds>
  bool Until(const Holds& holds) {
    for (int i = 0; i < 100 * kPatienceS && !holds(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return holds();
  }

  TestFolder folder_;
  RegistryMapsOptions options_;
  std::unique_ptr<Registry> registry_;
  std::mutex mutex_;
  std::string log_;
  std::unique_ptr<RegistryMaps> maps_;
};

}  // namespace waystone
