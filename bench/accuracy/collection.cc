// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>

#include "bench/accuracy/collection_scenes.h"
#include "bench/accuracy/common.h"
#include "bench/accuracy/stopwatch.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/search/inverted_file.h"
#include "localizer/coarse/coarse_index.h"

namespace waystone::bench {
namespace {

constexpr int kPiecePlaces = 12;    // a map of the collection
constexpr int kProposed = 10;       // among which the right one must be
constexpr double kSameShare = 0.2;  // of a look-alike's features, shared with its model
constexpr int kLearningScenes = 8;
constexpr int kLearningRows = 400'000;
constexpr double kSiftNoise = 4;
constexpr double kFlippedShare = 0.08;  // of the bits of binary descriptors

// ---- learning

// The rows with zeros instead of the other half.
Descriptors HalfRows(FeatureType type, const Descriptors& rows, int half) {
  const int cut = Vocabulary::FirstHalf(type);
  std::vector<uint8_t> data = rows.data();
  for (size_t i = 0; i < data.size(); ++i) {
    const bool first = static_cast<int>(i % rows.bytes()) < cut;
    if (first != (half == 0)) data[i] = 0;
  }
  return {rows.bytes(), std::move(data)};
}

// 256 prototypes per half, as in words.bin.
Descriptors LearnPrototypes(FeatureType type) {
  Descriptors all = RenderedDescriptors(type, kLearningScenes);
  Random random(1);
  Descriptors rows(all.bytes());
  const double share = static_cast<double>(kLearningRows) / all.rows();
  for (int i = 0; i < all.rows(); ++i) {
    if (random.Uniform() < share) rows.Append(all.row(i));
  }
  InvertedFileOptions options;
  options.min_rows = 1;
  options.lists_per_root = Vocabulary::kPrototypes / std::sqrt(static_cast<double>(rows.rows()));
  options.training_rows = rows.rows() / Vocabulary::kPrototypes;
  options.rounds = 25;
  std::vector<uint8_t> prototypes(static_cast<size_t>(Vocabulary::kPrototypes) * rows.bytes(), 0);
  for (int half = 0; half < 2; ++half) {
    const InvertedFile file = BuildInvertedFile(HalfRows(type, rows, half), type, options);
    if (file.centres.rows() != Vocabulary::kPrototypes) {
      throw MapError(ErrorCode::kInternal, "too few descriptors to learn words from");
    }
    for (size_t i = 0; i < prototypes.size(); ++i) prototypes[i] |= file.centres.data()[i];
  }
  return {rows.bytes(), std::move(prototypes)};
}

int Learn(const std::string& file) {
  std::ofstream out(file, std::ios::binary);
  for (const FeatureType type : {FeatureType::kSift, FeatureType::kOrb, FeatureType::kAkaze}) {
    const Descriptors prototypes = LearnPrototypes(type);
    out.write(reinterpret_cast<const char*>(prototypes.data().data()),
              static_cast<std::streamsize>(prototypes.data().size()));
    std::printf("%s learned\n", std::string(NameOf(type)).c_str());
  }
  out.close();
  return out ? 0 : 3;
}

// ---- the collection

// Descriptors like those of a pool: parts of two of them, each in its place, or one of them as it
// would be on another day; with noise on top.
class LookAlikes {
 public:
  LookAlikes(FeatureType type, uint64_t seed) : type_(type), random_(seed) {}

  std::vector<uint8_t> Make(const Descriptors& pool) {
    const auto pick = [&] { return pool.row(random_.Below(pool.rows())); };
    const uint8_t* a = pick();
    std::vector<uint8_t> made(a, a + pool.bytes());
    if (random_.Uniform() >= kSameShare) {
      const uint8_t* b = pick();
      const int cells = type_ == FeatureType::kSift ? 8 : 1;
      for (int i = 0; i < pool.bytes(); i += cells) {
        if (random_.Below(2) == 0) std::copy_n(b + i, std::min(cells, pool.bytes() - i), &made[i]);
      }
    }
    for (uint8_t& byte : made) Disturb(byte);
    return made;
  }

 private:
  void Disturb(uint8_t& byte) {
    if (type_ == FeatureType::kSift) {
      const double noisy = byte + kSiftNoise * random_.Normal();
      byte = static_cast<uint8_t>(std::clamp<long>(std::lround(noisy), 0, 127));
      return;
    }
    for (int bit = 0; bit < 8; ++bit) {
      if (random_.Uniform() < kFlippedShare) byte ^= static_cast<uint8_t>(1 << bit);
    }
  }

  FeatureType type_;
  Random random_;
};

// A map of the collection: a part of a scene's.
struct Piece {
  int scene = 0;
  int from = 0;
  int to = 0;
};

std::vector<Piece> CutScenes(const std::vector<CollectionScene>& scenes) {
  std::vector<Piece> pieces;
  for (int s = 0; s < static_cast<int>(scenes.size()); ++s) {
    const int places = scenes[s].entry.places();
    const int count = std::max(1, (places + kPiecePlaces / 2) / kPiecePlaces);
    for (int i = 0; i < count; ++i) {
      pieces.push_back({s, places * i / count, places * (i + 1) / count});
    }
  }
  return pieces;
}

std::string PieceName(int piece) { return "piece " + std::to_string(piece); }

// An entry like a piece, of other places.
CoarseEntry MakeLookAlike(const CollectionScene& scene, const Piece& piece, uint64_t seed) {
  CoarseEntry entry = PlacesOf(scene.entry, piece.from, piece.to);
  LookAlikes look_alikes(entry.feature_type, seed);
  const Vocabulary& words = Vocabulary::Of(entry.feature_type);
  for (int i = 0; i < entry.codes(); ++i) {
    const WordCode code = words.Encode(look_alikes.Make(scene.pool).data());
    entry.words[i] = code.word;
    entry.signatures[i] = code.signature;
  }
  return entry;
}

// ---- measuring

struct Found {
  int asked = 0;
  int first = 0;
  int among = 0;      // the first kProposed
  int localized = 0;  // that the map alone localizes, and how many of them are among these
  int localized_among = 0;
};

nlohmann::ordered_json ToJson(const Found& found) {
  return {{"asked", found.asked},
          {"first", found.first},
          {"among_10", found.among},
          {"share", static_cast<double>(found.among) / std::max(1, found.asked)},
          {"localized", found.localized},
          {"localized_among_10", found.localized_among},
          {"localized_share",
           static_cast<double>(found.localized_among) / std::max(1, found.localized)}};
}

bool Shows(const Piece& piece, int scene, const CollectionQuery& query) {
  return piece.scene == scene && std::ranges::any_of(query.places, [&](int place) {
           return place >= piece.from && place < piece.to;
         });
}

nlohmann::ordered_json Measure(const std::vector<CollectionScene>& scenes,
                               const std::vector<Piece>& pieces, std::vector<CoarseIndex::Map> maps,
                               const CoarseOptions& options) {
  std::map<std::string, int> piece_of;
  for (int i = 0; i < static_cast<int>(pieces.size()); ++i) piece_of[PieceName(i)] = i;
  const Stopwatch building;
  const CoarseIndex index(std::move(maps), options);
  const double build_s = building.cpu_s();
  std::map<std::string, Found> of_kind;
  std::map<std::string, Found> of_scene;
  Found all;
  std::vector<double> ms;
  for (int s = 0; s < static_cast<int>(scenes.size()); ++s) {
    for (const CollectionQuery& query : scenes[s].queries) {
      const Stopwatch watch;
      const auto proposals = index.Propose({query.descriptors}, kProposed);
      ms.push_back(1e3 * watch.cpu_s());
      Found found{1, 0, 0, query.localized, 0};
      for (size_t i = 0; i < proposals.size(); ++i) {
        const auto piece = piece_of.find(index.maps()[proposals[i].map].name);
        if (piece == piece_of.end() || !Shows(pieces[piece->second], s, query)) continue;
        found.among = 1;
        found.localized_among = found.localized;
        found.first |= i == 0;
      }
      for (Found* sum : {&all, &of_kind[scenes[s].kind], &of_scene[scenes[s].name]}) {
        sum->asked += found.asked;
        sum->first += found.first;
        sum->among += found.among;
        sum->localized += found.localized;
        sum->localized_among += found.localized_among;
      }
    }
  }
  nlohmann::ordered_json json = {
      {"maps", index.maps().size()},
      {"places", index.places()},
      {"bytes_a_place", static_cast<double>(index.bytes()) / static_cast<double>(index.places())},
      {"index_s", build_s},
      {"median_ms", Quantile(ms, 0.5)},
      {"p95_ms", Quantile(ms, 0.95)},
      {"found", ToJson(all)}};
  for (const auto& [kind, found] : of_kind) json["kinds"][kind] = ToJson(found);
  for (const auto& [name, found] : of_scene) {
    if (found.asked > 0 && found.among < found.asked) json["scenes"][name] = ToJson(found);
  }
  return json;
}

void PrintSize(const nlohmann::ordered_json& json) {
  std::printf("%6d maps, %7d places, %4.0f bytes a place, %5.2f ms (95%%: %5.2f), index %.2f s:",
              json["maps"].get<int>(), json["places"].get<int>(),
              json["bytes_a_place"].get<double>(), json["median_ms"].get<double>(),
              json["p95_ms"].get<double>(), json["index_s"].get<double>());
  for (const auto& [kind, found] : json["kinds"].items()) {
    std::printf("  %s %d first, %d among 10 of %d (localized: %d of %d)", kind.c_str(),
                found["first"].get<int>(), found["among_10"].get<int>(), found["asked"].get<int>(),
                found["localized_among_10"].get<int>(), found["localized"].get<int>());
  }
  std::printf("\n");
  if (json.contains("scenes")) std::printf("    not all of: %s\n", json["scenes"].dump().c_str());
  (void)std::fflush(stdout);
}

std::vector<CollectionScene> CollectScenes(const std::string& data, int buildings, int flats,
                                           FeatureType type) {
  std::vector<CollectionScene> scenes;
  for (int seed = 1; seed <= buildings; ++seed) {
    for (CollectionScene& scene : RenderBuilding(seed, type)) scenes.push_back(std::move(scene));
  }
  for (int seed = 1; seed <= flats; ++seed) scenes.push_back(RenderFlatScene(seed, type));
  if (!data.empty()) {
    for (CollectionScene& scene : ReadRealScenes(data, type)) scenes.push_back(std::move(scene));
  }
  return scenes;
}

}  // namespace

int RunCollection(const Args& raw) {
  Args args = raw;
  const std::string learned = TakeOption(args, "learn", "");
  if (!learned.empty()) return Learn(learned);
  const int buildings = std::stoi(TakeOption(args, "buildings", "12"));
  const int flats = std::stoi(TakeOption(args, "flats", "8"));
  const std::vector<int> sizes = ParseNumbers(TakeOption(args, "maps", "100,1000,10000"), ',');
  const std::string features = TakeOption(args, "features", "sift");
  CoarseOptions options;
  options.probes = std::stoi(TakeOption(args, "probes", std::to_string(options.probes)));
  options.max_distance =
      std::stoi(TakeOption(args, "distance", std::to_string(options.max_distance)));
  options.window = std::stoi(TakeOption(args, "window", std::to_string(options.window)));
  if (args.size() > 1) {
    throw MapError(ErrorCode::kUsage,
                   "collection takes a folder with data, --learn FILE, --buildings N, --flats N, "
                   "--maps N,N,..., --features TYPE, --probes N, --distance N and --window N");
  }
  const std::string data = args.empty() ? "" : args[0];
  const FeatureType type = FeatureTypeByName(features);
  const std::vector<CollectionScene> scenes = CollectScenes(data, buildings, flats, type);
  const std::vector<Piece> pieces = CutScenes(scenes);
  std::vector<CoarseIndex::Map> maps;
  for (int i = 0; i < static_cast<int>(pieces.size()); ++i) {
    maps.push_back(
        {PieceName(i), std::make_shared<CoarseEntry>(
                           PlacesOf(scenes[pieces[i].scene].entry, pieces[i].from, pieces[i].to))});
  }
  nlohmann::ordered_json json = {
      {"bench", "collection"}, {"features", features}, {"pieces", pieces.size()}};
  for (const int size : sizes) {
    while (std::ssize(maps) < size) {
      const Piece& like = pieces[maps.size() % pieces.size()];
      maps.push_back(
          {"look-alike " + std::to_string(maps.size()),
           std::make_shared<CoarseEntry>(MakeLookAlike(scenes[like.scene], like, maps.size()))});
    }
    json["runs"].push_back(Measure(scenes, pieces, maps, options));
    PrintSize(json["runs"].back());
  }
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
