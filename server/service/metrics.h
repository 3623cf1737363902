// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "localizer/verdict/answer.h"
#include "server/service/map_source.h"
#include "server/service/query_gate.h"

namespace waystone {

// What a server did, counted for Prometheus:
//   waystone_request_duration_seconds{route,method,status}  histogram
//   waystone_stage_duration_seconds{stage}                  histogram: decode, extract, ...
//   waystone_localized_total{verdict}                       counter
//   waystone_inliers                                        histogram, of the best plane of
//                                                           answers that recognised one
//   waystone_queries_running, waystone_queries_waiting      gauges
//   waystone_reloads_total{result}, waystone_maps, waystone_maps_open,
//   process_resident_memory_bytes
// and, for a server of a registry:
//   waystone_registry_up, waystone_registry_silent_seconds
//   waystone_map_memory_bytes, waystone_map_memory_limit_bytes
//   waystone_map_opens_total, waystone_map_closes_total
//   waystone_cache_files, waystone_cache_bytes, waystone_cache_limit_bytes
//   waystone_fetches_total{result}, waystone_fetched_bytes_total
//   waystone_coarse_maps, waystone_coarse_places, waystone_coarse_bytes
//   waystone_coarse_missing{reason}, waystone_coarse_refused_total
// Thread-safe.
class Metrics {
 public:
  Metrics();
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  // `route` is the pattern that answered, so that the number of series stays bounded.
  void CountRequest(const std::string& route, const std::string& method, int status,
                    double seconds);
  void CountAnswer(const Answer& answer);
  void CountReload(bool good);

  // All of it as Prometheus reads it (text format 0.0.4).
  std::string Text(const QueryGate::Load& load, const Holdings& holdings) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace waystone
