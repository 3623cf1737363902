// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "builder/sources/files.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/camera/camera.h"

// What camera files and rig files have in common: internal to builder/sources. Functions are
// thread-safe, a CameraSection is not.
namespace waystone {

using Names = std::initializer_list<const char*>;

// A mapping in a camera file, whose errors name the file and the key.
class CameraSection {
 public:
  CameraSection(const std::filesystem::path& path, const YAML::Node& node)
      : path_(path), node_(node) {}

  [[noreturn]] void Refuse(const std::string& cause) const {
    throw MapError(ErrorCode::kBadCamera, Quoted(path_) + ": " + cause);
  }

  bool Has(Names names) const { return Find(names).IsDefined(); }

  std::string Text(const char* name) const {
    const YAML::Node value = Find({name});
    return value.IsDefined() && value.IsScalar() ? value.Scalar() : "";
  }

  // The section under a key; refuses when there is none.
  CameraSection Under(const std::string& key) const {
    const YAML::Node& node = node_;
    if (!node.IsMap() || !node[key].IsDefined()) Refuse("the key " + key + " is missing; add it");
    return {path_, node[key]};
  }

  // The sections of a list under a key.
  std::vector<CameraSection> List(const char* key) const {
    const YAML::Node value = Need({key});
    if (!value.IsSequence()) Refuse(std::string(key) + " must be a list");
    std::vector<CameraSection> sections;
    for (const YAML::Node& item : value) sections.emplace_back(path_, item);
    return sections;
  }

  // A matrix as a list of rows.
  std::vector<std::vector<double>> Rows(const char* key, size_t rows, size_t columns) const {
    const std::vector<CameraSection> lists = List(key);
    std::vector<std::vector<double>> numbers;
    for (const CameraSection& list : lists) numbers.push_back(list.Items(key));
    bool sound = numbers.size() == rows;
    for (const std::vector<double>& row : numbers) sound &= row.size() == columns;
    if (!sound) {
      Refuse(std::string(key) + " must be " + std::to_string(rows) + " rows of " +
             std::to_string(columns) + " numbers");
    }
    return numbers;
  }

  // How many keys start with `prefix`.
  int CountPrefixed(const std::string& prefix) const {
    int count = 0;
    for (const auto& item : node_) {
      count += item.first.IsScalar() && item.first.Scalar().starts_with(prefix) ? 1 : 0;
    }
    return count;
  }

  double Number(Names names) const {
    const YAML::Node value = Need(names);
    const auto number = value.IsScalar() ? ToNumber(value.Scalar()) : std::nullopt;
    if (!number) Refuse(std::string(*names.begin()) + " must be a number");
    return *number;
  }

  int Size(Names names) const {
    const double number = Number(names);
    if (number != std::floor(number) || std::abs(number) > INT32_MAX) {
      Refuse(std::string(*names.begin()) + " must be an integer number of pixels");
    }
    return static_cast<int>(number);
  }

  // A list, or a matrix: a mapping with rows, cols and data.
  std::vector<double> Numbers(Names names) const {
    const YAML::Node value = Need(names);
    return CameraSection(path_, value.IsMap() ? value["data"] : value).Items(*names.begin());
  }

  std::vector<double> Numbers(Names names, size_t count) const {
    std::vector<double> numbers = Numbers(names);
    if (numbers.size() != count) {
      Refuse(std::string(*names.begin()) + " has " + std::to_string(numbers.size()) +
             " numbers, not " + std::to_string(count));
    }
    return numbers;
  }

  // "a b c"; "none" where it isn't a mapping.
  std::string Keys() const {
    constexpr size_t kShown = 8;
    if (!node_.IsMap()) return "none";
    std::string keys;
    size_t count = 0;
    for (const auto& item : node_) {
      if (count++ == kShown) return keys + " ...";
      keys += (keys.empty() ? "" : " ") + (item.first.IsScalar() ? item.first.Scalar() : "?");
    }
    return keys;
  }

 private:
  // The numbers of this list, which is the value of a key.
  std::vector<double> Items(const char* key) const {
    if (!node_.IsDefined() || !node_.IsSequence()) {
      Refuse(std::string(key) + " must be a list of numbers");
    }
    std::vector<double> numbers;
    for (const YAML::Node& item : node_) {
      const auto number = item.IsScalar() ? ToNumber(item.Scalar()) : std::nullopt;
      if (!number) {
        Refuse(std::string(key) + " has a value that is not a number at position " +
               std::to_string(numbers.size() + 1));
      }
      numbers.push_back(*number);
    }
    return numbers;
  }

  YAML::Node Find(Names names) const {
    const YAML::Node& node = node_;  // the const operator[] doesn't insert
    if (!node.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
    for (const char* name : names) {
      if (node[name].IsDefined()) return node[name];
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }

  YAML::Node Need(Names names) const {
    YAML::Node value = Find(names);
    if (!value.IsDefined()) {
      Refuse(std::string("the key ") + *names.begin() + " is missing; add it");
    }
    return value;
  }

  std::filesystem::path path_;
  YAML::Node node_;
};

// One camera from its keys, in any of ReadCameraFile's formats except COLMAP's.
Camera ReadCameraSection(const CameraSection& file);

// Opens a YAML file, OpenCV's directives included, whose top is a mapping. Throws
// MapError(kBadCamera) with file and line.
CameraSection OpenCameraYaml(const std::filesystem::path& path);

}  // namespace waystone
