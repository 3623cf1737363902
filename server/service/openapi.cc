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

// A line for each of the parameters that a path or an operation has, if any.
std::string ParametersHtml(const Json& contract, const Json& owner) {
  std::string html;
  if (!owner.contains("parameters")) return html;
  for (const Json& given : owner["parameters"]) {
    // A reference is '#' and the path, in the contract, of what it stands for.
    const Json& parameter =
        given.contains("$ref")
            ? contract.at(Json::json_pointer(given["$ref"].get<std::string>().substr(1)))
            : given;
    html += "<li><code>" + TextOf(parameter, "name") + "</code> " +
            TextOf(parameter, "description") + "</li>\n";
  }
  return html;
}

std::string OperationHtml(const std::string& method, const std::string& path, const Json& operation,
                          const std::string& parameters) {
  const std::string html = "<h2><code>" + Upper(method) + " " + EscapeHtml(path) +
                           "</code></h2>\n<p>" + TextOf(operation, "summary") + " " +
                           TextOf(operation, "description") + "</p>\n";
  return parameters.empty() ? html : html + "<ul>\n" + parameters + "</ul>\n";
}

std::string MakePage() {
  std::string page = kApiHead;
  const Json contract = Json::parse(kOpenApiJson);
  for (const auto& [path, operations] : contract["paths"].items()) {
    const std::string of_path = ParametersHtml(contract, operations);
    for (const auto& [method, operation] : operations.items()) {
      if (!operation.is_object()) continue;
      page += OperationHtml(method, path, operation, of_path + ParametersHtml(contract, operation));
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
