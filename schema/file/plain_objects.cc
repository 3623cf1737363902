// SPDX-License-Identifier: Apache-2.0
#include "schema/file/plain_objects.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace waystone {
namespace {

using Tokens = std::vector<std::string>;

// What may follow a column's name.
constexpr std::array<std::string_view, 11> kColumnWords{
    "INTEGER", "INT", "REAL", "TEXT", "BLOB", "ANY", "PRIMARY", "KEY", "NOT", "NULL", "UNIQUE"};

bool IsNameByte(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 && static_cast<unsigned char>(c) < 128;
}

bool IsName(std::string_view token) {
  return !token.empty() &&
         std::ranges::all_of(token, [](char c) { return IsNameByte(c) || c == '_'; }) &&
         std::isdigit(static_cast<unsigned char>(token[0])) == 0;
}

std::string UpperCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

// Splits into names and single other bytes, without blanks.
Tokens Tokenise(std::string_view sql) {
  Tokens tokens;
  for (size_t i = 0; i < sql.size();) {
    size_t end = i;
    while (end < sql.size() && (IsNameByte(sql[end]) || sql[end] == '_')) ++end;
    if (end == i) end = i + 1;
    if (sql[i] != ' ' && sql[i] != '\n' && sql[i] != '\t') tokens.emplace_back(sql, i, end - i);
    i = end;
  }
  return tokens;
}

// Removes the words from the front, ignoring case, if they are there.
bool Take(std::span<const std::string>& tokens, const std::vector<std::string_view>& words) {
  if (tokens.size() < words.size()) return false;
  for (size_t i = 0; i < words.size(); ++i) {
    if (UpperCase(tokens[i]) != words[i]) return false;
  }
  tokens = tokens.subspan(words.size());
  return true;
}

bool TakeName(std::span<const std::string>& tokens, std::string_view name) {
  if (tokens.empty() || tokens[0] != name) return false;
  tokens = tokens.subspan(1);
  return true;
}

// "(a, b, c)" to the end, where only words of `allowed` follow a name.
bool IsColumnList(std::span<const std::string> tokens, std::span<const std::string_view> allowed) {
  if (tokens.size() < 3 || tokens.front() != "(" || tokens.back() != ")") return false;
  bool at_name = true;
  for (const std::string& token : tokens.subspan(1, tokens.size() - 2)) {
    if (at_name ? !IsName(token)
                : token != "," && std::ranges::find(allowed, UpperCase(token)) == allowed.end()) {
      return false;
    }
    at_name = token == ",";
  }
  return !at_name;
}

bool IsPlainTable(const SchemaObject& object) {
  const Tokens all = Tokenise(object.sql);
  std::span<const std::string> tokens(all);
  if (!Take(tokens, {"CREATE", "TABLE"}) || !TakeName(tokens, object.name)) return false;
  if (!tokens.empty() && UpperCase(tokens.back()) == "STRICT") {
    tokens = tokens.first(tokens.size() - 1);
  }
  return IsColumnList(tokens, kColumnWords);
}

bool IsPlainIndex(const SchemaObject& object) {
  const Tokens all = Tokenise(object.sql);
  std::span<const std::string> tokens(all);
  if (!Take(tokens, {"CREATE", "INDEX"}) && !Take(tokens, {"CREATE", "UNIQUE", "INDEX"})) {
    return false;
  }
  if (!TakeName(tokens, object.name) || !Take(tokens, {"ON"})) return false;
  return tokens.size() > 1 && IsName(tokens[0]) && IsColumnList(tokens.subspan(1), {});
}

}  // namespace

bool IsPlainObject(const SchemaObject& object) {
  // SQLite's own tables influence how it reads the others.
  if (!IsName(object.name) || UpperCase(object.name).starts_with("SQLITE_")) return false;
  if (object.type == "table") return IsPlainTable(object);
  return object.type == "index" && IsPlainIndex(object);
}

}  // namespace waystone
