// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_store.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <map>
#include <thread>

#include "schema/file/map_database.h"
#include "schema/file/sha256.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

MapData RoundTrip(const MapData& map) {
  const TemporaryFolder folder;
  WriteMap(map, folder / "m.db", {});
  return ReadMap(folder / "m.db");
}

TEST(MapStore, ReadsWhatWasWritten) {
  for (uint64_t seed = 0; seed < 40; ++seed) {
    MapShape shape;
    shape.keyframes = 1 + static_cast<int>(seed % 9);
    shape.planes = static_cast<int>(seed % 7);
    shape.type = static_cast<FeatureType>(seed % 3);
    const MapData map = MadeMap(seed, shape);
    EXPECT_EQ(WithoutVersion(RoundTrip(map)), map) << "seed " << seed;
  }
}

TEST(MapStore, ReadsBlobsOfManyPages) {
  MapShape shape;
  shape.max_features = 3000;
  shape.jpeg_bytes = 200'000;
  const MapData map = MadeMap(3, shape);
  EXPECT_EQ(WithoutVersion(RoundTrip(map)), map);
}

TEST(MapStore, ReadsAnEmptyMap) { EXPECT_EQ(WithoutVersion(RoundTrip({})), MapData()); }

TEST(MapStore, APlaneWithoutFeaturesNeedsNoDescriptorSize) {
  MapData map = MadeMap(4);
  map.planes[0].features.clear();
  map.planes[0].descriptors = Descriptors();
  map.index.reset();
  map.poses.reset();
  const MapData read = RoundTrip(map);
  EXPECT_EQ(read.planes[0].descriptors.rows(), 0);
  EXPECT_EQ(read.planes[0].views, map.planes[0].views);
}

TEST(MapStore, LeavesImagesOutWhenAsked) {
  const TemporaryFolder folder;
  MapData map = MadeMap(5);
  WriteMap(map, folder / "m.db", {});
  for (Keyframe& keyframe : map.keyframes) keyframe.picture.clear();
  for (AppearanceNode& node : map.appearance->nodes) node.picture.clear();
  for (OrientationNode& node : map.orientation->nodes) node.picture.clear();
  EXPECT_EQ(WithoutVersion(ReadMap(folder / "m.db", {.images = false})), map);
}

TEST(MapStore, SameDataSameBytes) {
  const TemporaryFolder folder;
  const TemporaryFolder other;
  const MapData map = MadeMap(6);
  WriteMap(map, folder / "a.db", {});
  const std::vector<uint8_t> disturbed_heap(1 << 20, 0xa5);
  WriteMap(map, other / "a quite different name, and longer.map", {});
  EXPECT_EQ(ReadFile(folder / "a.db"), ReadFile(other / "a quite different name, and longer.map"));
  MapData changed = map;
  changed.keyframes[0].frame ^= 1;
  WriteMap(changed, folder / "b.db", {});
  EXPECT_NE(ReadFile(folder / "a.db"), ReadFile(folder / "b.db"));
}

TEST(MapStore, TheVersionIsTheFilesHash) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(7), folder / "m.db", {});
  const MapData read = ReadMap(folder / "m.db");
  const std::string file = ReadFile(folder / "m.db");
  EXPECT_EQ(read.info.version,
            Sha256({reinterpret_cast<const unsigned char*>(file.data()), file.size()}));
  // What was read can be written again, and is the same map.
  WriteMap(read, folder / "again.db", {});
  EXPECT_EQ(ReadMap(folder / "again.db").info.version, read.info.version);
}

TEST(MapStore, RefusesToOverwriteUnlessAsked) {
  const TemporaryFolder folder;
  WriteFile(folder / "m.db", "precious");
  const MapError error = ErrorOf([&] { WriteMap(MadeMap(8), folder / "m.db", {}); });
  EXPECT_EQ(error.code(), ErrorCode::kFileExists);
  EXPECT_NE(std::string(error.what()).find("m.db"), std::string::npos);
  EXPECT_EQ(ErrorOf([&] { CheckWritable(folder / "m.db", {}); }).code(), ErrorCode::kFileExists);
  EXPECT_EQ(ReadFile(folder / "m.db"), "precious");

  WriteMap(MadeMap(7), folder / "old.db", {});
  fs::rename(folder / "old.db", folder / "m.db");
  CheckWritable(folder / "m.db", {.overwrite = true});
  EXPECT_EQ(WithoutVersion(ReadMap(folder / "m.db")), MadeMap(7));
  WriteMap(MadeMap(8), folder / "m.db", {.overwrite = true});
  EXPECT_EQ(WithoutVersion(ReadMap(folder / "m.db")), MadeMap(8));
  EXPECT_EQ(folder.Names(), std::vector<std::string>{"m.db"});
}

TEST(MapStore, OverwritesNothingButMaps) {
  const TemporaryFolder folder;
  const std::string photo = "\xff\xd8\xff\xe0 a photo";
  const std::string database = "SQLite format 3" + std::string(200, '\0');  // of another program
  WriteFile(folder / "real.jpg", photo);
  fs::create_symlink("real.jpg", folder / "link.db");
  for (const auto& [name, content] : std::map<std::string, std::string>{
           {"000000.jpg", photo}, {"other.db", database}, {"empty.db", ""}, {"link.db", photo}}) {
    if (name != "link.db") WriteFile(folder / name, content);
    for (const auto& write : {+[](const fs::path& path) { CheckWritable(path, {true}); },
                              +[](const fs::path& path) { WriteMap(MadeMap(8), path, {true}); }}) {
      const fs::path target = folder / name;
      const MapError error = ErrorOf([&] { write(target); });
      EXPECT_EQ(error.code(), ErrorCode::kFileExists) << name;
      EXPECT_NE(std::string(error.what()).find("only maps are overwritten"), std::string::npos);
    }
    EXPECT_EQ(ReadFile(folder / name), content) << name;
  }
}

TEST(MapStore, AnUnsoundMapIsNotWritten) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(9), folder / "m.db", {});
  const std::string before = ReadFile(folder / "m.db");
  MapData map = MadeMap(9);
  map.planes[0].views[0].reference_from_keyframe(0, 0) = std::nan("");
  const MapError error = ErrorOf([&] { WriteMap(map, folder / "m.db", {.overwrite = true}); });
  EXPECT_EQ(error.code(), ErrorCode::kMapDamaged);
  EXPECT_EQ(ReadFile(folder / "m.db"), before);
  EXPECT_EQ(folder.Names(), std::vector<std::string>{"m.db"});
}

TEST(MapStore, OddPathsWork) {
  const TemporaryFolder folder;
  const MapData map = MadeMap(10);
  for (const std::string& name :
       {std::string("a?b#c%41 d.db"), std::string("K\u00fcche.db"), std::string("latin \xe9.db"),
        std::string("file:x.db"), std::string("'; DROP TABLE map; --.db"),
        std::string(250, 'n') + ".db"}) {
    WriteMap(map, folder / name, {});
    EXPECT_EQ(WithoutVersion(ReadMap(folder / name)), map) << name;
    EXPECT_TRUE(CheckMap(folder / name).empty()) << name;
  }
}

TEST(MapStore, ASymbolicLinkIsFollowed) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "store");
  WriteMap(MadeMap(7), folder / "store/real.db", {});
  fs::create_symlink("store/real.db", folder / "link.db");
  WriteMap(MadeMap(11), folder / "link.db", {.overwrite = true});
  EXPECT_TRUE(fs::is_symlink(folder / "link.db"));
  EXPECT_EQ(WithoutVersion(ReadMap(folder / "store/real.db")), MadeMap(11));
}

TEST(MapStore, AReplacedFileKeepsItsPermissions) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(7), folder / "m.db", {});
  fs::permissions(folder / "m.db", fs::perms::owner_read | fs::perms::owner_write);
  WriteMap(MadeMap(12), folder / "m.db", {.overwrite = true});
  EXPECT_EQ(fs::status(folder / "m.db").permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
}

TEST(MapStore, ReadingChangesNothing) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(13), folder / "m.db", {});
  const std::string before = ReadFile(folder / "m.db");
  struct stat status_before {};
  ASSERT_EQ(stat((folder / "m.db").c_str(), &status_before), 0);
  ReadMap(folder / "m.db");
  CheckMap(folder / "m.db");
  TableSizes(folder / "m.db");
  MigrateMap(folder / "m.db");
  struct stat status_after {};
  ASSERT_EQ(stat((folder / "m.db").c_str(), &status_after), 0);
  EXPECT_EQ(ReadFile(folder / "m.db"), before);
  EXPECT_EQ(status_after.st_ino, status_before.st_ino);
  EXPECT_EQ(status_after.st_mtim.tv_nsec, status_before.st_mtim.tv_nsec);
  EXPECT_EQ(folder.Names(), std::vector<std::string>{"m.db"});
}

TEST(MapStore, TheFileIsFinishedAndCompact) {
  const TemporaryFolder folder;
  MapShape shape;
  shape.keyframes = 40;
  shape.planes = 10;
  shape.max_features = 600;
  shape.jpeg_bytes = 20'000;
  const MapData map = MadeMap(14, shape);
  WriteMap(map, folder / "m.db", {});
  int64_t payload = 0;
  for (const Keyframe& keyframe : map.keyframes) {
    payload += std::ssize(keyframe.picture) + std::ssize(keyframe.landmarks.positions) * 4 +
               std::ssize(keyframe.landmarks.codes.data());
  }
  for (const Plane& plane : map.planes) {
    payload += std::ssize(plane.features) * 20 + std::ssize(plane.descriptors.data()) +
               std::ssize(plane.views) * 72;
  }
  payload += std::ssize(map.index->centres.data()) + std::ssize(map.index->list_of_row) * 2;
  for (const AppearanceNode& node : map.appearance->nodes) payload += std::ssize(node.picture);
  for (const OrientationNode& node : map.orientation->nodes) payload += std::ssize(node.picture);
  for (const PlaneDepths& depths : map.poses->plane_depths) {
    // And the plane's covariance, and what is left of the last page of a blob.
    payload += std::ssize(depths.features) * 4 + 128 + 1024;
  }
  payload += std::ssize(map.poses->keyframes) * 80;
  for (const LandmarkDepths& depths : map.poses->landmark_depths) {
    payload += std::ssize(depths.landmarks) * 4;
  }
  const std::string bytes = ReadFile(folder / "m.db");
  EXPECT_EQ(bytes[18], 1) << "the file is in WAL mode";
  EXPECT_EQ(bytes[19], 1) << "the file is in WAL mode";
  // A page of 1024 bytes for each of the layers' 21 tables.
  EXPECT_LT(std::ssize(bytes), payload + payload / 33 + 30'000 + 21 * 1024);
}

// 64 rows of 64 magnitudes and 64 phases of 2 bytes each.
TEST(MapStore, APanoramaTakesItsSignatureAndLittleMore) {
  const TemporaryFolder folder;
  const auto bytes_with = [&](int nodes) {
    MapData map;
    map.sequences = {{{1}, "a", "folder", nodes, 0, {}}};
    map.appearance.emplace();
    const SignatureOptions& d = map.appearance->described;
    for (int64_t id = 1; id <= nodes; ++id) {
      AppearanceNode node{{id}, {1}, 0, "000120.jpg", 4.0, {}, {}, {}, {}};
      node.signature = {HalfMatrix::Ones(d.rows, d.k1), HalfMatrix::Ones(d.rows, d.k2)};
      map.appearance->nodes.push_back(node);
    }
    WriteMap(map, folder / "m.db", {.overwrite = true});
    return std::ssize(ReadFile(folder / "m.db"));
  };
  const int64_t each = (bytes_with(60) - bytes_with(10)) / 50;
  EXPECT_GT(each, 16'384);
  EXPECT_LT(each, 17'000);
}

TEST(MapStore, TableSizesAddUpToTheFile) {
  const TemporaryFolder folder;
  const MapData map = MadeMap(15);
  WriteMap(map, folder / "m.db", {});
  int64_t sum = 0;
  std::map<std::string, int64_t> rows;
  for (const TableSize& size : TableSizes(folder / "m.db")) {
    sum += size.bytes;
    rows[size.table] = size.rows;
  }
  EXPECT_EQ(sum, static_cast<int64_t>(fs::file_size(folder / "m.db")));
  EXPECT_EQ(rows["keyframes"], std::ssize(map.keyframes));
  EXPECT_EQ(rows["planes"], std::ssize(map.planes));
  EXPECT_EQ(rows["plane_features"], std::ssize(map.planes));
  EXPECT_EQ(rows["edges"], std::ssize(map.edges));
}

// What a later program may write: its index can't be used, everything else can.
TEST(MapStore, AnIndexOfAnUnknownFormatIsLeftOut) {
  const TemporaryFolder folder;
  MapData map = MadeMap(17);
  WriteMap(map, folder / "m.db", {});
  RunSql(folder / "m.db", "UPDATE search_index SET format = 77");
  {
    SQLite::Database database((folder / "m.db").string(), SQLite::OPEN_READWRITE);
    WriteContents(database, ExpectedObjects(Migrations()));
  }
  RunSql(folder / "m.db", "VACUUM");
  EXPECT_TRUE(CheckMap(folder / "m.db").empty());
  map.index.reset();
  EXPECT_EQ(WithoutVersion(ReadMap(folder / "m.db")), map);
}

TEST(MapStore, ManyReadersAtOnce) {
  const TemporaryFolder folder;
  const MapData map = MadeMap(16);
  WriteMap(map, folder / "m.db", {});
  std::vector<std::thread> threads;
  std::atomic<int> same = 0;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 5; ++i) {
        same +=
            WithoutVersion(ReadMap(folder / "m.db")) == map && CheckMap(folder / "m.db").empty();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(same, 40);
}

// Whoever opens the map while it is replaced sees one of the two, with the hash of that one. Here
// it is replaced many times during every read.
TEST(MapStore, ReadersSeeTheOldOrTheNewMap) {
  const TemporaryFolder folder;
  const MapData maps[2] = {MadeMap(17), MadeMap(18)};
  std::string versions[2];
  for (int i = 0; i < 2; ++i) {
    WriteMap(maps[i], folder / std::to_string(i), {});
    versions[i] = ReadMap(folder / std::to_string(i)).info.version;
  }
  WriteMap(maps[0], folder / "m.db", {});
  std::atomic<int64_t> replaced = 0;
  const std::jthread writer([&](const std::stop_token& stop) {
    for (; !stop.stop_requested(); ++replaced) {
      fs::create_hard_link(folder / std::to_string(replaced % 2), folder / "new");
      fs::rename(folder / "new", folder / "m.db");
      fs::remove(folder / "new");  // the two names of one file are left as they are by a rename
    }
  });
  while (replaced < 2) std::this_thread::yield();
  for (int i = 0; i < 50; ++i) {
    const MapData read = ReadMap(folder / "m.db");
    const int which = read.info.version == versions[0] ? 0 : 1;
    EXPECT_EQ(read.info.version, versions[which]);
    EXPECT_EQ(WithoutVersion(read), maps[which]);
  }
  EXPECT_GT(replaced, 50);
}

// Its newest rows may be in a log that wasn't copied with it.
TEST(MapStore, AMapWithAWriteAheadLogIsRefused) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(17), folder / "m.db", {});
  RunSql(folder / "m.db", "PRAGMA journal_mode = WAL");
  const MapError error = ErrorOf([&] { ReadMap(folder / "m.db"); });
  EXPECT_EQ(error.code(), ErrorCode::kMapDamaged);
  EXPECT_NE(std::string(error.what()).find("PRAGMA journal_mode = DELETE"), std::string::npos);
  RunSql(folder / "m.db", "PRAGMA journal_mode = DELETE");
  EXPECT_EQ(WithoutVersion(ReadMap(folder / "m.db")), MadeMap(17));
}

TEST(MapStore, ViewsForPeopleShowCountsAndNames) {
  const TemporaryFolder folder;
  const MapData map = MadeMap(19);
  WriteMap(map, folder / "m.db", {});
  const std::string people = (folder / "people.db").string();
  RunSql(folder / "m.db",
         "ATTACH '" + people + "' AS p; CREATE TABLE p.t AS SELECT " +
             "(SELECT planes FROM map_summary) = " + std::to_string(map.planes.size()) + " AND " +
             "(SELECT count(*) FROM keyframe_list) = " + std::to_string(map.keyframes.size()) +
             " AND " +
             "(SELECT sum(views) FROM plane_list) = " + "(SELECT count(*) FROM view_list) AND " +
             "(SELECT count(*) FROM neighbour_list) = 2 * " + std::to_string(map.edges.size()) +
             " AND " + "(SELECT count(*) FROM edge_list WHERE a < b) = " +
             std::to_string(map.edges.size()) + " AND " +
             "(SELECT count(*) FROM sequence_list) = " + std::to_string(map.sequences.size()) +
             " AND (SELECT sum(edges) FROM appearance_node_list) = 6" +
             " AND (SELECT count(*) FROM appearance_edge_list WHERE kind IS NOT NULL) = 3" +
             " AND (SELECT count(heading_deg) FROM orientation_frame_list) = 9" +
             " AND (SELECT group_concat(direction || ' ' || verdict) FROM turn_list) = " +
             "'left turn,right false turn'" +
             " AND (SELECT sum(edges) FROM orientation_node_list) = 4" +
             " AND (SELECT group_concat(axis) FROM corridor_list) = 'x,y'" + " AS ok;" +
             "CREATE TABLE p.check_ok (x CHECK (x = 1)); ");
  // The CHECK makes a wrong count an error here.
  RunSql(people, "PRAGMA ignore_check_constraints = OFF; INSERT INTO check_ok SELECT ok FROM t;");
}

}  // namespace
}  // namespace waystone
