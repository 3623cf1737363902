// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/build_appearance.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <opencv2/core.hpp>

#include "core/base/option_range.h"

namespace waystone {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMaxNamedSkips = 20;
constexpr int kFewestPanoramas = 2;
constexpr double kGapSteps = 5;  // between sequences that nothing ties together
constexpr double kBandTolerance_rad = 1e-6;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Relations that were measured, by the panoramas' indices.
using Relations = std::map<std::pair<int, int>, AppearanceEdge>;

// What stays of a frame, besides what its way is measured by, until the nodes are made.
struct TakenFrame {
  FrameInfo info;
  FourierSignature signature;
  std::vector<uint8_t> jpeg;
  NodeFeatures kept;
};

// A panorama whose features stay whole.
struct Sample {
  int panorama = 0;
  BearingFeatures features;
};

class LayerBuilder {
 public:
  LayerBuilder(const AppearanceOptions& options, const AppearanceProgress& progress)
      : options_(options), progress_(progress), chooser_(options.describe.features) {}

  void AddSource(Source& source) {
    Sequence sequence;
    sequence.id = SequenceId{std::ssize(result_.sequences) + 1};
    sequence.name = source.name();
    sequence.kind = source.kind();
    sequence.camera = source.camera();
    result_.sequences.push_back(sequence);
    first_skip_.clear();
    const int first = size();
    bool stopped = false;
    DescribeFrames(source, options_.describe, [&](DescribedFrame frame) {
      Take(std::move(frame));
      const int done = result_.sequences.back().frames;
      stopped = !Report("panoramas", done, std::max(done, source.size()));
      return !stopped;
    });
    if (stopped) Interrupt();
    if (size() > first) frames_.back().kept = chooser_.Last();
    stretches_.push_back({first, size()});
    CheckSequence();
  }

  AppearanceResult Finish() {
    FollowAll();
    LoopClosure closure;
    if (options_.close_loops) closure = Close();
    LayOut(closure);
    Optimise(closure);
    MakeNodes();
    MakeEdges(closure);
    HandOutSamples();
    result_.layer.described = options_.describe.signature;
    result_.layer.described.band = band_;
    result_.report.panoramas = size();
    result_.report.total_s = SecondsSince(start_);
    return std::move(result_);
  }

 private:
  int size() const { return static_cast<int>(signatures_.size()); }
  AppearanceReport& report() { return result_.report; }

  void Take(DescribedFrame frame) {
    Sequence& sequence = result_.sequences.back();
    ++report().frames;
    ++sequence.frames;
    report().decode_s += frame.decode_s;
    report().describe_s += frame.describe_s;
    if (frame.error.empty()) {
      if (signatures_.empty()) band_ = frame.band;
      CheckBand(frame);
      TakeFeatures(frame);
      signatures_.push_back(std::move(frame.way_signature));
      frames_.push_back(
          {std::move(frame.info), std::move(frame.signature), std::move(frame.jpeg), {}});
      return;
    }
    ++report().skipped;
    ++sequence.skipped;
    const std::string named = frame.info.source + ": " + frame.error;
    if (sequence.skipped == 1) first_skip_ = named;
    if (std::ssize(report().skipped_names) < kMaxNamedSkips) {
      report().skipped_names.push_back(named);
    }
  }

  // What is kept of a panorama is known once the next one has come.
  void TakeFeatures(DescribedFrame& frame) {
    if (size() % stride_ == 0 && options_.max_samples > 0) {
      samples_.push_back({size(), frame.features});
      if (std::ssize(samples_) > options_.max_samples) ThinSamples();
    }
    const bool is_first = stretches_.empty() ? size() == 0 : size() == stretches_.back().last;
    NodeFeatures before = chooser_.Next(std::move(frame.features));
    if (!is_first) frames_.back().kept = std::move(before);
  }

  // Every other one, from now on as well.
  void ThinSamples() {
    stride_ *= 2;
    std::erase_if(samples_, [&](const Sample& sample) { return sample.panorama % stride_ != 0; });
  }

  // Signatures can be compared when their rows are the same elevations.
  void CheckBand(const DescribedFrame& frame) const {
    if (std::abs(frame.band.top_rad - band_.top_rad) < kBandTolerance_rad &&
        std::abs(frame.band.bottom_rad - band_.bottom_rad) < kBandTolerance_rad) {
      return;
    }
    throw MapError(ErrorCode::kBadSource,
                   result_.sequences.back().name + "/" + frame.info.source +
                       " shows other elevations than the panoramas before it; give a narrower "
                       "band that all of them show, or build a map of each");
  }

  void CheckSequence() const {
    const Sequence& sequence = result_.sequences.back();
    const int usable = sequence.frames - sequence.skipped;
    const std::string counts = "'" + sequence.name + "' has " + std::to_string(usable) +
                               (usable == 1 ? " usable panorama" : " usable panoramas") + " of " +
                               std::to_string(sequence.frames) +
                               (sequence.frames == 1 ? " frame" : " frames");
    const std::string first = first_skip_.empty() ? "" : " (first: " + first_skip_ + ")";
    if (usable < kFewestPanoramas) {
      throw MapError(ErrorCode::kBadSource,
                     counts + first + "; a sequence takes two at least, one after the other");
    }
    if (sequence.skipped > options_.max_skipped_share * sequence.frames) {
      throw MapError(ErrorCode::kBadSource,
                     counts + first + "; give panoramas of one size that show something");
    }
  }

  void FollowAll() {
    const Clock::time_point start = Clock::now();
    for (size_t s = 0; s < stretches_.size(); ++s) {
      const auto go_on = GoOn("odometry", static_cast<int>(s), static_cast<int>(stretches_.size()));
      go_on();
      const auto [first, last] = stretches_[s];
      ways_.push_back(FollowPanoramas({signatures_.begin() + first, signatures_.begin() + last},
                                      band_, options_.odometry, go_on));
      report().uncertain += ways_.back().uncertain;
    }
    report().odometry_s = SecondsSince(start);
  }

  LoopClosure Close() {
    const Clock::time_point start = Clock::now();
    const auto go_on = GoOn("loops", 0, 1);
    go_on();
    LoopClosure closure =
        CloseLoops(signatures_, band_, stretches_, ways_, options_.odometry, options_.loops, go_on);
    report().loop_candidates = closure.candidates;
    report().loops_certain = closure.certain;
    report().loops_supported = static_cast<int>(closure.loops.size());
    report().loops_s = SecondsSince(start);
    return closure;
  }

  // Start of the optimisation: each sequence where its surest loop to those before it puts it.
  void LayOut(const LoopClosure& closure) {
    double lowest = 0;
    for (size_t s = 0; s < stretches_.size(); ++s) {
      Pose2 layer_from_first;
      const PanoramaRelation* tie = s == 0 ? nullptr : SurestTie(closure, static_cast<int>(s));
      if (tie != nullptr) {
        layer_from_first = report().odometry[tie->a] * tie->a_from_b *
                           Inverse(ways_[s].poses[tie->b - stretches_[s].first]);
      } else if (s > 0) {
        layer_from_first.y = lowest - Top(ways_[s]) - kGapSteps * ways_[s].mean_step;
      }
      for (const Pose2& pose : ways_[s].poses) {
        report().odometry.push_back(layer_from_first * pose);
        lowest = std::min(lowest, report().odometry.back().y);
      }
    }
  }

  static double Top(const VisualOdometry& way) {
    double top = 0;
    for (const Pose2& pose : way.poses) top = std::max(top, pose.y);
    return top;
  }

  // The loop of the least deviation from a sequence before it.
  const PanoramaRelation* SurestTie(const LoopClosure& closure, int s) const {
    const PanoramaRelation* surest = nullptr;
    for (const PanoramaRelation& loop : closure.loops) {
      if (loop.a >= stretches_[s].first || loop.b < stretches_[s].first ||
          loop.b >= stretches_[s].last) {
        continue;
      }
      if (surest == nullptr || loop.heading.deviation_rad < surest->heading.deviation_rad) {
        surest = &loop;
      }
    }
    return surest;
  }

  void Optimise(LoopClosure& closure) {
    const Clock::time_point start = Clock::now();
    GoOn("poses", 0, 1)();
    report().poses = report().odometry;
    if (closure.loops.empty()) return;
    std::vector<PoseEdge> edges;
    for (size_t s = 0; s < stretches_.size(); ++s) {
      for (PoseEdge edge : ways_[s].edges) {
        edge.a += stretches_[s].first;
        edge.b += stretches_[s].first;
        edges.push_back(edge);
      }
    }
    const size_t of_odometry = edges.size();
    edges.insert(edges.end(), closure.edges.begin(), closure.edges.end());
    PoseGraphResult optimised = OptimisePoseGraph(report().odometry, edges, options_.graph);
    report().poses = std::move(optimised.poses);
    std::vector<PanoramaRelation> kept;
    for (size_t i = 0; i < closure.loops.size(); ++i) {
      if (!optimised.rejected[of_odometry + i]) kept.push_back(closure.loops[i]);
    }
    report().loops_rejected = static_cast<int>(closure.loops.size() - kept.size());
    closure.loops = std::move(kept);
    report().graph_s = SecondsSince(start);
  }

  void MakeNodes() {
    const std::vector<bool> keep =
        KeepInformative(signatures_, report().poses, stretches_, options_.redundancy);
    for (int i = 0; i < size(); ++i) {
      if (!keep[i]) continue;
      kept_.push_back(i);
      AppearanceNode node;
      node.id = AppearanceNodeId{std::ssize(kept_)};
      node.sequence = result_.sequences[StretchOf(i)].id;
      node.frame = frames_[i].info.number;
      node.source = frames_[i].info.source;
      node.time_s = frames_[i].info.time_s;
      node.pose = report().poses[i];
      node.signature = frames_[i].signature;
      node.jpeg = std::move(frames_[i].jpeg);
      node.features = std::move(frames_[i].kept);
      result_.layer.nodes.push_back(std::move(node));
    }
    result_.layer.dropped = size() - static_cast<int>(kept_.size());
    report().dropped = result_.layer.dropped;
  }

  void HandOutSamples() {
    for (Sample& sample : samples_) {
      const int i = sample.panorama;
      const auto kept = std::lower_bound(kept_.begin(), kept_.end(), i);
      const bool is_node = kept != kept_.end() && *kept == i;
      result_.samples.push_back({frames_[i].signature, std::move(sample.features),
                                 report().poses[i],
                                 is_node ? static_cast<int>(kept - kept_.begin()) : -1});
    }
  }

  size_t StretchOf(int i) const {
    size_t s = 0;
    while (i >= stretches_[s].last) ++s;
    return s;
  }

  // By the steps of the odometry between two panoramas of one sequence: a_from_b and its deviation.
  AppearanceEdge BySteps(int a, int b) const {
    AppearanceEdge edge;
    const size_t s = StretchOf(a);
    double variance = 0;
    for (int i = std::min(a, b); i < std::max(a, b); ++i) {
      const PanoramaRelation& step = ways_[s].steps[i - stretches_[s].first];
      edge.a_from_b = edge.a_from_b * step.a_from_b;
      variance += step.heading.deviation_rad * step.heading.deviation_rad;
    }
    if (a > b) edge.a_from_b = Inverse(edge.a_from_b);
    edge.deviation_rad = std::sqrt(variance);
    return edge;
  }

  // Where in kept_ the kept panorama of the same sequence is that is nearest in it.
  int NearestKept(int i) const {
    const auto after = std::lower_bound(kept_.begin(), kept_.end(), i);
    const int next = static_cast<int>(after - kept_.begin());
    if (*after == i || next == 0) return next;  // the ends of sequences are always kept
    return *after - i <= i - kept_[next - 1] ? next : next - 1;
  }

  void MakeEdges(const LoopClosure& closure) {
    Relations edges;
    for (int k = 0; k + 1 < std::ssize(kept_); ++k) {
      if (StretchOf(kept_[k]) != StretchOf(kept_[k + 1])) continue;
      edges[{k, k + 1}] = BySteps(kept_[k], kept_[k + 1]);
    }
    for (const PanoramaRelation& loop : closure.loops) AddLoop(loop, edges);
    for (auto& [ends, edge] : edges) {
      const auto& nodes = result_.layer.nodes;
      edge.a = nodes[ends.first].id;
      edge.b = nodes[ends.second].id;
      edge.distance = SignatureDistance(nodes[ends.first].signature, nodes[ends.second].signature,
                                        options_.odometry.k1);
      result_.layer.edges.push_back(edge);
    }
  }

  // Loops of dropped panoramas go over to the kept ones beside them.
  void AddLoop(const PanoramaRelation& loop, Relations& edges) const {
    const int a = NearestKept(loop.a);
    const int b = NearestKept(loop.b);
    if (a >= b || edges.contains({a, b})) return;
    const AppearanceEdge to_a = BySteps(kept_[a], loop.a);
    const AppearanceEdge from_b = BySteps(loop.b, kept_[b]);
    AppearanceEdge edge;
    edge.kind = AppearanceEdgeKind::kLoop;
    edge.a_from_b = to_a.a_from_b * loop.a_from_b * from_b.a_from_b;
    edge.deviation_rad =
        std::hypot(to_a.deviation_rad, loop.heading.deviation_rad, from_b.deviation_rad);
    edges[{a, b}] = edge;
  }

  bool Report(const std::string& stage, int done, int total) const {
    return !progress_ || progress_(stage, done, total);
  }

  [[noreturn]] static void Interrupt() {
    throw MapError(ErrorCode::kInterrupted, "stopped; nothing was written");
  }

  // What stops a stage on the way, from whichever of its threads.
  std::function<void()> GoOn(const std::string& stage, int done, int total) {
    return [this, stage, done, total] {
      const std::lock_guard lock(reporting_);
      if (!Report(stage, done, total)) Interrupt();
    };
  }

  const AppearanceOptions& options_;
  const AppearanceProgress& progress_;
  std::vector<FourierSignature> signatures_;  // by which odometry and loops are measured
  std::vector<TakenFrame> frames_;
  NodeFeatureChooser chooser_;
  std::vector<Sample> samples_;
  int stride_ = 1;  // every so-manieth panorama is a sample
  std::vector<PanoramaStretch> stretches_;
  std::vector<VisualOdometry> ways_;
  std::vector<int> kept_;  // panoramas that became nodes
  ElevationBand band_;
  std::mutex reporting_;  // one call at a time
  std::string first_skip_;
  AppearanceResult result_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace

void AppearanceOptions::Check() const {
  describe.Check();
  odometry.Check();
  loops.Check();
  graph.Check();
  redundancy.Check();
  CheckRange("max_skipped_share", max_skipped_share, 0, 1);
  CheckRange("max_samples", max_samples, 0, 100'000);
}

AppearanceResult BuildAppearanceLayer(const std::vector<Source*>& sources,
                                      const AppearanceOptions& options,
                                      const AppearanceProgress& progress) {
  options.Check();
  if (sources.empty()) throw MapError(ErrorCode::kBadSource, "no source given; give one at least");
  cv::setNumThreads(1);  // frames are what runs in parallel
  LayerBuilder builder(options, progress);
  for (Source* source : sources) builder.AddSource(*source);
  return builder.Finish();
}

}  // namespace waystone
