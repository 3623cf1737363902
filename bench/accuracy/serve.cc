// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "bench/accuracy/common.h"
#include "bench/accuracy/world_source.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "schema/file/map_store.h"
#include "server/http/http_server.h"
#include "server/service/application.h"
#include "world/rig.h"

// After Eigen, which the macro _res of the resolver's header would break.
#include <httplib.h>

namespace waystone::bench {
namespace {

constexpr int kMapFrames = 120;  // of the world's walk that is mapped
constexpr int kPhotoStep = 6;    // frames between the photos of the world
constexpr int kClients = 4;
constexpr int kTimeoutS = 60;
constexpr auto kInspectionPause = std::chrono::milliseconds(10);

struct AskedMap {
  std::shared_ptr<const MapIndex> index;
  std::vector<std::string> photos;  // encoded
};

AskedMap RenderAskedMap() {
  const World world(DemoPlan());
  const Renderer renderer(PinholeCamera(640, 480, 1.2));
  Walk walk = DemoWalk(world.plan());
  if (std::ssize(walk.frames) > kMapFrames) walk.frames.resize(kMapFrames);
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<WorldSource>(world, renderer, walk));
  AskedMap asked{MapIndex::Build(BuildMap(sources, {}, {}).map), {}};
  const WorldSource photos(world, renderer, walk);
  for (int frame = 1; frame < photos.size(); frame += kPhotoStep) {
    std::vector<uint8_t> bytes;
    cv::imencode(".jpg", photos.Render(frame).grey, bytes);
    asked.photos.emplace_back(bytes.begin(), bytes.end());
  }
  return asked;
}

AskedMap ReadAskedMap(const Args& args) {
  AskedMap asked{MapIndex::Build(ReadMap(args[0])), {}};
  for (size_t i = 1; i < args.size(); ++i) {
    for (const auto& path : ImagesIn(args[i])) {
      const std::vector<uint8_t> bytes = ReadBytes(path);
      asked.photos.emplace_back(bytes.begin(), bytes.end());
    }
  }
  if (asked.photos.empty()) throw MapError(ErrorCode::kUsage, "serve MAP wants photos");
  return asked;
}

// Seconds per query, one after the other without HTTP.
double SingleQueryS(const AskedMap& asked) {
  const Clock::time_point start = Clock::now();
  for (const std::string& photo : asked.photos) {
    Localize(*asked.index, {reinterpret_cast<const uint8_t*>(photo.data()), photo.size()}, "", {});
  }
  return MillisecondsSince(start) / 1e3 / static_cast<double>(asked.photos.size());
}

// A server of the map, and its clients.
class Served {
 public:
  explicit Served(const AskedMap& asked)
      : asked_(asked),
        application_({{"map", asked.index}}, {}, {}),
        server_(AnyPort(), [this](const HttpRequest& in) { return application_.Answer(in); }) {
    server_.Start();
  }

  // What HTTP adds to each query, ms: the client's time less what the answer says.
  std::vector<double> OverheadMs() const {
    httplib::Client client = NewClient();
    std::vector<double> overhead;
    for (const std::string& photo : asked_.photos) {
      const Clock::time_point start = Clock::now();
      const std::string body = Post(client, photo);
      const double ms = MillisecondsSince(start);
      overhead.push_back(ms - nlohmann::json::parse(body)["timing_ms"]["total"].get<double>());
    }
    return overhead;
  }

  // Queries per second of four clients that ask without a pause.
  double Throughput(int rounds) const {
    const int queries = rounds * static_cast<int>(asked_.photos.size());
    std::atomic<int> next = 0;
    std::vector<std::thread> clients;
    const Clock::time_point start = Clock::now();
    for (int c = 0; c < kClients; ++c) {
      clients.emplace_back([&] {
        httplib::Client client = NewClient();
        for (int i = next++; i < queries; i = next++) {
          Post(client, asked_.photos[i % asked_.photos.size()]);
        }
      });
    }
    for (std::thread& client : clients) client.join();
    return queries / (MillisecondsSince(start) / 1e3);
  }

  // Times of inspection requests until `stop`, ms.
  std::vector<double> InspectionMs(const std::atomic<bool>& stop) const {
    httplib::Client client = NewClient();
    std::vector<double> times;
    while (!stop) {
      const Clock::time_point start = Clock::now();
      const auto result = client.Get("/v1/maps/map/planes?limit=20");
      times.push_back(MillisecondsSince(start));
      if (!result || result->status != 200) {
        throw MapError(ErrorCode::kInternal, "an inspection request failed");
      }
      std::this_thread::sleep_for(kInspectionPause);
    }
    return times;
  }

 private:
  static HttpOptions AnyPort() {
    HttpOptions options;
    options.port = 0;
    return options;
  }
  httplib::Client NewClient() const {
    httplib::Client client(server_.url());
    client.set_keep_alive(true);
    client.set_tcp_nodelay(true);
    client.set_read_timeout(kTimeoutS);
    return client;
  }
  static std::string Post(httplib::Client& client, const std::string& photo) {
    const auto result = client.Post("/v1/maps/map/localize", photo, "image/jpeg");
    if (!result || result->status != 200) throw MapError(ErrorCode::kInternal, "a query failed");
    return result->body;
  }

  const AskedMap& asked_;
  Application application_;
  HttpServer server_;
};

}  // namespace

int RunServe(const Args& raw) {
  Args args = raw;
  const int rounds = std::stoi(TakeOption(args, "rounds", "4"));
  const AskedMap asked = args.empty() ? RenderAskedMap() : ReadAskedMap(args);
  const Served served(asked);
  const double before_s = SingleQueryS(asked);
  const std::vector<double> overhead = served.OverheadMs();
  const double alone = served.Throughput(rounds);
  std::atomic<bool> stop = false;
  std::vector<double> inspection;
  std::thread inspector([&] { inspection = served.InspectionMs(stop); });
  const double watched = served.Throughput(rounds);
  stop = true;
  inspector.join();
  // The machine's other work varies: the rest is compared with the mean of before and after.
  const double single_s = (before_s + SingleQueryS(asked)) / 2;
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  const double share = alone * single_s / cores;
  std::printf(
      "%zu photos, %d cores: one query %.1f ms; %d clients %.1f queries/s, %.2f of cores "
      "/ time\nHTTP adds %.2f ms (median); inspection p50 %.2f, p99 %.2f ms\n",
      asked.photos.size(), cores, 1e3 * single_s, kClients, alone, share, Quantile(overhead, 0.5),
      Quantile(inspection, 0.5), Quantile(inspection, 0.99));
  const nlohmann::ordered_json json = {{"bench", "serve"},
                                       {"cores", cores},
                                       {"single_ms", 1e3 * single_s},
                                       {"queries_per_s", alone},
                                       {"share_of_cores", share},
                                       {"queries_per_s_watched", watched},
                                       {"overhead_ms_p50", Quantile(overhead, 0.5)},
                                       {"overhead_ms_p90", Quantile(overhead, 0.9)},
                                       {"inspection_ms_p50", Quantile(inspection, 0.5)},
                                       {"inspection_ms_p99", Quantile(inspection, 0.99)},
                                       {"inspections", inspection.size()}};
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
