// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <string>

#include "core/base/error.h"
#include "schema/layers/layer_rows.h"
#include "schema/layers/poses/pose_tables.h"
#include "schema/tables/blob.h"
#include "schema/tables/table_rows.h"
#include "schema/tables/table_writer.h"

namespace waystone {
namespace {

constexpr int kDepthBytes = 2 * kListBytes;  // uint16 depth, sigma
constexpr int kPlaneCovarianceValues = 16;   // 4 x 4 float64
constexpr int kLastUnit = static_cast<int>(LengthUnit::kMetres);

Bytes EncodeDepths(const std::vector<DepthCode>& depths) {
  std::vector<uint16_t> values;
  values.reserve(2 * depths.size());
  for (const DepthCode& code : depths) {
    values.push_back(code.log_depth);
    values.push_back(code.sigma);
  }
  return EncodeLists(values);
}

std::vector<DepthCode> DecodeDepths(BytesView blob) {
  const std::vector<uint16_t> values = DecodeLists(blob);
  std::vector<DepthCode> depths(values.size() / 2);
  for (size_t i = 0; i < depths.size(); ++i) depths[i] = {values[2 * i], values[2 * i + 1]};
  return depths;
}

Bytes EncodePlaneCovariance(const Eigen::Matrix4d& covariance) {
  return EncodeParameters({covariance.data(), covariance.data() + kPlaneCovarianceValues});
}

Eigen::Matrix4d DecodePlaneCovariance(BytesView blob) {
  return Eigen::Matrix4d(DecodeParameters(blob).data());
}

class PoseReader {
 public:
  PoseReader(SQLite::Database& database, std::vector<MapProblem>& problems)
      : database_(database), problems_(problems) {}

  std::optional<PoseLayer> Read() {
    ForEach(kPoseLayerTable, [&](Row& row) {
      row.Int64(1, 1);
      layer_.frame = row.Text();
      layer_.unit = static_cast<LengthUnit>(row.Int(0, kLastUnit));
      layer_.noise.position_sigma = row.Real();
      layer_.noise.rotation_sigma_rad = row.Real();
      found_ = true;
    });
    ReadKeyframePoses();
    ReadPlanePoses();
    ReadDepths();
    if (!found_) return {};
    return std::move(layer_);
  }

 private:
  template <class Each>
  void ForEach(const TableView& table, Each each) {
    ForEachRowOfLayer(database_, problems_, table, kPoseLayerTable, found_, each);
  }

  void ReadKeyframePoses() {
    ForEach(kKeyframePosesTable, [&](Row& row) {
      KeyframePose pose;
      pose.keyframe = {row.Int64(1)};
      pose.rotation.w() = row.Real();
      pose.rotation.x() = row.Real();
      pose.rotation.y() = row.Real();
      pose.rotation.z() = row.Real();
      for (double& value : pose.position) value = row.Real();
      layer_.keyframes.push_back(pose);
    });
  }

  void ReadPlanePoses() {
    ForEach(kPlanePosesTable, [&](Row& row) {
      PlanePose plane;
      plane.plane = {row.Int64(1)};
      for (double& value : plane.normal) value = row.Real();
      plane.distance = row.Real();
      plane.covariance = DecodePlaneCovariance(row.Blob(kPlaneCovarianceValues * kParameterBytes));
      layer_.planes.push_back(plane);
    });
  }

  void ReadDepths() {
    ForEach(kPlaneDepthsTable, [&](Row& row) {
      const PlaneId plane{row.Int64(1)};
      const int64_t count = row.Int(1);
      layer_.plane_depths.push_back({plane, DecodeDepths(row.Blob(count * kDepthBytes))});
    });
    ForEach(kLandmarkDepthsTable, [&](Row& row) {
      const KeyframeId keyframe{row.Int64(1)};
      const int64_t count = row.Int(1);
      layer_.landmark_depths.push_back({keyframe, DecodeDepths(row.Blob(count * kDepthBytes))});
    });
  }

  SQLite::Database& database_;
  std::vector<MapProblem>& problems_;
  PoseLayer layer_;
  bool found_ = false;
};

}  // namespace

std::optional<PoseLayer> ReadPoses(SQLite::Database& database, std::vector<MapProblem>& problems) {
  return PoseReader(database, problems).Read();
}

void WritePoses(const PoseLayer& layer, RowSink& sink) {
  TableWriter<kPoseLayerTable>(sink).Row(1, layer.frame, layer.unit, layer.noise.position_sigma,
                                         layer.noise.rotation_sigma_rad);
  TableWriter<kKeyframePosesTable> keyframes(sink);
  for (const KeyframePose& pose : layer.keyframes) {
    const Eigen::Quaterniond& q = pose.rotation;
    const Eigen::Vector3d& at = pose.position;
    keyframes.Row(pose.keyframe, q.w(), q.x(), q.y(), q.z(), at.x(), at.y(), at.z());
  }
  TableWriter<kPlanePosesTable> planes(sink);
  for (const PlanePose& plane : layer.planes) {
    const Eigen::Vector3d& n = plane.normal;
    planes.Row(plane.plane, n.x(), n.y(), n.z(), plane.distance,
               EncodePlaneCovariance(plane.covariance));
  }
  TableWriter<kPlaneDepthsTable> of_planes(sink);
  for (const PlaneDepths& one : layer.plane_depths) {
    of_planes.Row(one.plane, one.features.size(), EncodeDepths(one.features));
  }
  TableWriter<kLandmarkDepthsTable> of_landmarks(sink);
  for (const LandmarkDepths& one : layer.landmark_depths) {
    of_landmarks.Row(one.keyframe, one.landmarks.size(), EncodeDepths(one.landmarks));
  }
}

}  // namespace waystone
