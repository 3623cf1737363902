// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/options.h"
#include "core/homography/find_plane.h"

namespace waystone {

inline constexpr int kNoPlane = -1;

struct LabellingOptions {
  double min_sigmas = 5.0;
  double max_sigmas = 10.0;
  double min_sigma_px = 0.2;
  double max_sigma_px = 2.5;
  double tail = 3.0;
  double outlier_cost = 9.0;
  double plane_cost = 50.0;
  double smoothness = 4.0;
  int companions = 8;
  int rounds = 4;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"min_sigmas", &LabellingOptions::min_sigmas, Above(0), "",
                    "Minimum error bound of a plane, in standard deviations of its own noise."},
        OptionField{"max_sigmas", &LabellingOptions::max_sigmas, Closed(1, 1000), "",
                    "Maximum error bound of a plane, used where few matches belong to no plane. "
                    "Lens distortion and uneven surfaces give the errors of true matches long "
                    "tails, but near other objects a wide bound accepts their matches, too."},
        OptionField{"min_sigma_px", &LabellingOptions::min_sigma_px, Above(0), "px",
                    "Minimum noise of a plane."},
        OptionField{"max_sigma_px", &LabellingOptions::max_sigma_px, Above(0), "px",
                    "Maximum noise of a plane."},
        OptionField{"tail", &LabellingOptions::tail, Above(0), "",
                    "Degrees of freedom of Student's t-distribution of the errors. Lower values "
                    "give longer tails."},
        OptionField{"outlier_cost", &LabellingOptions::outlier_cost, AnyValue(), "",
                    "Cost of a match that belongs to no plane: the negative logarithm of its "
                    "likelihood per px^2. Higher values assign more distant matches to planes."},
        OptionField{"plane_cost", &LabellingOptions::plane_cost, AtLeast(0), "",
                    "Cost of a plane, in the same units. Higher values find fewer, larger planes."},
        OptionField{"smoothness", &LabellingOptions::smoothness, AtLeast(0), "",
                    "Cost of a match whose companions all belong to other planes. Higher values "
                    "smooth more."},
        OptionField{"companions", &LabellingOptions::companions, AtLeast(1), "",
                    "Number of nearest matches that count as the companions of a match."},
        OptionField{"rounds", &LabellingOptions::rounds, Closed(1, 1000), "",
                    "Number of rounds of labelling and refitting."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Planes of two images and the matches that belong to them, with all matches relabelled whenever a
// plane is added, removed or refitted: the labels and planes of least energy (Isack and Boykov
// 2012, "energy-based geometric multi-model fitting", eq. 2), found by alternating expansion moves
// and refits. Planes are numbered from 0 in the order in which they were added; rows are those of
// the matches. Errors are symmetric transfer errors, px. Deterministic; not thread-safe.
class PlaneLabelling {
 public:
  // Keeps a reference to `points`.
  PlaneLabelling(const MatchedPoints& points, const Neighbourhoods& neighbourhoods,
                 const LabellingOptions& options);

  // A plane that is `fixed` keeps its homography and noise.
  void Add(const Eigen::Matrix3d& to_from, double sigma_px, bool fixed);
  // Its matches then belong to no plane, and the planes after it move up.
  void Remove(int plane);
  // Replaces a plane's homography and noise; whether it is fixed stays as it was.
  void Replace(int plane, const Eigen::Matrix3d& to_from, double sigma_px);
  int planes() const { return static_cast<int>(planes_.size()); }
  const Eigen::Matrix3d& to_from(int plane) const { return planes_[plane].to_from; }
  double sigma_px(int plane) const { return planes_[plane].sigma_px; }

  // Assigns to a plane the matches that lower the energy most, refits it to them, and does both
  // once more. The other planes stay as they are: a first check of how useful a new plane is.
  void Grow(int plane);
  // Labels all matches and refits the planes, in rounds, until neither changes.
  void Settle();
  const std::vector<int>& labels() const { return labels_; }  // plane of each match, or kNoPlane
  std::vector<int> RowsOf(int plane) const;
  // Negative log-likelihood of matches, labels and number of planes, up to a constant. Lower is
  // better.
  double Energy() const;

  // What one more plane would explain better than the labels do: which of these matches, and how
  // much the energy would fall if they became its own and their companions' labels didn't matter.
  struct Better {
    double gain = 0;
    std::vector<int> rows;  // ascending
  };
  Better BetterWith(const Eigen::Matrix3d& to_from, double sigma_px,
                    const std::vector<int>& rows) const;
  // The homography refitted to these matches as planes are refitted, with near ones weighted most.
  std::optional<Eigen::Matrix3d> Refitted(const Eigen::Matrix3d& to_from, double sigma_px,
                                          const std::vector<int>& rows) const;

 private:
  struct Labelled {
    Eigen::Matrix3d to_from;
    double sigma_px = 0;
    bool fixed = false;
    std::vector<float> errors_px;  // of every match
    std::vector<float> costs;      // of labelling each match with this plane
  };

  double bound_px(int plane) const { return sigmas_ * planes_[plane].sigma_px; }
  void Measure(Labelled& plane) const;
  void SetSigma(Labelled& plane, double sigma_px) const;
  void EstimateSigmas();
  bool Label();
  bool Release();
  bool Expand(int plane);
  bool Drop();
  double ErrorCost(double sigmas) const;
  double OwnCost(int row, int label) const;
  double PairCost(int label, int other) const;
  double Disagreement(int row) const;
  std::optional<Eigen::Matrix3d> Fit(const std::vector<int>& rows,
                                     const std::vector<double>& sigmas) const;
  void Refit(int plane);

  const MatchedPoints* points_;
  LabellingOptions options_;
  // The companions of each match: its nearest matches and those that have it among their nearest;
  // twice if both.
  std::shared_ptr<const std::vector<std::vector<int>>> companions_;
  std::vector<Labelled> planes_;
  std::vector<int> labels_;
  double sigmas_;  // between min_sigmas and max_sigmas
};

}  // namespace waystone
