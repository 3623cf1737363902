// SPDX-License-Identifier: Apache-2.0
#include "cli/output/answer_text.h"

#include <cmath>
#include <cstdio>

#include "core/base/text.h"
#include "core/geometry/angle.h"

namespace waystone {
namespace {

// The part of an answer that the path names; null where something is missing.
Json At(const Json& json, std::initializer_list<const char*> path) {
  const Json* at = &json;
  for (const char* name : path) {
    if (!at->is_object() || !at->contains(name)) return nullptr;
    at = &(*at)[name];
  }
  return *at;
}

std::string TextAt(const Json& json, std::initializer_list<const char*> path) {
  const Json value = At(json, path);
  return value.is_string() ? value.get<std::string>() : "";
}

double NumberAt(const Json& json, std::initializer_list<const char*> path) {
  const Json value = At(json, path);
  return value.is_number() ? value.get<double>() : 0;
}

// " in Kitchen near 7.jpg at (1.20, -3.45), heading 31 deg"; the heading only with a position.
std::string Where(const Json& answer) {
  const std::string name = TextAt(answer, {"place", "name"});
  const std::string image = TextAt(answer, {"place", "image"});
  std::string line = name.empty() ? "" : " in " + name;
  if (!image.empty()) line += " near " + image;
  if (!At(answer, {"place", "position"}).is_object()) return line;
  char text[100];
  (void)std::snprintf(text, sizeof text, " at (%.2f, %.2f)",
                      NumberAt(answer, {"place", "position", "x"}),
                      NumberAt(answer, {"place", "position", "y"}));
  line += text;
  if (At(answer, {"place", "heading"}).is_object()) {
    (void)std::snprintf(text, sizeof text, ", heading %.0f deg",
                        NumberAt(answer, {"place", "heading", "rad"}) * kDegreesPerRadian);
    line += text;
  }
  return line;
}

// ", pose (1.203, -0.441, 0.310) m in map": metres where the frame's unit is known.
std::string PoseText(const Json& answer) {
  const Json at = At(answer, {"pose", "position"});
  if (!at.is_array() || at.size() != 3) return "";
  for (const Json& one : at) {
    if (!one.is_number()) return "";
  }
  char text[100];
  (void)std::snprintf(text, sizeof text, ", pose (%.3f, %.3f, %.3f)%s in ", at[0].get<double>(),
                      at[1].get<double>(), at[2].get<double>(),
                      TextAt(answer, {"pose", "unit"}) == "metres" ? " m" : "");
  return text + TextAt(answer, {"pose", "frame"});
}

// ", at (512, 88) of the plan Ground floor": pixels.
std::string PlanText(const Json& answer) {
  const std::string name = TextAt(answer, {"place", "plan", "name"});
  if (name.empty()) return "";
  char text[100];
  (void)std::snprintf(text, sizeof text, ", at (%.0f, %.0f) of the plan ",
                      NumberAt(answer, {"place", "plan", "x"}),
                      NumberAt(answer, {"place", "plan", "y"}));
  return text + name;
}

std::string UnescapedLine(const Json& answer) {
  const std::string verdict = TextAt(answer, {"verdict"});
  const std::string time =
      std::to_string(std::lround(NumberAt(answer, {"timing_ms", "total"}))) + " ms";
  std::string line = TextAt(answer, {"image"}) + ": " + verdict;
  if (verdict != "localized") {
    const std::string message = TextAt(answer, {"message"});
    return line + (message.empty() ? "" : ": " + message) + " (" + time + ")";
  }
  line += Where(answer) + PoseText(answer) + PlanText(answer) + " (";
  const Json planes = At(answer, {"planes"});
  if (planes.is_array() && !planes.empty()) {
    line += "plane " + std::to_string(std::lround(NumberAt(planes[0], {"id"}))) + ", " +
            std::to_string(std::lround(NumberAt(planes[0], {"inliers"}))) + " inliers, ";
  } else if (At(answer, {"epipolar"}).is_object()) {
    line += std::to_string(std::lround(NumberAt(answer, {"epipolar", "inliers"}))) +
            " epipolar inliers, ";
  }
  return line + time + ")";
}

// " (2 of 5 maps weren't searched: hall too_large, lab failed)": of a query of all maps.
std::string UnsearchedText(const Json& answer) {
  constexpr int kMostNamed = 5;
  const Json searched = At(answer, {"searched"});
  if (At(answer, {"partial"}) != true || !searched.is_array()) return "";
  if (searched.empty()) return " (no map was searched)";
  int count = 0;
  std::string names;
  for (const Json& map : searched) {
    const std::string state = TextAt(map, {"state"});
    if (state.empty() || state == "asked" || ++count > kMostNamed) continue;
    names += (names.empty() ? "" : ", ") + TextAt(map, {"map"}) + " " + state;
  }
  if (count == 0) return "";
  if (count > kMostNamed) names += ", ...";
  return " (" + std::to_string(count) + " of " + std::to_string(searched.size()) +
         (searched.size() == 1 ? " map " : " maps ") + (count == 1 ? "wasn't" : "weren't") +
         " searched: " + names + ")";
}

}  // namespace

std::string AnswerLine(const Json& answer) {
  return Printable(UnescapedLine(answer) + UnsearchedText(answer));
}

}  // namespace waystone
