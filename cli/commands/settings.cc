// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/settings.h"

#include <set>
#include <sstream>
#include <type_traits>

#include "core/base/error.h"
#include "core/base/option_text.h"
#include "core/base/options.h"
#include "core/features/features.h"
#include "core/manhattan/segments.h"

namespace waystone {
namespace {

// A field as the documentation shows it.
struct OptionLine {
  std::string name;
  std::string value;  // the default
  std::string range;
  std::string unit;
  std::string help;
  OptionUse use = OptionUse::kTunable;
};

template <class Options>
std::vector<OptionLine> CollectLines() {
  std::vector<OptionLine> lines;
  const Options defaults;
  VisitFields("", defaults, [&](const std::string& name, const auto& field, const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    OptionLine line{
        name, ToOptionText(value), "", std::string(field.unit), std::string(field.help), field.use};
    if constexpr (std::is_same_v<Value, bool>) {
      line.range = "true or false";
    } else if constexpr (std::is_arithmetic_v<Value>) {
      line.range = ToText(field.range);
    }
    lines.push_back(std::move(line));
  });
  return lines;
}

template <class Options>
void SetOptions(const std::vector<std::string>& settings, Options& options) {
  std::set<std::string> set;
  for (const std::string& setting : settings) {
    const size_t equals = setting.find('=');
    if (equals == std::string::npos) {
      throw MapError(ErrorCode::kUsage,
                     "--set " + setting + ": write NAME=VALUE; `waystone options` lists the names");
    }
    const std::string name = setting.substr(0, equals);
    if (!set.insert(name).second) {
      throw MapError(ErrorCode::kUsage, "--set " + name + " is given twice; give it once");
    }
    if (SetField("", options, name, setting.substr(equals + 1))) continue;
    std::vector<std::string> names;
    for (const OptionLine& line : CollectLines<Options>()) names.push_back(line.name);
    const std::string nearest = NearestName(name, names);
    const std::string question = nearest.empty() ? "" : "did you mean '" + nearest + "'? ";
    throw MapError(ErrorCode::kUsage, "there is no option '" + name + "'; " + question +
                                          "`waystone options` lists all");
  }
}

std::string EscapeCell(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
  return escaped;
}

// "planes" of "planes.fusion.min_votes"; empty for an option of no group.
std::string TopGroup(const std::string& name) {
  const size_t dot = name.find('.');
  return dot == std::string::npos ? "" : name.substr(0, dot);
}

// A table for each top-level group.
void WriteTables(const std::vector<OptionLine>& lines, OptionUse use, std::ostream& out) {
  std::string group = "none yet";
  for (const OptionLine& line : lines) {
    if (line.use != use) continue;
    if (TopGroup(line.name) != group) {
      group = TopGroup(line.name);
      if (!group.empty()) out << "\n#### " << group << '\n';
      out << "\n| option | default | range | meaning |\n|---|---|---|---|\n";
    }
    const std::string unit = line.unit.empty() ? "" : " " + line.unit;
    out << "| `" << line.name << "` | " << EscapeCell(line.value) << unit << " | " << line.range
        << " | " << EscapeCell(line.help) << " |\n";
  }
}

template <class Options>
void WriteProgram(const std::string& title, std::ostream& out) {
  const std::vector<OptionLine> lines = CollectLines<Options>();
  out << "\n## " << title << "\n\n### Tunables\n";
  WriteTables(lines, OptionUse::kTunable, out);
  out << "\n### Internal\n\nMeasured once for all data; leave them.\n";
  WriteTables(lines, OptionUse::kInternal, out);
}

template <class Options>
void WriteLines(const std::string& title, std::ostream& out) {
  out << title << ":\n";
  for (const OptionLine& line : CollectLines<Options>()) {
    out << "  " << line.name << " = " << line.value << (line.unit.empty() ? "" : " " + line.unit)
        << (line.range.empty() ? "" : " (" + line.range + ")")
        << (line.use == OptionUse::kInternal ? " [internal]" : "") << ": " << line.help << '\n';
  }
}

}  // namespace

void ApplySettings(const std::vector<std::string>& settings, BuildOptions& options) {
  SetOptions(settings, options);
}

void ApplySettings(const std::vector<std::string>& settings, LocalizeOptions& options) {
  SetOptions(settings, options);
}

std::string OptionsMarkdown() {
  std::ostringstream out;
  out << "# Options\n\n"
         "`--set NAME=VALUE` changes these, as often as needed. A map records all that it was "
         "built with\n(`waystone info --json`). Written by `waystone options --markdown`.\n";
  WriteProgram<BuildOptions>("waystone build", out);
  WriteProgram<LocalizeOptions>("waystone localize, waystone serve", out);
  return out.str();
}

std::string OptionsText() {
  std::ostringstream out;
  WriteLines<BuildOptions>("waystone build --set", out);
  WriteLines<LocalizeOptions>("waystone localize --set, waystone serve --set", out);
  return out.str();
}

}  // namespace waystone
