// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/features/features.h"

namespace waystone {

// An inverted file: descriptors sorted into lists of similar ones, each list represented by its
// centre. A search for nearest neighbours visits the lists with the nearest centres instead of all.
// This is what a map file stores; SearchIndex is what queries use.
struct InvertedFile {
  Descriptors centres;                // a row per list: its mean (SIFT) or majority of bits
  std::vector<uint16_t> list_of_row;  // of each descriptor

  bool operator==(const InvertedFile&) const = default;
};

struct InvertedFileOptions {
  int min_rows = 8192;
  double lists_per_root = 4.0;
  int training_rows = 48;
  int rounds = 8;
  uint64_t seed = 1;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"min_rows", &InvertedFileOptions::min_rows, AtLeast(1), "",
                    "Indexes with fewer rows than this are searched exhaustively, which is about "
                    "as fast, and exact."},
        OptionField{"lists_per_root", &InvertedFileOptions::lists_per_root, OpenLow(0, 100), "",
                    "Number of lists for n rows: this times the square root of n, rounded to the "
                    "nearest power of two, at most 2^15. With more lists, each is shorter, but "
                    "choosing among them takes longer."},
        OptionField{"training_rows", &InvertedFileOptions::training_rows, AtLeast(1), "",
                    "Number of rows per list from which the centres are learned. More rows fit the "
                    "data better, but take longer."},
        OptionField{"rounds", &InvertedFileOptions::rounds, Closed(0, 1000), "",
                    "Number of rounds of k-means."},
        OptionField{"seed", &InvertedFileOptions::seed, AnyValue(), "",
                    "Random seed of the choice of training rows: the same rows and options give "
                    "the same file."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Number of lists for this many rows; 0 where rows are to be searched one by one. Thread-safe.
int ListCount(int64_t rows, const InvertedFileOptions& options);

// Sorts rows into ListCount lists by k-means, in integers: the same bytes on any machine and any
// number of threads (it uses TBB's). Empty where ListCount is 0.
InvertedFile BuildInvertedFile(DescriptorsView rows, FeatureType type,
                               const InvertedFileOptions& options);

// What is wrong with an inverted file for this many rows of a type, or empty: files come from
// outside. Thread-safe.
std::string InvertedFileProblem(const InvertedFile& file, int64_t rows, FeatureType type);

}  // namespace waystone
