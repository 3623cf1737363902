// SPDX-License-Identifier: Apache-2.0
#include "server/service/map_service.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "api/audit_text.h"
#include "api/floor_plans_json.h"
#include "api/graph_formats.h"
#include "api/layer_json.h"
#include "api/lines_json.h"
#include "api/map_json.h"
#include "api/names_file.h"
#include "api/overview_json.h"
#include "api/pose_layer_json.h"
#include "api/space_json.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/image/encode.h"
#include "server/http/paging.h"
#include "server/http/responses.h"
#include "server/service/home_page.h"
#include "server/service/openapi.h"
#include "server/service/shrink_image.h"
#include "server/service/web_page.h"

namespace waystone {
namespace {

// Widths of images, px.
constexpr int kMaxImageWidth = 4096;
constexpr int kThumbnailWidth = 160;

// The id in the path. Anything but a number is the id of nothing.
int64_t IdIn(const Router::Captures& captures, const std::string& kind) {
  const std::string& text = captures.at("id");
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw MapError(ErrorCode::kNotFound, "no " + kind + " '" + Printable(text.substr(0, 40)) +
                                             "' in this map; ids are positive integers");
  }
  return value;
}

template <class T>
const T& Existing(const T* found, const std::string& kind, int64_t id) {
  if (!found) {
    throw MapError(ErrorCode::kNotFound, "no " + kind + " " + std::to_string(id) + " in this map");
  }
  return *found;
}

const Keyframe& KeyframeOf(const MapIndex& index, const Router::Captures& captures) {
  const int64_t id = IdIn(captures, "keyframe");
  return Existing(index.FindKeyframe(KeyframeId{id}), "keyframe", id);
}

const Plane& PlaneOf(const MapIndex& index, const Router::Captures& captures) {
  const int64_t id = IdIn(captures, "plane");
  return Existing(index.FindPlane(PlaneId{id}), "plane", id);
}

int WidthIn(const HttpRequest& request) {
  const std::string text = ParameterOf(request, "width", "0");
  int width = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), width);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (whole && width >= 0 && width <= kMaxImageWidth) return width;
  throw MapError(ErrorCode::kBadRequest,
                 "width '" + Printable(text.substr(0, 40)) +
                     "' is invalid; it must be between 0 (stored size) and " +
                     std::to_string(kMaxImageWidth));
}

HttpResponse PictureResponse(const std::vector<uint8_t>& picture) {
  return {200, MediaTypeOf(picture), std::string(picture.begin(), picture.end()), {}};
}

// The picture of `of`, at most `width` px wide; 0 for its stored size.
template <class Pictured>
HttpResponse ImageResponse(const Pictured& of, int width, QueryGate& gate) {
  if (of.picture.empty()) {
    throw MapError(ErrorCode::kNotFound,
                   "this map stores no images; rebuild it without --no-images");
  }
  if (width == 0 || !IsWider(of.picture, width)) return PictureResponse(of.picture);
  const QueryGate::Turn turn = gate.Enter();  // it decodes
  return PictureResponse(ShrunkPicture(of.picture, width));
}

// The image of the plan that the request names, or of the first one.
HttpResponse PlanImageResponse(const HttpRequest& request, const MapData& map) {
  const std::string name = ParameterOf(request, "name", "");
  const auto plan = std::ranges::find_if(map.floor_plans, [&name](const FloorPlanImage& one) {
    return name.empty() || one.name == name;
  });
  if (plan == map.floor_plans.end()) {
    throw MapError(
        ErrorCode::kNotFound,
        (name.empty() ? "this map has no floor plan"
                      : "no floor plan '" + Printable(name.substr(0, 40)) + "' in this map") +
            std::string("; /plan lists the plans"));
  }
  return {200, MediaTypeOf(plan->image), std::string(plan->image.begin(), plan->image.end()), {}};
}

// The node of a layer that the path names.
template <class Layer>
const auto& FindNode(const Layer& layer, const Router::Captures& captures) {
  const int64_t id = IdIn(captures, "node");
  const auto it = std::find_if(layer.nodes.begin(), layer.nodes.end(),
                               [id](const auto& node) { return IdOf(node).value == id; });
  return Existing(it == layer.nodes.end() ? nullptr : &*it, "node", id);
}

}  // namespace

void MapService::AddTo(Router& router) {
  AddWebPage(router);
  router.Add("GET", "/plain", [this](const auto& request, const auto&) { return Home(request); });
  router.Add("GET", "/v1/maps",
             [this](const auto& request, const auto&) { return ListMaps(request); });
  AddLists(router);
  AddSingles(router);
  AddAppearance(router);
  AddOrientation(router);
}

// What these show changes only with the map's version or the program's.
void MapService::AddShow(Router& router, const std::string& pattern, Show show) {
  router.Add("GET", "/v1/maps/{map}" + pattern,
             [this, show = std::move(show)](const HttpRequest& request, const Captures& captures) {
               const MapSource::MapPtr map = maps_.Find(captures.at("map"), std::nullopt);
               const std::string etag = "\"" + map->version() + "-" + kVersion + "\"";
               // The answer comes first: a 304 for something that isn't there would be wrong.
               HttpResponse response = show(request, *map, captures);
               if (IsKnown(request, etag)) response = {304, "", "", {}};
               response.headers.emplace_back("ETag", etag);
               response.headers.emplace_back("Cache-Control", "no-cache");
               return response;
             });
}

void MapService::AddLists(Router& router) {
  AddShow(router, "/planes", [](const auto& request, const ServedMap& map, const auto&) {
    const std::vector<Plane>& planes = map.index().map().planes;
    return JsonResponse(PagedJson(request, "planes", planes.size(), [&](size_t i) {
      return PlaneSummaryJson(map.index(), planes[i]);
    }));
  });
  AddShow(
      router, "/planes/{id}/features",
      [](const auto& request, const ServedMap& map, const Captures& in) {
        const Plane& plane = PlaneOf(map.index(), in);
        return JsonResponse(PagedJson(request, "features", plane.features.size(),
                                      [&](size_t i) { return FeatureJson(plane.features[i]); }));
      });
  AddShow(router, "/planes/{id}/views",
          [](const auto& request, const ServedMap& map, const Captures& in) {
            const Plane& plane = PlaneOf(map.index(), in);
            return JsonResponse(PagedJson(request, "views", plane.views.size(),
                                          [&](size_t i) { return ViewJson(plane.views[i]); }));
          });
  AddShow(router, "/keyframes", [](const auto& request, const ServedMap& map, const auto&) {
    const std::vector<Keyframe>& keyframes = map.index().map().keyframes;
    const KeyframeRows rows(map.name(), map.index());
    return JsonResponse(PagedJson(request, "keyframes", keyframes.size(),
                                  [&](size_t i) { return rows.Row(keyframes[i]); }));
  });
}

void MapService::AddSingles(Router& router) {
  AddShow(router, "", [](const auto&, const ServedMap& map, const auto&) {
    return JsonResponse(map.summary());
  });
  AddShow(router, "/planes/{id}", [](const auto&, const ServedMap& map, const Captures& in) {
    return JsonResponse(PlaneJson(map.index(), PlaneOf(map.index(), in)));
  });
  AddShow(router, "/graph", [](const auto& request, const ServedMap& map, const auto&) {
    const std::string format = ParameterOf(request, "format", "json");
    if (format == "json") return JsonResponse(GraphJson(map.index()));
    const GraphText text = FormatGraph(map.index(), format);
    return HttpResponse{200, text.media_type, text.text, {}};
  });
  AddShow(router, "/overview", [](const auto&, const ServedMap& map, const auto&) {
    return JsonResponse(OverviewJson(map.index()));
  });
  AddShow(router, "/names", [](const auto&, const ServedMap& map, const auto&) {
    return JsonResponse(NamesFileJson(map.name(), map.index().map()));
  });
  AddShow(router, "/plan", [](const auto&, const ServedMap& map, const auto&) {
    return JsonResponse(FloorPlansJson(map.name(), map.index().map()));
  });
  AddShow(router, "/plan/image", [](const auto& request, const ServedMap& map, const auto&) {
    return PlanImageResponse(request, map.index().map());
  });
  AddShow(router, "/poses", [](const auto&, const ServedMap& map, const auto&) {
    return JsonResponse(PoseLayerJson(map.index(), PosesOf(map.index())));
  });
  AddShow(router, "/audit", [this](const auto&, const ServedMap& map, const auto&) {
    return JsonResponse(AuditJson(map.index(), map.Audit(gate_)));
  });
  AddShow(router, "/keyframes/{id}", [](const auto&, const ServedMap& map, const Captures& in) {
    return JsonResponse(KeyframeJson(map.name(), map.index(), KeyframeOf(map.index(), in)));
  });
  AddShow(router, "/keyframes/{id}/image",
          [this](const auto& request, const ServedMap& map, const Captures& in) {
            return ImageResponse(KeyframeOf(map.index(), in), WidthIn(request), gate_);
          });
  AddShow(router, "/keyframes/{id}/lines",
          [this](const auto&, const ServedMap& map, const Captures& in) {
            const Keyframe& keyframe = KeyframeOf(map.index(), in);
            const QueryGate::Turn turn = gate_.Enter();  // it computes
            return JsonResponse(LinesJson(map.index(), keyframe));
          });
  AddShow(router, "/keyframes/{id}/space",
          [this](const auto&, const ServedMap& map, const Captures& in) {
            const Keyframe& keyframe = KeyframeOf(map.index(), in);
            const QueryGate::Turn turn = gate_.Enter();  // it computes
            return JsonResponse(SpaceJson(map.index(), keyframe));
          });
  AddShow(router, "/keyframes/{id}/thumbnail",
          [this](const auto&, const ServedMap& map, const Captures& in) {
            return ImageResponse(KeyframeOf(map.index(), in), kThumbnailWidth, gate_);
          });
}

void MapService::AddAppearance(Router& router) {
  AddShow(router, "/appearance", [](const auto&, const ServedMap& map, const auto&) {
    return JsonResponse(LayerJson(map.index().map(), AppearanceOf(map.index())));
  });
  AddShow(router, "/appearance/nodes", [](const auto& request, const ServedMap& map, const auto&) {
    const AppearanceLayer& layer = AppearanceOf(map.index());
    const NodeRows rows(map.name(), map.index().map());
    return JsonResponse(PagedJson(request, "nodes", layer.nodes.size(),
                                  [&](size_t i) { return rows.Row(layer.nodes[i]); }));
  });
  AddShow(router, "/appearance/loops", [](const auto& request, const ServedMap& map, const auto&) {
    const std::vector<AppearanceEdge> loops = LoopsOf(AppearanceOf(map.index()));
    return JsonResponse(
        PagedJson(request, "loops", loops.size(), [&](size_t i) { return LoopJson(loops[i]); }));
  });
  AddShow(router, "/appearance/nodes/{id}",
          [](const auto&, const ServedMap& map, const Captures& in) {
            const NodeRows rows(map.name(), map.index().map());
            return JsonResponse(rows.Row(FindNode(AppearanceOf(map.index()), in)));
          });
  AddShow(router, "/appearance/nodes/{id}/signature",
          [](const auto&, const ServedMap& map, const Captures& in) {
            return JsonResponse(SignatureJson(FindNode(AppearanceOf(map.index()), in)));
          });
  AddShow(router, "/appearance/nodes/{id}/image",
          [this](const auto& request, const ServedMap& map, const Captures& in) {
            return ImageResponse(FindNode(AppearanceOf(map.index()), in), WidthIn(request), gate_);
          });
}

void MapService::AddOrientation(Router& router) {
  AddShow(router, "/orientation", [](const auto&, const ServedMap& map, const auto&) {
    return JsonResponse(LayerJson(map.name(), map.index().map(), OrientationOf(map.index())));
  });
  AddShow(router, "/orientation/frames",
          [](const auto& request, const ServedMap& map, const auto&) {
            const OrientationLayer& layer = OrientationOf(map.index());
            const NodeRows rows(map.name(), map.index().map());
            return JsonResponse(PagedJson(request, "frames", layer.frames.size(),
                                          [&](size_t i) { return rows.Row(layer.frames[i]); }));
          });
  AddShow(router, "/orientation/frames/{id}",
          [](const auto&, const ServedMap& map, const Captures& in) {
            const int64_t id = IdIn(in, "frame");
            const OrientationFrame* frame =
                FrameOf(OrientationOf(map.index()), OrientationFrameId{id});
            const NodeRows rows(map.name(), map.index().map());
            return JsonResponse(rows.Row(Existing(frame, "frame", id)));
          });
  AddShow(router, "/orientation/turns", [](const auto& request, const ServedMap& map, const auto&) {
    const OrientationLayer& layer = OrientationOf(map.index());
    return JsonResponse(PagedJson(request, "turns", layer.turns.size(),
                                  [&](size_t i) { return TurnJson(layer.turns[i]); }));
  });
  AddShow(router, "/orientation/corridors",
          [](const auto& request, const ServedMap& map, const auto&) {
            const OrientationLayer& layer = OrientationOf(map.index());
            return JsonResponse(PagedJson(request, "corridors", layer.corridors.size(),
                                          [&](size_t i) { return CorridorJson(layer, i); }));
          });
  AddShow(router, "/orientation/nodes/{id}/image",
          [this](const auto& request, const ServedMap& map, const Captures& in) {
            return ImageResponse(FindNode(OrientationOf(map.index()), in), WidthIn(request), gate_);
          });
  AddShow(router, "/orientation/nodes/{id}/lines",
          [this](const auto&, const ServedMap& map, const Captures& in) {
            const OrientationNode& node = FindNode(OrientationOf(map.index()), in);
            const QueryGate::Turn turn = gate_.Enter();  // it computes
            return JsonResponse(LinesJson(map.index(), node));
          });
}

HttpResponse MapService::Home(const HttpRequest& request) const {
  HttpResponse response{200,
                        "text/html; charset=utf-8",
                        HomePage(maps_.Names(), request.header("Host").value_or("localhost")),
                        {}};
  response.headers.emplace_back("Content-Security-Policy", kPagePolicy);
  return response;
}

HttpResponse MapService::ListMaps(const HttpRequest& request) const {
  const std::vector<std::string> names = maps_.Names();
  const Page page = PageOf(request, names.size());
  Json json;
  json["maps"] = Json::array();
  for (size_t i = page.begin; i < page.end; ++i) {
    try {
      json["maps"].push_back(maps_.Summary(names[i]));
    } catch (const MapError& error) {
      if (error.code() != ErrorCode::kNotFound) throw;  // else it was removed just now
    }
  }
  json["next"] = page.next.empty() ? Json(nullptr) : Json(page.next);
  return JsonResponse(json);
}

}  // namespace waystone
