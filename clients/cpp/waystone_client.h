// SPDX-License-Identifier: Apache-2.0
// The C++ client: this header, cpp-httplib (0.11 or later) and nlohmann-json (3.9 or later). C++17.
#pragma once

#include <httplib.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace waystone {

// An error from the server or on the way to it; what() is one line for people. "Not in this map" is
// an answer, not an error.
class ClientError : public std::runtime_error {
 public:
  ClientError(std::string code, int status, const std::string& detail)
      : std::runtime_error(detail), code_(std::move(code)), status_(status) {}

  // The contract's code, or "unreachable", "timeout", "bad_answer" or "unreadable_photo".
  const std::string& code() const { return code_; }
  // The HTTP status; 0 where no answer came.
  int status() const { return status_; }

 private:
  std::string code_;
  int status_ = 0;
};

struct ClientOptions {
  std::string token = {};  // sent in plain text over http: use https between machines
  int timeout_s = 30;      // how long the server may be silent
  int retries = 3;         // while the server is busy
  int max_wait_s = 30;     // a longer Retry-After is not waited for
  int total_s = 60;        // how long a call may take, including its retries and their waits
};

// An encoded image (JPEG, PNG, ...) and its name in the answer.
struct Photo {
  std::string name;
  std::string bytes;
};

// Queries a Waystone server, over a connection of its own for each request. Not thread-safe; any
// number of clients may query one server. Throws nothing but ClientError.
class Client {
 public:
  using Json = nlohmann::ordered_json;

  // "http://127.0.0.1:8080", optionally with a path before the API; https where cpp-httplib has
  // OpenSSL.
  explicit Client(const std::string& server, ClientOptions options = {})
      : options_(std::move(options)) {
    const size_t host = server.find("://");
    const bool http = server.rfind("http://", 0) == 0 || server.rfind("https://", 0) == 0;
    if (!http || host + 3 == server.size()) RefuseAddress(server);
    const size_t path = std::min(server.find('/', host + 3), server.size());
    origin_ = server.substr(0, path);
    prefix_ = server.substr(path);
    while (!prefix_.empty() && prefix_.back() == '/') prefix_.pop_back();
    if (!HasUsablePort(origin_)) RefuseAddress(server);
  }

  // Localizes images in one map, or in all maps for an empty name. `request` has the fields
  // of docs/http-api.md: {{"fov_deg", 63}, {"debug", true}}.
  Json Localize(const Photo& photo, const std::string& map = "", const Json& request = {}) const {
    return Localize(std::vector<Photo>{photo}, map, request);
  }
  Json Localize(const std::string& path, const std::string& map = "",
                const Json& request = {}) const {
    return Localize(Read(path), map, request);
  }
  // Several images, those of a rig or a series in order: one answer.
  Json Localize(const std::vector<Photo>& photos, const std::string& map = "",
                const Json& request = {}) const {
    httplib::MultipartFormDataItems parts;
    for (const Photo& photo : photos) {
      parts.push_back({"image", photo.bytes, Quotable(photo.name), "application/octet-stream"});
    }
    if (!request.empty()) {
      // What isn't UTF-8 gets U+FFFD, which the server may refuse.
      const std::string text = request.dump(-1, ' ', false, Json::error_handler_t::replace);
      parts.push_back({"request", text, "", "application/json"});
    }
    const std::string target = map.empty() ? "/v1/localize" : MapPath(map) + "/localize";
    Json answer = Parsed(Ask([&](httplib::Client& client, const httplib::Headers& headers) {
      return client.Post(prefix_ + target, headers, parts);
    }));
    if (!answer.is_object() || !answer.contains("verdict") || !answer["verdict"].is_string()) {
      throw ClientError("bad_answer", 200, "the response is no answer; check the address");
    }
    return answer;
  }

  // Any path of the API, as parsed JSON: "/v1/maps", MapPath("lab") + "/planes".
  Json Get(const std::string& path) const { return Parsed(GetText(path)); }
  // The same unparsed, for texts and pictures.
  std::string GetText(const std::string& path) const {
    return Ask([&](httplib::Client& client, const httplib::Headers& headers) {
      return client.Get(prefix_ + path, headers);
    });
  }
  // The rows of a list, all pages: Rows(MapPath("lab") + "/planes", "planes").
  std::vector<Json> Rows(const std::string& path, const std::string& key) const {
    std::vector<Json> rows;
    std::string target = path + "?limit=1000";
    while (true) {
      Json page = Get(target);
      const bool is_page = page.is_object() && page.contains(key) && page[key].is_array() &&
                           page.contains("next") &&
                           (page["next"].is_null() || page["next"].is_string());
      if (!is_page) {
        throw ClientError("bad_answer", 200, path + " is not a list of " + key);
      }
      for (Json& row : page[key]) rows.push_back(std::move(row));
      if (page["next"].is_null()) return rows;
      target = path + "?limit=1000&cursor=" + page["next"].get<std::string>();
    }
  }

  // "/v1/maps/NAME", escaped.
  static std::string MapPath(const std::string& map) {
    std::string path = "/v1/maps/";
    for (const char c : map) {
      const auto byte = static_cast<unsigned char>(c);
      if (std::isalnum(byte) || c == '-' || c == '.' || c == '_' || c == '~') {
        path += c;
      } else {
        char escaped[4];
        (void)std::snprintf(escaped, sizeof escaped, "%%%02X", byte);
        path += escaped;
      }
    }
    return path;
  }

  static Photo Read(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (!in.is_open() || in.bad()) {
      throw ClientError("unreadable_photo", 0,
                        path + " can't be read; check the path and its permissions");
    }
    return {path, std::move(bytes)};
  }

 private:
  [[noreturn]] static void RefuseAddress(const std::string& server) {
    throw ClientError("unreachable", 0,
                      "'" + server +
                          "' is not a server address; expected http://HOST:PORT with a port from 1 "
                          "to 65535");
  }

  // Whether an origin has no port, or one from 1 to 65535: cpp-httplib doesn't check it.
  static bool HasUsablePort(const std::string& origin) {
    const size_t bracket = origin.rfind(']');  // behind an IPv6 address
    const size_t host = bracket == std::string::npos ? origin.find("://") + 3 : bracket;
    const size_t colon = origin.find(':', host);
    if (colon == std::string::npos) return true;
    const std::string port = origin.substr(colon + 1);
    constexpr size_t kMostDigits = 5;
    if (port.empty() || port.size() > kMostDigits || !IsDigits(port)) return false;
    const int number = std::stoi(port);
    return 1 <= number && number <= 65'535;
  }

  static bool IsDigits(const std::string& text) {
    return std::all_of(text.begin(), text.end(), [](char c) { return '0' <= c && c <= '9'; });
  }

  // A name for a quoted string of a form's header: without what would end its line, and escaped.
  static std::string Quotable(const std::string& name) {
    std::string quotable;
    for (const char c : name) {
      if (c == '"' || c == '\\') quotable += '\\';
      quotable += static_cast<unsigned char>(c) < ' ' ? '_' : c;
    }
    return quotable;
  }

  using Clock = std::chrono::steady_clock;

  // Cuts a request off that isn't over in time: cpp-httplib's timeouts are for each piece, so a
  // server that sends slowly could go on forever.
  class Cutter {
   public:
    Cutter(httplib::Client& client, Clock::time_point end)
        : thread_([this, &client, end] { CutAt(client, end); }) {}
    ~Cutter() {
      {
        const std::lock_guard<std::mutex> guard(mutex_);
        over_ = true;
      }
      ended_.notify_one();
      thread_.join();
    }
    Cutter(const Cutter&) = delete;
    Cutter& operator=(const Cutter&) = delete;

   private:
    void CutAt(httplib::Client& client, Clock::time_point end) {
      constexpr std::chrono::milliseconds kAgain(100);  // it may not have been connected yet
      std::unique_lock<std::mutex> lock(mutex_);
      while (!ended_.wait_until(lock, end, [this] { return over_; })) {
        client.stop();
        end = Clock::now() + kAgain;
      }
    }

    std::mutex mutex_;
    std::condition_variable ended_;
    bool over_ = false;
    std::thread thread_;  // the last one, as it uses the others
  };

  template <class Send>
  std::string Ask(const Send& send) const {
    const Clock::time_point end = Clock::now() + std::chrono::seconds(options_.total_s);
    for (int left = options_.retries;; --left) {
      const httplib::Result result = AskOnce(send, end);
      // What was cut off may look complete.
      if (Clock::now() >= end) throw TooLate();
      if (!result) {
        throw ClientError("unreachable", 0,
                          "the server at " + origin_ + " does not respond (" +
                              httplib::to_string(result.error()) + "); is it running?");
      }
      if (result->status >= 200 && result->status < 300) return result->body;
      const int wait_s = RetryAfter(*result);
      const bool fits =
          wait_s <= options_.max_wait_s && Clock::now() + std::chrono::seconds(wait_s) < end;
      if (result->status != 429 || left <= 0 || !fits) Refuse(*result);
      std::this_thread::sleep_for(std::chrono::seconds(wait_s));
    }
  }

  template <class Send>
  httplib::Result AskOnce(const Send& send, Clock::time_point end) const {
    httplib::Client client = NewClient();
    client.set_connection_timeout(std::min(options_.timeout_s, SecondsUntil(end)));
    client.set_read_timeout(options_.timeout_s);
    client.set_write_timeout(options_.timeout_s);
    httplib::Headers headers;
    if (!options_.token.empty()) headers.emplace("Authorization", "Bearer " + options_.token);
    try {
      const Cutter cutter(client, end);
      return send(client, headers);
    } catch (const std::system_error& error) {
      throw ClientError("unreachable", 0,
                        std::string("cannot start a thread (") + error.what() +
                            "); try again, or raise the limit of processes");
    }
  }

  static int SecondsUntil(Clock::time_point end) {
    const auto left = std::chrono::duration_cast<std::chrono::seconds>(end - Clock::now());
    return std::max(1, static_cast<int>(left.count()));
  }

  ClientError TooLate() const {
    return {"timeout", 0,
            "the server at " + origin_ + " has not answered within " +
                std::to_string(options_.total_s) + " s; try again later"};
  }

  httplib::Client NewClient() const {
    try {
      return httplib::Client(origin_);
    } catch (const std::exception& error) {  // https without OpenSSL
      throw ClientError("unreachable", 0,
                        origin_ + " can't be asked (" + error.what() + "); check the address");
    }
  }

  static int RetryAfter(const httplib::Response& response) {
    constexpr int kDefaultS = 1;
    const std::string text = response.get_header_value("Retry-After");
    const bool whole = !text.empty() && text.size() < 6 && IsDigits(text);
    return whole ? std::stoi(text) : kDefaultS;
  }

  [[noreturn]] static void Refuse(const httplib::Response& response) {
    const Json problem = Json::parse(response.body, nullptr, false);
    if (problem.is_object() && problem.contains("code") && problem["code"].is_string() &&
        problem.contains("detail") && problem["detail"].is_string()) {
      throw ClientError(problem["code"], response.status, problem["detail"]);
    }
    throw ClientError("bad_answer", response.status,
                      "the server answered " + std::to_string(response.status) +
                          " without JSON of Waystone; check the address");
  }

  static Json Parsed(const std::string& body) {
    Json json = Json::parse(body, nullptr, false);
    if (json.is_discarded()) {
      throw ClientError("bad_answer", 200, "the response is not JSON; check the address");
    }
    return json;
  }

  std::string origin_;
  std::string prefix_;
  ClientOptions options_;
};

}  // namespace waystone
