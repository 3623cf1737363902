// SPDX-License-Identifier: Apache-2.0
#include "server/service/openapi.h"

#include <cctype>

#include "api/json.h"
#include "core/base/text.h"

namespace waystone {

// Made from clients/openapi.yaml by scripts/embed_openapi.py.
extern const char kOpenApiJson[];

namespace {

constexpr const char* kApiHead = R"(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>Waystone HTTP API</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; max-width: 46rem; margin: 3rem auto; padding: 0 1rem; }
code { background: #f2f3f5; color: #14171a; padding: .1rem .3rem; border-radius: 4px; }
@media (prefers-color-scheme: dark) { body { background: #14171a; color: #e8eaed; }
a { color: #8ab4f8; } code { background: #23272b; color: #e8eaed; } }
</style>
<h1>Waystone HTTP API</h1>
<p>The contract in full: <a href="/openapi.json">/openapi.json</a> (OpenAPI 3.1).</p>
)";

std::string Upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string TextOf(const Json& object, const char* field) {
  return object.contains(field) ? EscapeHtml(object[field].get<std::string>()) : "";
}

std::string OperationHtml(const std::string& method, const std::string& path,
                          const Json& operation) {
  std::string html = "<h2><code>" + Upper(method) + " " + EscapeHtml(path) + "</code></h2>\n<p>" +
                     TextOf(operation, "summary") + " " + TextOf(operation, "description") +
                     "</p>\n";
  if (!operation.contains("parameters")) return html;
  html += "<ul>\n";
  for (const Json& parameter : operation["parameters"]) {
    if (!parameter.contains("name")) continue;
    html += "<li><code>" + TextOf(parameter, "name") + "</code> " +
            TextOf(parameter, "description") + "</li>\n";
  }
  return html + "</ul>\n";
}

std::string MakePage() {
  std::string page = kApiHead;
  const Json contract = Json::parse(kOpenApiJson);
  for (const auto& [path, operations] : contract["paths"].items()) {
    for (const auto& [method, operation] : operations.items()) {
      if (operation.is_object()) page += OperationHtml(method, path, operation);
    }
  }
  return page + "</html>\n";
}

}  // namespace

const std::string& OpenApiJson() {
  static const std::string json = kOpenApiJson;
  return json;
}

const std::string& OpenApiPage() {
  static const std::string page = MakePage();
  return page;
}

}  // namespace waystone
