// SPDX-License-Identifier: Apache-2.0
#include "server/service/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <mutex>
#include <optional>
#include <sstream>

namespace waystone {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;
using prometheus::Histogram;

constexpr double kSecondsPerMs = 1e-3;

// Upper bounds of the buckets: from an inspection to a query that waited long, and from one match
// to a poster that fills the image.
const Histogram::BucketBoundaries& SecondsBuckets() {
  static const Histogram::BucketBoundaries buckets = {
      0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 10};
  return buckets;
}
const Histogram::BucketBoundaries& InlierBuckets() {
  static const Histogram::BucketBoundaries buckets = {5, 10, 15, 20, 30, 50, 100, 200, 500};
  return buckets;
}

double ResidentBytes() {
  int64_t pages = 0;
  int64_t resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

prometheus::Gauge& AddGauge(prometheus::Registry& registry, const std::string& name,
                            const std::string& help) {
  return BuildGauge().Name(name).Help(help).Register(registry).Add({});
}

prometheus::Counter& AddCounter(prometheus::Registry& registry, const std::string& name,
                                const std::string& help) {
  return BuildCounter().Name(name).Help(help).Register(registry).Add({});
}

// Sets a metric to what is counted elsewhere.
void SetTo(prometheus::Counter& counter, int64_t value) {
  counter.Increment(static_cast<double>(value) - counter.Value());
}
void SetTo(prometheus::Gauge& gauge, int64_t value) { gauge.Set(static_cast<double>(value)); }

}  // namespace

// What a server of a registry holds.
class RegistryMetrics {
 public:
  explicit RegistryMetrics(prometheus::Registry& registry)
      : up_(AddGauge(registry, "waystone_registry_up", "1 while the registry answers")),
        silent_(AddGauge(registry, "waystone_registry_silent_seconds",
                         "Seconds since the registry answered")),
        memory_(AddGauge(registry, "waystone_map_memory_bytes",
                         "Memory counted for open maps in bytes")),
        memory_limit_(AddGauge(registry, "waystone_map_memory_limit_bytes",
                               "Limit of the memory counted for open maps in bytes")),
        opens_(AddCounter(registry, "waystone_map_opens_total", "Maps opened")),
        closes_(AddCounter(registry, "waystone_map_closes_total",
                           "Maps closed to make room in memory")),
        files_(AddGauge(registry, "waystone_cache_files", "Map files in the cache")),
        bytes_(AddGauge(registry, "waystone_cache_bytes", "Bytes of the files in the cache")),
        limit_(AddGauge(registry, "waystone_cache_limit_bytes", "Limit of the bytes in the cache")),
        fetched_bytes_(AddCounter(registry, "waystone_fetched_bytes_total",
                                  "Bytes of the map files that were fetched")),
        fetches_(BuildCounter()
                     .Name("waystone_fetches_total")
                     .Help("Map files fetched from the store by result")
                     .Register(registry)),
        coarse_maps_(AddGauge(registry, "waystone_coarse_maps", "Maps in the coarse index")),
        coarse_places_(AddGauge(registry, "waystone_coarse_places", "Places in the coarse index")),
        coarse_bytes_(AddGauge(registry, "waystone_coarse_bytes", "Memory of the coarse index")),
        coarse_missing_(BuildGauge()
                            .Name("waystone_coarse_missing")
                            .Help("Maps that aren't in the coarse index, by reason")
                            .Register(registry)),
        coarse_refused_(AddCounter(registry, "waystone_coarse_refused_total",
                                   "Coarse entries that couldn't be fetched or read")) {}

  void Set(const RegistryHoldings& now) {
    up_.Set(now.connected ? 1 : 0);
    silent_.Set(now.silent_s);
    SetTo(memory_, now.memory_bytes);
    SetTo(memory_limit_, now.memory_limit);
    SetTo(opens_, now.opened);
    SetTo(closes_, now.closed);
    SetTo(files_, now.cached_files);
    SetTo(bytes_, now.cached_bytes);
    SetTo(limit_, now.cache_limit);
    SetTo(fetched_bytes_, now.fetched_bytes);
    SetTo(fetches_.Add({{"result", "good"}}), now.fetched_files);
    SetTo(fetches_.Add({{"result", "failed"}}), now.failed_fetches);
    SetTo(coarse_maps_, now.coarse.maps);
    SetTo(coarse_places_, now.coarse.places);
    SetTo(coarse_bytes_, now.coarse.bytes);
    SetTo(coarse_missing_.Add({{"reason", "no_entry"}}), now.coarse.without);
    SetTo(coarse_missing_.Add({{"reason", "no_room"}}), now.coarse.left_out);
    SetTo(coarse_missing_.Add({{"reason", "not_fetched"}}),
          now.coarse.waiting - now.coarse.left_out);
    SetTo(coarse_refused_, now.coarse.refused);
  }

 private:
  prometheus::Gauge& up_;
  prometheus::Gauge& silent_;
  prometheus::Gauge& memory_;
  prometheus::Gauge& memory_limit_;
  prometheus::Counter& opens_;
  prometheus::Counter& closes_;
  prometheus::Gauge& files_;
  prometheus::Gauge& bytes_;
  prometheus::Gauge& limit_;
  prometheus::Counter& fetched_bytes_;
  prometheus::Family<prometheus::Counter>& fetches_;
  prometheus::Gauge& coarse_maps_;
  prometheus::Gauge& coarse_places_;
  prometheus::Gauge& coarse_bytes_;
  prometheus::Family<prometheus::Gauge>& coarse_missing_;
  prometheus::Counter& coarse_refused_;
};

struct Metrics::Impl {
  std::mutex setting;
  prometheus::Registry registry;
  prometheus::Family<Histogram>& requests = BuildHistogram()
                                                .Name("waystone_request_duration_seconds")
                                                .Help("Requests by route and status")
                                                .Register(registry);
  prometheus::Family<Histogram>& stages = BuildHistogram()
                                              .Name("waystone_stage_duration_seconds")
                                              .Help("Duration of query stages in seconds")
                                              .Register(registry);
  prometheus::Family<prometheus::Counter>& verdicts =
      BuildCounter().Name("waystone_localized_total").Help("Answers by verdict").Register(registry);
  prometheus::Family<prometheus::Counter>& reloads = BuildCounter()
                                                         .Name("waystone_reloads_total")
                                                         .Help("Map reloads by result")
                                                         .Register(registry);
  Histogram& inliers = BuildHistogram()
                           .Name("waystone_inliers")
                           .Help("Inliers of the best plane of answers that recognised one")
                           .Register(registry)
                           .Add({}, InlierBuckets());
  prometheus::Gauge& running = MakeGauge("waystone_queries_running", "Queries being processed");
  prometheus::Gauge& waiting = MakeGauge("waystone_queries_waiting", "Queries in the queue");
  prometheus::Gauge& maps = MakeGauge("waystone_maps", "Maps loaded");
  prometheus::Gauge& open = MakeGauge("waystone_maps_open", "Maps in memory");
  prometheus::Gauge& memory =
      MakeGauge("process_resident_memory_bytes", "Resident memory size in bytes");
  std::optional<RegistryMetrics> of_registry;  // made when there is one

  prometheus::Gauge& MakeGauge(const std::string& name, const std::string& help) {
    return AddGauge(registry, name, help);
  }
  void Observe(const std::string& stage, double ms) {
    stages.Add({{"stage", stage}}, SecondsBuckets()).Observe(ms * kSecondsPerMs);
  }
};

Metrics::Metrics() : impl_(std::make_unique<Impl>()) {
  for (const Verdict verdict : {Verdict::kLocalized, Verdict::kAmbiguous, Verdict::kNotInMap,
                                Verdict::kBadImage, Verdict::kUndecided}) {
    impl_->verdicts.Add({{"verdict", NameOf(verdict)}});
  }
  for (const char* result : {"swapped", "refused"}) impl_->reloads.Add({{"result", result}});
}
Metrics::~Metrics() = default;

void Metrics::CountRequest(const std::string& route, const std::string& method, int status,
                           double seconds) {
  const bool known = method == "GET" || method == "HEAD" || method == "POST";
  impl_->requests
      .Add({{"route", route.empty() ? "none" : route},
            {"method", known ? method : "other"},
            {"status", std::to_string(status)}},
           SecondsBuckets())
      .Observe(seconds);
}

void Metrics::CountAnswer(const Answer& answer) {
  impl_->verdicts.Add({{"verdict", NameOf(answer.verdict)}}).Increment();
  impl_->Observe("decode", answer.timing.decode_ms);
  impl_->Observe("extract", answer.timing.extract_ms);
  impl_->Observe("shortlist", answer.timing.shortlist_ms);
  impl_->Observe("verify", answer.timing.verify_ms);
  impl_->Observe("total", answer.timing.total_ms);
  const std::vector<RecognisedPlane>& planes = answer.planes.recognised;
  if (!planes.empty()) impl_->inliers.Observe(planes.front().inliers);
}

void Metrics::CountReload(bool good) {
  impl_->reloads.Add({{"result", good ? "swapped" : "refused"}}).Increment();
}

std::string Metrics::Text(const QueryGate::Load& load, const Holdings& holdings) const {
  // One call at a time: a counter that is set by its difference must not be set twice.
  const std::lock_guard lock(impl_->setting);
  impl_->running.Set(load.running);
  impl_->waiting.Set(load.waiting);
  impl_->maps.Set(static_cast<double>(holdings.maps));
  impl_->open.Set(static_cast<double>(holdings.open));
  if (holdings.registry) {
    if (!impl_->of_registry) impl_->of_registry.emplace(impl_->registry);
    impl_->of_registry->Set(*holdings.registry);
    SetTo(impl_->reloads.Add({{"result", "swapped"}}), holdings.registry->swapped);
    SetTo(impl_->reloads.Add({{"result", "refused"}}), holdings.registry->refused);
  }
  impl_->memory.Set(ResidentBytes());
  std::ostringstream out;
  out.exceptions(std::ios::badbit);  // out of memory, the text would be cut off
  prometheus::TextSerializer().Serialize(out, impl_->registry.Collect());
  return out.str();
}

}  // namespace waystone
