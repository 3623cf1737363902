// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/files/power_loss.h"

#include <algorithm>
#include <utility>

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr size_t kSectorBytes = 512;

// A file whatever its name is.
struct DiskFile {
  std::string synced;
  std::vector<FileCall> pending;  // writes and truncations since
};

void Apply(const FileCall& call, std::string& bytes) {
  const auto at = static_cast<size_t>(call.at);
  if (call.kind == FileCallKind::kTruncate) return bytes.resize(at);
  bytes.resize(std::max(bytes.size(), at + call.bytes.size()));
  bytes.replace(at, call.bytes.size(), call.bytes);
}

// Some of the pending calls, in any order; of a write perhaps only the first sectors.
std::string AfterLoss(const DiskFile& file, Random& random) {
  std::vector<FileCall> kept;
  const int share = random.Below(5);  // of the calls that are lost, in quarters
  for (const FileCall& call : file.pending) {
    if (random.Below(4) < share) continue;
    kept.push_back(call);
    const size_t sectors = call.bytes.size() / kSectorBytes;
    if (sectors > 1 && random.Below(8) == 0) {
      kept.back().bytes.resize(kSectorBytes * random.Below(static_cast<int>(sectors)));
    }
  }
  if (random.Below(2) == 0) {
    for (size_t i = kept.size(); i > 1; --i) {
      std::swap(kept[i - 1], kept[random.Below(static_cast<int>(i))]);
    }
  }
  std::string bytes = file.synced;
  for (const FileCall& call : kept) Apply(call, bytes);
  return bytes;
}

// The folder's names and its files, as the calls go along.
class Disk {
 public:
  explicit Disk(const DiskState& before) {
    for (const auto& [path, bytes] : before) now_[path] = Add(bytes);
    synced_ = now_;
  }

  void Do(const FileCall& call) {
    switch (call.kind) {
      case FileCallKind::kOpen:
        if (!fs::is_directory(call.path) && !now_.contains(call.path)) now_[call.path] = Add("");
        history_.push_back(now_);
        break;
      case FileCallKind::kRead:
        break;
      case FileCallKind::kWrite:
      case FileCallKind::kTruncate:
        files_[now_.at(call.path)].pending.push_back(call);
        break;
      case FileCallKind::kSync:
        Sync(call.path);
        break;
      case FileCallKind::kRename:
        now_[call.to] = now_.at(call.path);
        now_.erase(call.path);
        history_.push_back(now_);
        break;
    }
  }

  DiskState AfterPowerLoss(Random& random) const {
    const int names = random.Below(static_cast<int>(history_.size()) + 1);
    DiskState state;
    for (const auto& [path, file] : names == 0 ? synced_ : history_[names - 1]) {
      state[path] = AfterLoss(files_[file], random);
    }
    return state;
  }

 private:
  using Names = std::map<fs::path, size_t>;  // numbers of files

  size_t Add(const std::string& bytes) {
    files_.push_back({bytes, {}});
    return files_.size() - 1;
  }

  void Sync(const fs::path& path) {
    const auto it = now_.find(path);
    if (it == now_.end()) {  // the folder
      synced_ = now_;
      history_.clear();
      return;
    }
    DiskFile& file = files_[it->second];
    for (const FileCall& call : std::exchange(file.pending, {})) Apply(call, file.synced);
  }

  std::vector<DiskFile> files_;
  Names now_;
  Names synced_;
  std::vector<Names> history_;  // since the folder was synced
};

}  // namespace

DiskState StateAfterPowerLoss(const DiskState& before, std::span<const FileCall> calls,
                              Random& random) {
  Disk disk(before);
  for (const FileCall& call : calls) disk.Do(call);
  return disk.AfterPowerLoss(random);
}

}  // namespace waystone
