// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/answer_json.h"
#include "cli/commands/asked_server.h"
#include "cli/commands/commands.h"
#include "cli/files/finite.h"
#include "cli/files/map_file.h"
#include "cli/output/answer_text.h"
#include "cli/system/signals.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/image/encode.h"
#include "localizer/session.h"

namespace waystone {
namespace {

struct WatchFlags {
  std::string map;
  std::string source;
  double every_s = 1;
  int count = 0;  // answers; 0: until the end
  bool json = false;
  ServerFlags server;
};

// A camera, whose clock is ours and which gives its newest frame, or a video file, whose clock is
// its own and of which no frame is missed for being slow.
class Eye {
 public:
  explicit Eye(const std::string& source)
      : camera_(!source.empty() && std::all_of(source.begin(), source.end(),
                                               [](unsigned char c) { return std::isdigit(c); })) {
    constexpr size_t kMaxDigits = 4;
    if (camera_ && source.size() <= kMaxDigits) {
      capture_.open(std::stoi(source));
      capture_.set(cv::CAP_PROP_BUFFERSIZE, 1);
    } else if (std::filesystem::is_regular_file(source)) {
      capture_.open(source);
    }
    if (!capture_.isOpened()) {
      throw MapError(ErrorCode::kBadSource,
                     source +
                         " can't be opened; use a camera index (starting at 0) or a "
                         "video file that FFmpeg can read");
    }
    constexpr double kMostFrames = 1e6;  // so that the end is found in a moment
    if (!camera_) left_ = std::min(capture_.get(cv::CAP_PROP_FRAME_COUNT), kMostFrames);
    start_ = Clock::now();
  }

  // The next frame at `time_s` or later, in grey, and its time; nothing at the end.
  std::optional<cv::Mat> NextAt(double time_s, double& taken_s) {
    while (!Interrupted() && Grab()) {
      taken_s = TimeOfGrabbed();
      if (taken_s < time_s) continue;
      cv::Mat image;
      if (!capture_.retrieve(image) || image.empty()) continue;
      if (image.channels() == 1) return image;
      cv::Mat grey;
      cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
      return grey;
    }
    return std::nullopt;
  }

 private:
  // False at the end. FFmpeg fails once for each damaged frame, which is passed over, and always
  // after the end.
  bool Grab() {
    while (!capture_.grab()) {
      if (left_-- <= 0) return false;
    }
    --left_;
    return true;
  }

  // Asked between grab and retrieve, when FFmpeg tells the time of the frame that was grabbed.
  double TimeOfGrabbed() const {
    if (!camera_) return capture_.get(cv::CAP_PROP_POS_MSEC) / 1000;
    return std::chrono::duration<double>(Clock::now() - start_).count();
  }

  const bool camera_;
  cv::VideoCapture capture_;
  double left_ = 0;  // frames of a video, by its header, which may be wrong
  Clock::time_point start_;
};

// Where the answers come from: a map file, or a server.
class Oracle {
 public:
  explicit Oracle(const WatchFlags& flags) : flags_(flags) {
    if (flags.server.url.empty()) {
      map_ = OpenMapFile(flags.map, false);
    } else {
      CheckServerFlags(flags.server);
    }
  }

  Json Ask(const cv::Mat& grey, const std::string& name) const {
    if (map_) {
      QueryRequest request;
      request.images.push_back({.name = name, .bytes = {}, .grey = grey});
      return ToJson(OverallAnswer(
          Session(std::move(request), {{map_->name, map_->index}}, LocalizeOptions{}).Ask()));
    }
    const std::vector<uint8_t> bytes = EncodeJpeg(grey);
    return AskServer(flags_.server, flags_.map, name, std::string(bytes.begin(), bytes.end()));
  }

 private:
  const WatchFlags& flags_;
  std::optional<OpenMap> map_;
};

// What every other frame would bring as well: a wrong name of a map, a wrong token.
bool IsMistake(ErrorCode code) {
  return code == ErrorCode::kNotFound || code == ErrorCode::kUnauthorized ||
         code == ErrorCode::kUsage;
}

// A frame that a server gives no answer to, as while it restarts, is named and skipped. A mistake
// in the first query ends it. Returns the exit status, of the first frame that was skipped.
int RunWatch(const WatchFlags& flags) {
  NoteInterrupts();
  const Oracle oracle(flags);
  Eye eye(flags.source);
  double next_s = 0;
  double taken_s = 0;
  int frames = 0;
  int answers = 0;
  int status = 0;
  while (flags.count == 0 || answers < flags.count) {
    const std::optional<cv::Mat> frame = eye.NextAt(next_s, taken_s);
    if (!frame) break;
    ++frames;
    char name[32];
    (void)std::snprintf(name, sizeof name, "%.3f s", taken_s);
    try {
      const Json answer = oracle.Ask(*frame, name);
      std::cout << (flags.json ? Dump(answer) : AnswerLine(answer)) << std::endl;
      ++answers;
    } catch (const MapError& error) {
      if (flags.server.url.empty() || (frames == 1 && IsMistake(error.code()))) throw;
      std::cerr << "waystone: " << name << ": " << Printable(error.what()) << '\n';
      if (status == 0) status = InfoOf(error.code()).exit_code;
    }
    next_s = std::max(next_s + flags.every_s, taken_s + 1e-9);
  }
  if (Interrupted()) return InfoOf(ErrorCode::kInterrupted).exit_code;
  if (frames == 0) {
    throw MapError(ErrorCode::kBadSource, flags.source + " has no frames; check the video file");
  }
  return status;
}

}  // namespace

void AddWatch(CLI::App& app, Run& run) {
  auto flags = std::make_shared<WatchFlags>();
  CLI::App* command = app.add_subcommand(
      "watch", "Localize the frames of a camera or a video, one line per answer");
  command->add_option("map", flags->map, "Map file; with --server the name of a map, or - for all")
      ->required();
  command->add_option("source", flags->source, "Camera index (starting at 0) or video file")
      ->required();
  command->add_option("--every", flags->every_s, "Seconds between queries; 0 for every frame")
      ->capture_default_str()
      ->check(Finite())
      ->check(CLI::Range(0.0, 3600.0));
  command
      ->add_option("--count", flags->count,
                   "Stop after this many answers; 0: at the end of the video")
      ->capture_default_str()
      ->check(CLI::Range(0, 1'000'000'000));
  command->add_flag("--json", flags->json,
                    "Print one JSON object per answer, as the server returns it");
  AddServerFlags(command, flags->server);
  command->footer(
      "Runs until Ctrl-C or the end of the video. Each answer is named by the time of its frame.\n"
      "A wrong map name or token ends it at the first frame. A frame that the server doesn't\n"
      "answer later is named and skipped. The exit status after the last frame is then 3, or 6 if\n"
      "the server's registry or store can't be reached.\n"
      "Example: waystone watch lab.db walk.mp4 --every 0.5\n"
      "         waystone watch lab 0 --server http://robot:8080 --json");
  command->callback([flags, &run] { run = [flags] { return RunWatch(*flags); }; });
}

}  // namespace waystone
