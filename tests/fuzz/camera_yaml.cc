// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/camera_yaml.h"

#include <array>
#include <charconv>
#include <sstream>

namespace waystone {

std::string ExactText(double number) {
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  return {text.data(), end};
}

std::string CameraYaml(const Camera& camera, const std::string& indent) {
  std::string yaml = indent + "camera_model: " + std::string(NameOf(camera.model)) + "\n" + indent +
                     "image_width: " + std::to_string(camera.width) + "\n" + indent +
                     "image_height: " + std::to_string(camera.height) + "\n";
  std::istringstream names{std::string(ParameterNames(camera.model))};
  size_t i = 0;
  for (std::string name; names >> name; ++i) {
    yaml += indent + name + ": " + ExactText(camera.params[i]) + "\n";
  }
  return yaml;
}

}  // namespace waystone
