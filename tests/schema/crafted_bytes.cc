// SPDX-License-Identifier: Apache-2.0
// https://www.sqlite.org/fileformat2.html has the layout.
#include <SQLiteCpp/Database.h>

#include <utility>

#include "tests/schema/crafted_maps.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int kCraftedPage = 1024;
constexpr char kTableInterior = 5;
constexpr char kTableLeaf = 13;
constexpr char kIndexInterior = 2;

// A database's bytes, to be changed.
struct Pages {
  std::string bytes;

  int count() const { return static_cast<int>(bytes.size() / kCraftedPage); }

  void Set(size_t offset, uint32_t value, int length) {
    for (int i = length - 1; i >= 0; --i, value >>= 8) {
      bytes[offset + i] = static_cast<char>(value & 0xff);
    }
  }
  uint32_t Get(size_t offset, int length) const {
    uint32_t value = 0;
    for (int i = 0; i < length; ++i) value = (value << 8) | static_cast<uint8_t>(bytes[offset + i]);
    return value;
  }

  static size_t At(int page) { return static_cast<size_t>(page - 1) * kCraftedPage; }

  // Adds a page of zeros that the header counts and gives its number.
  int Append() {
    bytes.append(kCraftedPage, '\0');
    Set(28, count(), 4);
    return count();
  }

  // A page with these cells, and a child to the right of them where it isn't a leaf.
  void Fill(int page, char type, const std::vector<std::string>& cells, int right_child) {
    const bool leaf = right_child == 0;
    size_t content = kCraftedPage;
    size_t pointer = leaf ? 8 : 12;
    bytes.replace(At(page), kCraftedPage, kCraftedPage, '\0');
    for (const std::string& cell : cells) {
      content -= cell.size();
      bytes.replace(At(page) + content, cell.size(), cell);
      Set(At(page) + pointer, static_cast<uint32_t>(content), 2);
      pointer += 2;
    }
    bytes[At(page)] = type;
    Set(At(page) + 3, static_cast<uint32_t>(cells.size()), 2);
    Set(At(page) + 5, static_cast<uint32_t>(content), 2);
    if (!leaf) Set(At(page) + 8, right_child, 4);
  }
};

std::string BigEndian4(int value) {
  Pages four{std::string(4, '\0')};
  four.Set(0, value, 4);
  return four.bytes;
}

CraftedMap ByPages(const std::string& name, const std::string& sql,
                   const std::function<void(Pages&, int root)>& change) {
  return {name, [=](const fs::path& path) {
            RunSql(path, sql);
            int root = 0;
            {
              SQLite::Database database(path.string());
              root = database
                         .execAndGet(
                             "SELECT rootpage FROM sqlite_schema WHERE name IN "
                             "('other', 'i', 'keyframes') ORDER BY name = 'i' DESC, "
                             "name = 'other' DESC")
                         .getInt();
            }
            Pages pages{ReadFile(path)};
            change(pages, root);
            WriteFile(path, pages.bytes);
          }};
}

CraftedMap ByHeader(const std::string& name, size_t offset, uint32_t value, int length = 4,
                    bool sound = false) {
  CraftedMap map =
      ByPages(name, "SELECT 1", [=](Pages& pages, int) { pages.Set(offset, value, length); });
  map.sound = sound;
  return map;
}

std::vector<CraftedMap> Headers() {
  return {
      ByHeader("4 billion pages", 28, 0xfffffffe),
      ByHeader("2 billion pages", 28, 0x7fffffff),
      ByHeader("no pages", 28, 0),
      ByHeader("one page", 28, 1),
      ByHeader("pages of 65536 bytes", 16, 1, 2),
      ByHeader("pages of 512 bytes", 16, 512, 2),
      ByHeader("pages of 0 bytes", 16, 0, 2),
      ByHeader("pages of 1000 bytes", 16, 1000, 2),
      ByHeader("255 reserved bytes a page", 20, 255, 1),
      ByHeader("write-ahead log", 18, 0x0202, 2),
      ByHeader("format of the future", 18, 0x6363, 2),
      ByHeader("schema format", 44, 0x7fffffff),
      ByHeader("UTF-16", 56, 3),
      ByHeader("encoding 77", 56, 77, 4, true),
      ByHeader("pointer map", 52, 3),
      ByHeader("incremental vacuum", 52, 0x00000003, 4),
      ByHeader("a free list of nothing", 32, 1, 4, true),
      ByHeader("4 billion free pages", 36, 0xffffffff),
      ByHeader("negative version", 60, 0xffffffff),
      ByHeader("another application", 68, 0x57415954),
      ByHeader("huge suggested cache", 48, 0x7fffffff, 4, true),
  };
}

std::vector<CraftedMap> Tails() {
  const std::string freed =
      "CREATE TABLE other (a TEXT); INSERT INTO other VALUES (printf('%.*c', 20000, 's')); "
      "DROP TABLE other";
  return {
      ByPages("a byte behind the end", "SELECT 1", [](Pages& pages, int) { pages.bytes += 'x'; }),
      ByPages("10 MB behind the end", "SELECT 1",
              [](Pages& pages, int) { pages.bytes.append(10'000'000, 'x'); }),
      ByPages("pages that nothing names", "SELECT 1",
              [](Pages& pages, int) {
                for (int i = 0; i < 9000; ++i) pages.Append();
              }),
      ByPages("free pages", freed, [](Pages&, int) {}),
      ByPages("a free list in a circle", freed,
              [](Pages& pages, int) {
                const uint32_t trunk = pages.Get(32, 4);
                pages.Set(Pages::At(static_cast<int>(trunk)), trunk, 4);
              }),
      ByPages("a free list of used pages", freed, [](Pages& pages, int) { pages.Set(32, 1, 4); }),
      ByPages("free pages that aren't counted", freed,
              [](Pages& pages, int) { pages.Set(32, 0, 4), pages.Set(36, 0, 4); }),
  };
}

// Pages of many cells that all lead to the same next page, `depth` times, and to rows in the end.
void Multiply(Pages& pages, int root, char type, int depth, const std::string& key, int cells) {
  const int last = pages.Append();
  pages.bytes.replace(Pages::At(last), kCraftedPage,
                      pages.bytes.substr(Pages::At(root), kCraftedPage));
  int next = last;
  for (int i = 0; i < depth; ++i) {
    const int page = i + 1 == depth ? root : pages.Append();
    pages.Fill(page, type, std::vector<std::string>(cells, BigEndian4(next) + key), next);
    next = page;
  }
}

std::vector<CraftedMap> Trees() {
  const std::string other = "CREATE TABLE other (a INTEGER); INSERT INTO other VALUES (1)";
  // An index cell of a row (NULL, rowid 1): payload of 4 bytes, header of 3.
  const std::string index_key("\x04\x03\x00\x09\x00", 5);
  return {
      ByPages("a tree that is its own child", other,
              [](Pages& pages, int root) {
                pages.Fill(root, kTableInterior, {BigEndian4(root) + '\x01'}, root);
              }),
      ByPages(
          "100^15 keyframes", "SELECT 1",
          [](Pages& pages, int root) { Multiply(pages, root, kTableInterior, 15, "\x7f", 100); }),
      ByPages(
          "100^15 rows of a foreign table", other,
          [](Pages& pages, int root) { Multiply(pages, root, kTableInterior, 15, "\x7f", 100); }),
      ByPages("60^15 entries of an index", other + "; CREATE INDEX i ON other (a)",
              [index_key](Pages& pages, int root) {
                Multiply(pages, root, kIndexInterior, 15, index_key, 60);
              }),
      ByPages("60^15 entries of an index on keyframes", "CREATE INDEX i ON keyframes (width)",
              [index_key](Pages& pages, int root) {
                Multiply(pages, root, kIndexInterior, 15, index_key, 60);
              }),
      ByPages("100^15 definitions", "SELECT 1",
              [](Pages& pages, int) {
                // The first page's tree begins behind the header.
                const std::string header = pages.bytes.substr(0, 100);
                const int child = pages.Append();
                Multiply(pages, child, kTableInterior, 15, "\x7f", 100);
                pages.Fill(1, kTableInterior, {}, child);
                pages.bytes = header.substr(0, 28) + pages.bytes.substr(28, 4) + header.substr(32) +
                              pages.bytes.substr(0, 12) + pages.bytes.substr(112);
                pages.bytes.resize(static_cast<size_t>(pages.Get(28, 4)) * kCraftedPage);
              }),
      ByPages("a page of cells without an end", other,
              [](Pages& pages, int root) { pages.Set(Pages::At(root) + 3, 0xffff, 2); }),
  };
}

// The first page from the root down on the left.
int FirstLeaf(const Pages& pages, int root) {
  while (pages.bytes[Pages::At(root)] == kTableInterior) {
    const size_t cell = pages.Get(Pages::At(root) + 12, 2);
    root = static_cast<int>(pages.Get(Pages::At(root) + cell, 4));
  }
  return root;
}

std::vector<CraftedMap> Chains() {
  const std::string large =
      "UPDATE keyframes SET source = printf('%.*c', 800000, 'x') WHERE id = (SELECT min(id) FROM "
      "keyframes)";
  const auto largest = [](Pages& pages, int root) { return Pages::At(FirstLeaf(pages, root)); };
  return {
      // 800 KB that are 128 MB once they are read.
      ByPages("a row of 800 KB, 160 times", large,
              [=](Pages& pages, int root) {
                const size_t leaf = largest(pages, root);
                const uint32_t cell = pages.Get(leaf + 8, 2);
                pages.Set(leaf + 3, 160, 2);
                pages.Set(leaf + 5, cell, 2);
                for (int i = 0; i < 160; ++i) pages.Set(leaf + 8 + 2 * i, cell, 2);
              }),
      ByPages("a row of 2 GB", large,
              [=](Pages& pages, int root) {
                const size_t leaf = largest(pages, root);
                const size_t cell = leaf + pages.Get(leaf + 8, 2);
                pages.bytes.replace(cell, 3, "\xff\xff\x7f");
              }),
      ByPages("a row of 2^63 bytes", "CREATE TABLE other (a)",
              [](Pages& pages, int root) {
                pages.Fill(root, kTableLeaf,
                           {std::string(9, '\xff') + '\x01' + std::string(400, '\x01')}, 0);
              }),
      ByPages(
          "an overflow chain in a circle", large,
          [](Pages& pages, int) { pages.Set(Pages::At(pages.count() - 4), pages.count() - 4, 4); }),
      ByPages("an overflow chain into the header", large,
              [](Pages& pages, int) { pages.Set(Pages::At(pages.count() - 9), 1, 4); }),
      ByPages("two rows of one chain",
              "CREATE TABLE other (a TEXT); INSERT INTO other VALUES (printf('%.*c', 800000, 'x'))",
              [](Pages& pages, int root) {
                const size_t leaf = Pages::At(root);
                const size_t start = pages.Get(leaf + 8, 2);
                const std::string cell = pages.bytes.substr(leaf + start, kCraftedPage - start);
                std::vector<std::string> cells;
                for (char id = 1; id <= 8; ++id) {  // the length takes three bytes, the rowid one
                  cells.push_back(cell.substr(0, 3) + id + cell.substr(4));
                }
                if (cell.size() > 120) cells.resize(2);
                pages.Fill(root, kTableLeaf, cells, 0);
              }),
  };
}

}  // namespace

std::vector<CraftedMap> CraftedByBytes() {
  std::vector<CraftedMap> all;
  for (const auto& maps : {Headers(), Tails(), Trees(), Chains()}) {
    all.insert(all.end(), maps.begin(), maps.end());
  }
  return all;
}

}  // namespace waystone
