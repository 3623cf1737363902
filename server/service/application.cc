// SPDX-License-Identifier: Apache-2.0
#include "server/service/application.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <opencv2/core/utility.hpp>
#include <random>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "core/base/version.h"
#include "core/image/opencv_errors.h"
#include "schema/file/map_store.h"
#include "server/http/problem.h"
#include "server/http/responses.h"
#include "server/service/openapi.h"

namespace waystone {
namespace {

constexpr size_t kMaxIdBytes = 64;
// For answers that are no page: nothing in them may be run or framed.
constexpr const char* kStrictPolicy = "default-src 'none'; frame-ancestors 'none'";

bool IsId(const std::string& text) {
  return !text.empty() && text.size() <= kMaxIdBytes &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' ||
                  c == '.';
         });
}

std::string Hex(uint64_t value) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%08llx", static_cast<unsigned long long>(value));
  return text.data();
}

bool HasHeader(const HttpResponse& response, const std::string& name) {
  return std::any_of(response.headers.begin(), response.headers.end(),
                     [&](const auto& header) { return header.first == name; });
}

// Load balancers ask these, without a token and by whatever name.
bool IsHealthCheck(const std::string& path) { return path == "/healthz" || path == "/readyz"; }

// The page is the same for all, and asks its reader for a token.
bool NeedsNoToken(const std::string& path) {
  return IsHealthCheck(path) || path == "/" || path.starts_with("/page/");
}

std::unique_ptr<QueryLog> OpenLog(const ServiceOptions& options,
                                  const std::function<void(const std::string&)>& on_error) {
  if (options.query_log.empty()) return nullptr;
  return std::make_unique<QueryLog>(options.query_log, options.query_log_bytes, on_error);
}

Application::Sinks Complete(Application::Sinks sinks) {
  if (!sinks.error) sinks.error = [](const std::string&) {};
  return sinks;
}

Json VersionJson() {
  return {{"program", std::string("waystone ") + kVersion}, {"schema", kSchemaVersion}};
}

Json ReadyJson(const Holdings& holdings, bool jobs) {
  Json json = {{"ready", true}, {"maps", holdings.maps}, {"open", holdings.open}};
  if (!holdings.registry) return json;
  const RegistryHoldings& registry = *holdings.registry;
  json["registry"] = {{"connected", registry.connected},
                      {"silent_s", Rounded(registry.silent_s, 1)},
                      {"memory_bytes", registry.memory_bytes},
                      {"cached_files", registry.cached_files},
                      {"cached_bytes", registry.cached_bytes},
                      {"jobs", jobs},
                      {"coarse",
                       {{"maps", registry.coarse.maps},
                        {"places", registry.coarse.places},
                        {"bytes", registry.coarse.bytes},
                        {"without", registry.coarse.without},
                        {"waiting", registry.coarse.waiting}}}};
  return json;
}

}  // namespace

void ServiceOptions::Check() const {
  CheckFields("service", *this);
  localize.Check();
}

int CountQueryThreads(const ServiceOptions& options) {
  if (options.query_threads > 0) return options.query_threads;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

Application::Application(std::shared_ptr<MapSource> maps, const ServiceOptions& options,
                         Sinks sinks)
    : options_((options.Check(), options)),
      sinks_(Complete(std::move(sinks))),
      maps_(std::move(maps)),
      gate_(CountQueryThreads(options), options.queue_length),
      log_(OpenLog(options, sinks_.error)),
      inspection_(*maps_, gate_),
      queries_(*maps_, gate_, metrics_, log_.get(), options.localize, options.limits),
      jobs_(options_.registry, sinks_.error),
      id_prefix_(Hex(std::random_device()())) {
  cv::setNumThreads(1);  // queries are what runs in parallel
  ThrowOpenCvErrors();
  inspection_.AddTo(router_);
  queries_.AddTo(router_);
  jobs_.AddTo(router_);
  AddOperations();
  router_.OnInternalError([this](const std::string& cause) { sinks_.error(cause); });
}

void Application::AddOperations() {
  router_.Add("GET", "/healthz", [](const auto&, const auto&) {
    return HttpResponse{200, "text/plain", "ok\n", {}};
  });
  router_.Add("GET", "/readyz", [this](const auto&, const auto&) { return Ready(); });
  router_.Add("GET", "/version",
              [](const auto&, const auto&) { return JsonResponse(VersionJson()); });
  router_.Add("GET", "/metrics", [this](const auto&, const auto&) {
    return HttpResponse{
        200, "text/plain; version=0.0.4", metrics_.Text(gate_.load(), maps_->holdings()), {}};
  });
  router_.Add("GET", "/openapi.json", [](const auto&, const auto&) {
    return HttpResponse{200, "application/json", OpenApiJson(), {}};
  });
  router_.Add("GET", "/api", [](const auto&, const auto&) {
    HttpResponse response{200, "text/html; charset=utf-8", OpenApiPage(), {}};
    response.headers.emplace_back("Content-Security-Policy", kPagePolicy);
    return response;
  });
}

HttpResponse Application::Answer(const HttpRequest& incoming) {
  const auto start = std::chrono::steady_clock::now();
  HttpRequest request = incoming;
  const std::string given = incoming.header("X-Request-Id").value_or("");
  request.id = IsId(given) ? given : NewId();
  HttpResponse response = Admitted(request);
  response.headers.emplace_back("X-Request-Id", request.id);
  response.headers.emplace_back("Referrer-Policy", "no-referrer");
  if (!HasHeader(response, "Content-Security-Policy")) {
    response.headers.emplace_back("Content-Security-Policy", kStrictPolicy);
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  Report(request, response, took.count());
  return response;
}

HttpResponse Application::Admitted(const HttpRequest& request) const {
  if (request.refusal) return router_.Dispatch(request);
  try {
    if (!IsHealthCheck(request.path)) options_.names.Check(request);
  } catch (const MapError& error) {
    return ProblemResponse(error);
  }
  const bool admitted = NeedsNoToken(request.path) ||
                        options_.tokens.Admit(request.header("Authorization").value_or(""));
  if (admitted) return router_.Dispatch(request);
  return ProblemResponse(ErrorCode::kUnauthorized,
                         "send a valid token in the header Authorization: Bearer TOKEN");
}

HttpResponse Application::Ready() const {
  const Holdings holdings = maps_->holdings();
  if (stopping_) return ProblemResponse(ErrorCode::kNotReady, "the server is shutting down");
  if (holdings.maps == 0) return ProblemResponse(ErrorCode::kNotReady, "no maps loaded");
  return JsonResponse(ReadyJson(holdings, jobs_.available()));
}

void Application::Report(const HttpRequest& request, const HttpResponse& response, double seconds) {
  metrics_.CountRequest(response.route, request.method, response.status, seconds);
  if (!sinks_.access) return;
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  sinks_.access(Dump({{"time_s", Rounded(now, 3)},
                      {"id", request.id},
                      {"remote", request.remote},
                      {"method", request.method},
                      {"path", request.path.substr(0, 200)},
                      {"route", response.route},
                      {"status", response.status},
                      {"bytes", response.body.size()},
                      {"ms", Rounded(seconds * 1e3, 2)}}));
}

std::string Application::NewId() { return id_prefix_ + "-" + Hex(++requests_); }

}  // namespace waystone
