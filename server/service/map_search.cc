// SPDX-License-Identifier: Apache-2.0
#include "server/service/map_search.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>

#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/image/decode.h"
#include "localizer/coarse/coarse_index.h"

namespace waystone {
namespace {

// What answers call the state of a map of a lot.
const char* StateOf(MapFinding finding) {
  switch (finding) {
    case MapFinding::kFound:
      return "asked";
    case MapFinding::kLate:
      return "late";
    case MapFinding::kTooLarge:
      return "too_large";
    case MapFinding::kFailed:
      return "failed";
  }
  return "failed";
}

// The images of a request as the coarse index needs them. A thread may still describe them when
// nobody waits for it any longer, so this holds all that it needs.
struct Proposing {
  QueryRequest request;
  std::shared_ptr<const CoarseIndex> index;
  std::vector<bool> left_out;
  LocalizeOptions options;

  std::vector<CoarseIndex::Proposal> Propose();
  std::vector<CoarseDescriptors> Describe(QueryImage& image) const;
};

// Nothing for bytes that aren't an image: every map's answer says so.
std::vector<CoarseDescriptors> Proposing::Describe(QueryImage& image) const {
  try {
    const auto* bytes = reinterpret_cast<const uint8_t*>(image.bytes.data());
    const cv::Mat grey = DecodeGrey({bytes, image.bytes.size()}, options.limits);
    return DescribeForCoarse(grey, index->Needs(), options.planes, options.panorama,
                             *image.features);
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage && error.code() != ErrorCode::kImageTooLarge) throw;
    return {};
  }
}

std::vector<CoarseIndex::Proposal> Proposing::Propose() {
  std::vector<std::vector<CoarseDescriptors>> images;
  for (QueryImage& image : request.images) images.push_back(Describe(image));
  return index->Propose(images, kMaxSearched, left_out);
}

// Maps of the index that aren't in the scope.
std::vector<bool> LeftOut(const SearchScope& scope) {
  std::vector<bool> left_out;
  for (const CoarseIndex::Map& map : scope.coarse->maps()) {
    left_out.push_back(!std::ranges::binary_search(scope.names, map.name));
  }
  return left_out;
}

class Search {
 public:
  Search(const QueryRequest& request, const SearchScope& scope, const LocalizeOptions& options,
         MapSource& maps, QueryGate& gate, TimedQueries& computing)
      : scope_(scope), options_(options), maps_(maps), gate_(gate), computing_(computing) {
    proposing_->request = request;
    for (QueryImage& image : proposing_->request.images) {
      image.features = std::make_shared<ImageFeatures>();
    }
    proposing_->index = scope.coarse;
    proposing_->left_out = LeftOut(scope);
    proposing_->options = options;
    if (request.deadline_ms) {
      deadline_ =
          request.received.value_or(Clock::now()) + std::chrono::milliseconds(*request.deadline_ms);
    }
  }

  SearchAnswer Run() {
    result_.unindexed = scope_.unindexed;
    result_.camera = ResolveCamera(proposing_->request, {}, proposing_->request.images.front());
    if (!ProposeInTime()) return WithoutMaps(Stage::kQueue);
    std::vector<std::string> names;
    for (const SearchedMap& one : result_.searched) names.push_back(one.name);
    for (std::span<const std::string> left = names; !left.empty();) {
      left = left.subspan(AskLot(left));
    }
    if (lots_.empty()) return WithoutMaps(Stage::kShortlist);
    result_.answer = Joined(std::move(lots_));
    return std::move(result_);
  }

 private:
  bool ProposeInTime() {
    std::optional<QueryGate::Turn> turn = gate_.Enter(deadline_);
    if (!turn) return false;
    const auto proposals = computing_.Run<std::vector<CoarseIndex::Proposal>>(
        deadline_, std::move(*turn), [proposing = proposing_] { return proposing->Propose(); });
    if (!proposals) return false;
    for (const CoarseIndex::Proposal& one : *proposals) {
      result_.searched.push_back({scope_.coarse->maps()[one.map].name, "", one.score, ""});
    }
    AddPreviousMap();
    result_.proposed = true;
    return true;
  }

  // The map where the client was before is always asked, if need be instead of the last proposal.
  void AddPreviousMap() {
    const std::optional<MapHints>& hints = proposing_->request.hints;
    if (!hints || !hints->previous_map) return;
    const std::string& name = *hints->previous_map;
    const bool known = std::ranges::binary_search(scope_.names, name);
    if (!known || std::ranges::count(result_.searched, name, &SearchedMap::name) > 0) return;
    if (std::ssize(result_.searched) == kMaxSearched) result_.searched.pop_back();
    result_.searched.push_back({name, "", 0, ""});
  }

  // Asks the next maps that can be had at the same time; returns how many.
  size_t AskLot(std::span<const std::string> names) {
    const std::vector<FoundMap> found = maps_.FindLot(names, deadline_);
    std::vector<QueriedMap> queried;
    for (const FoundMap& one : found) {
      SearchedMap& told = TellOf(one.name);
      told.state = StateOf(one.finding);
      told.message = one.error;
      if (one.map) queried.push_back({one.name, one.map->shared_index()});
    }
    if (queried.empty()) return found.size();
    const auto session =
        std::make_shared<const Session>(proposing_->request, std::move(queried), options_, true);
    std::optional<QueryGate::Turn> turn = gate_.Enter(deadline_);
    lots_.push_back(turn ? computing_.Ask(session, std::move(*turn)) : session->TimeOut());
    TellLate(lots_.back(), result_.searched);
    return found.size();
  }

  SearchedMap& TellOf(const std::string& name) {
    return *std::ranges::find(result_.searched, name, &SearchedMap::name);
  }

  // The answer when no map was asked.
  SearchAnswer WithoutMaps(Stage last) {
    const bool proposed = !result_.searched.empty();
    if (proposed && !deadline_) {
      const SearchedMap& first = result_.searched.front();
      throw MapError(ErrorCode::kNotReady, "none of the proposed maps can be had now (" +
                                               first.name + ": " + first.message + ")");
    }
    for (const QueryImage& image : proposing_->request.images) {
      Answer answer = proposed || last == Stage::kQueue ? Undecided(last) : Unlike(image);
      answer.image = image.name;
      result_.answer.images.push_back({std::move(answer)});
    }
    return std::move(result_);
  }

  // The answer to an image that resembles nothing in the index.
  Answer Unlike(const QueryImage& image) const {
    try {
      const auto* bytes = reinterpret_cast<const uint8_t*>(image.bytes.data());
      CheckLimits(ReadImageHeader({bytes, image.bytes.size()}), options_.limits);
    } catch (const MapError& error) {
      if (error.code() == ErrorCode::kBadImage || error.code() == ErrorCode::kImageTooLarge) {
        return RefuseImage(error);
      }
      throw;
    }
    Answer answer;
    answer.decided_by = DecidedBy::kShortlistVotes;
    answer.message = "no map in the coarse index resembles this image";
    return answer;
  }

  const SearchScope& scope_;
  const LocalizeOptions& options_;
  MapSource& maps_;
  QueryGate& gate_;
  TimedQueries& computing_;
  std::shared_ptr<Proposing> proposing_ = std::make_shared<Proposing>();
  MapSource::Deadline deadline_;
  std::vector<RequestAnswer> lots_;
  SearchAnswer result_;
};

}  // namespace

FoundMaps FindMaps(const SearchScope& scope, const MapSource::Deadline& deadline, MapSource& maps) {
  FoundMaps result;
  std::optional<FoundMap> failed;
  for (std::span<const std::string> left = scope.names; !left.empty();) {
    const std::vector<FoundMap> lot = maps.FindLot(left, deadline);
    left = left.subspan(lot.size());
    for (const FoundMap& one : lot) {
      if (one.code == ErrorCode::kNotFound) continue;  // removed meanwhile
      result.searched.push_back({one.name, StateOf(one.finding), 0, one.error});
      if (one.map) {
        result.queried.push_back({one.name, one.map->shared_index()});
      } else if (!failed) {
        failed = one;
      }
    }
  }
  if (!result.queried.empty()) return result;
  if (!failed) throw MapError(ErrorCode::kNotReady, "all maps were removed just now; try again");
  throw MapError(failed->code,
                 "no map can be had now (" + failed->name + ": " + failed->error + ")");
}

void TellLate(const RequestAnswer& answer, std::vector<SearchedMap>& searched) {
  for (const std::vector<Answer>& answers : answer.images) {
    for (const Answer& one : answers) {
      if (one.verdict != Verdict::kUndecided) continue;
      const auto told = std::ranges::find(searched, one.map, &SearchedMap::name);
      if (told != searched.end()) told->state = "late";
    }
  }
}

bool IsPartial(const std::vector<SearchedMap>& searched) {
  return std::ranges::any_of(searched, [](const SearchedMap& one) { return one.state != "asked"; });
}

bool SearchAnswer::IsPartial() const { return !proposed || waystone::IsPartial(searched); }

SearchAnswer SearchMaps(const QueryRequest& request, const SearchScope& scope,
                        const LocalizeOptions& options, MapSource& maps, QueryGate& gate,
                        TimedQueries& computing) {
  return Search(request, scope, options, maps, gate, computing).Run();
}

}  // namespace waystone
