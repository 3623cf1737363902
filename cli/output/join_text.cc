// SPDX-License-Identifier: Apache-2.0
#include "cli/output/join_text.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include "api/history_json.h"
#include "cli/output/build_text.h"
#include "core/base/text.h"
#include "schema/sessions.h"

namespace waystone {
namespace {

std::string Counted(int count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string NameOfSequence(const MapData& map, SequenceId id) {
  return Printable(std::ranges::find(map.sequences, id, &Sequence::id)->name);
}

// "kitchen (1), hall (2)"
std::string SequencesText(const MapData& map, const std::vector<SequenceId>& ids) {
  std::string text;
  for (const SequenceId id : ids) {
    text += (text.empty() ? "" : ", ") + NameOfSequence(map, id) + " (" + std::to_string(id.value) +
            ")";
  }
  return text;
}

// "12 keyframes, 3 panoramas"
std::string ContentsText(const SessionContents& held) {
  std::string text = Counted(held.keyframes, "keyframe");
  if (held.panoramas > 0) text += ", " + Counted(held.panoramas, "panorama");
  if (held.orientation_frames > 0) {
    text += ", " + Counted(held.orientation_frames, "orientation frame");
  }
  return text;
}

// What a changed map holds now.
Json CountsJson(const std::string& path, const MapData& map) {
  return {{"map", path},
          {"keyframes", map.keyframes.size()},
          {"planes", map.planes.size()},
          {"edges", map.edges.size()},
          {"panoramas", map.appearance ? map.appearance->nodes.size() : 0},
          {"orientation_frames", map.orientation ? map.orientation->frames.size() : 0}};
}

}  // namespace

std::string HistoryText(const MapData& map) {
  const auto parts = FindParts(map);
  std::ostringstream out;
  if (HasHistory(map)) {
    int number = 0;
    for (const MapSession& session : SessionsOf(map)) {
      out << "  session " << ++number << " " << Printable(session.name) << ": "
          << SequencesText(map, session.sequences) << ", " << ContentsText(ContentsOf(map, session))
          << '\n';
    }
  }
  if (parts.size() > 1) {
    out << "  warning   the map has " << parts.size()
        << " parts that have no views in common; add a walk that leads from one to another\n";
    int number = 0;
    for (const auto& part : parts) {
      out << "  part " << ++number << "    " << SequencesText(map, part) << '\n';
    }
  }
  return out.str();
}

std::string JoinText(const std::string& path, const JoinResult& result) {
  std::ostringstream out;
  out << path << ": " << CountsText(result.map) << ", "
      << Counted(result.report.sessions, "session") << '\n'
      << "  joined    " << Counted(result.report.keyframes_recognised, "keyframe")
      << " recognised in another session, " << Counted(result.report.planes_fused, "plane")
      << " fused, " << Counted(result.report.surfaces_joined, "pair")
      << " of planes joined into one surface\n";
  if (result.map.appearance) {
    out << "  joined    " << Counted(result.report.panoramas_recognised, "panorama")
        << " recognised in another session, tied by " << Counted(result.report.loops, "loop")
        << '\n';
  }
  if (result.map.orientation) {
    out << "  joined    " << Counted(result.report.orientation_loops, "loop")
        << " between orientation layers, " << Counted(result.report.sequences_turned, "sequence")
        << " rotated to the building's axes\n";
  }
  if (result.report.features_looked_for > 0) {
    out << "  searched  for " << Counted(result.report.features_looked_for, "feature")
        << " of the map again, and found " << result.report.features_found << '\n';
  }
  for (const std::string& name : result.report.floor_plans) {
    out << "  warning   the floor plan " << Printable(name)
        << " is left out: it is anchored in the frame of another map (waystone plan)\n";
  }
  out << HistoryText(result.map);
  return out.str();
}

std::string RemovalText(const std::string& path, const RemoveResult& result) {
  const RemoveReport& report = result.report;
  std::ostringstream out;
  out << path << ": " << CountsText(result.map) << '\n'
      << "  removed   " << Counted(report.keyframes, "keyframe") << ", "
      << Counted(report.planes, "plane") << ", " << Counted(report.edges, "edge") << ", "
      << Counted(report.sequences, "sequence") << "; " << Counted(report.planes_anchored, "plane")
      << " moved to another reference image\n";
  if (report.panoramas > 0 || report.orientation_frames > 0) {
    out << "  removed   " << Counted(report.panoramas, "panorama") << ", "
        << Counted(report.orientation_frames, "orientation frame") << '\n';
  }
  for (const std::string& name : report.names) {
    out << "  warning   nothing is left of the place " << Printable(name) << '\n';
  }
  for (const std::string& name : report.floor_plans) {
    out << "  warning   no pose is left for the floor plan " << Printable(name) << '\n';
  }
  out << HistoryText(result.map);
  return out.str();
}

std::string PruneText(const std::string& path, const PruneResult& result) {
  const PruneReport& report = result.report;
  std::ostringstream out;
  out << path << ": " << CountsText(result.map) << '\n'
      << "  searched  for " << Counted(report.looked_for, "feature") << " of the map again\n"
      << "  removed   " << Counted(report.plane_features, "feature") << " of planes, "
      << Counted(report.landmarks, "landmark") << ", " << Counted(report.edges, "edge") << '\n';
  for (const MissingSession& session : report.sessions) {
    out << "  not found by " << Printable(session.name) << ": "
        << Counted(session.plane_features, "feature") << " of planes, "
        << Counted(session.landmarks, "landmark") << '\n';
  }
  for (const PrunedPlane& plane : report.planes) {
    out << "  plane " << plane.id.value << " of keyframe " << plane.reference.value << ": "
        << plane.features << " removed, "
        << (plane.left == 0 ? "too few left; the plane is removed"
                            : std::to_string(plane.left) + " left")
        << '\n';
  }
  for (const std::string& name : report.names) {
    out << "  warning   nothing is left of the place " << Printable(name) << '\n';
  }
  out << HistoryText(result.map);
  return out.str();
}

Json PruneJson(const std::string& path, const PruneResult& result) {
  const PruneReport& report = result.report;
  Json json = CountsJson(path, result.map);
  json["looked_for"] = report.looked_for;
  json["removed"] = {{"plane_features", report.plane_features},
                     {"landmarks", report.landmarks},
                     {"edges", report.edges},
                     {"names", report.names}};
  json["not_found_by"] = Json::array();
  for (const MissingSession& session : report.sessions) {
    json["not_found_by"].push_back({{"session", session.name},
                                    {"plane_features", session.plane_features},
                                    {"landmarks", session.landmarks}});
  }
  json["planes_pruned"] = Json::array();
  for (const PrunedPlane& plane : report.planes) {
    json["planes_pruned"].push_back({{"id", plane.id.value},
                                     {"reference", plane.reference.value},
                                     {"removed", plane.features},
                                     {"left", plane.left}});
  }
  json["sessions"] = SessionsJson(result.map);
  json["parts"] = PartsJson(result.map);
  return json;
}

Json RemovalJson(const std::string& path, const RemoveResult& result) {
  Json json = CountsJson(path, result.map);
  json["removed"] = {{"keyframes", result.report.keyframes},
                     {"panoramas", result.report.panoramas},
                     {"orientation_frames", result.report.orientation_frames},
                     {"planes", result.report.planes},
                     {"edges", result.report.edges},
                     {"sequences", result.report.sequences},
                     {"names", result.report.names},
                     {"floor_plans", result.report.floor_plans}};
  json["planes_anchored"] = result.report.planes_anchored;
  json["sessions"] = SessionsJson(result.map);
  json["parts"] = PartsJson(result.map);
  return json;
}

Json JoinJson(const std::string& path, const JoinResult& result) {
  Json json = CountsJson(path, result.map);
  json["keyframes_recognised"] = result.report.keyframes_recognised;
  json["panoramas_recognised"] = result.report.panoramas_recognised;
  json["loops"] = result.report.loops;
  json["orientation_loops"] = result.report.orientation_loops;
  json["sequences_turned"] = result.report.sequences_turned;
  json["planes_fused"] = result.report.planes_fused;
  json["surfaces_joined"] = result.report.surfaces_joined;
  json["features_looked_for"] = result.report.features_looked_for;
  json["features_found"] = result.report.features_found;
  json["floor_plans_left_out"] = result.report.floor_plans;
  json["sessions"] = SessionsJson(result.map);
  json["parts"] = PartsJson(result.map);
  return json;
}

}  // namespace waystone
