// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <string>

#include "core/base/error.h"
#include "schema/layers/layer_rows.h"
#include "schema/layers/poses/pose_tables.h"
#include "schema/tables/blob.h"
#include "schema/tables/optional_table.h"
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

void ReadCameraPose(Row& row, CameraPose& pose) {
  pose.rotation.w() = row.Real();
  pose.rotation.x() = row.Real();
  pose.rotation.y() = row.Real();
  pose.rotation.z() = row.Real();
  for (double& value : pose.position) value = row.Real();
}

// The columns of both kinds of poses.
template <class Writer, class Id>
void WriteCameraPose(Writer& writer, Id id, const CameraPose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& at = pose.position;
  writer.Row(id, q.w(), q.x(), q.y(), q.z(), at.x(), at.y(), at.z());
}

// Ids of node_pose_errors, as of appearance_verdict.
constexpr int kOfAppearance = 1;
constexpr int kOfVerified = 2;

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
      ReadCameraPose(row, pose);
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
  for (const KeyframePose& pose : layer.keyframes) WriteCameraPose(keyframes, pose.keyframe, pose);
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

void ReadNodePoses(SQLite::Database& database, std::optional<PoseLayer>& poses,
                   std::vector<MapProblem>& problems) {
  PoseLayer read;
  ForEachOptionalRow(database, problems, kNodePosesTable, [&](Row& row) {
    NodePose pose;
    pose.node = {row.Int64(1)};
    ReadCameraPose(row, pose);
    read.nodes.push_back(pose);
  });
  ForEachOptionalRow(database, problems, kNodePoseErrorsTable, [&](Row& row) {
    const bool verified = row.Int64(kOfAppearance, kOfVerified) == kOfVerified;
    NodePoseErrors errors;
    errors.position_factor = row.Real();
    errors.height_sigma = row.Real();
    errors.heading_sigma_rad = row.Real();
    errors.tilt_sigma_rad = row.Real();
    (verified ? read.verified_errors : read.appearance_errors) = errors;
  });
  if (read == PoseLayer{}) return;
  if (!poses) {
    problems.push_back({"node_poses", "there are poses of panoramas, but no pose_layer"});
    return;
  }
  poses->nodes = std::move(read.nodes);
  poses->appearance_errors = read.appearance_errors;
  poses->verified_errors = read.verified_errors;
}

void WriteNodePoses(const PoseLayer& layer, RowSink& sink) {
  OptionalTableWriter<kNodePosesTable> nodes(sink, kNodePosesSql);
  for (const NodePose& pose : layer.nodes) WriteCameraPose(nodes, pose.node, pose);
  OptionalTableWriter<kNodePoseErrorsTable> of_nodes(sink, kNodePoseErrorsSql);
  const auto write_errors = [&of_nodes](int id, const std::optional<NodePoseErrors>& errors) {
    if (!errors) return;
    of_nodes.Row(id, errors->position_factor, errors->height_sigma, errors->heading_sigma_rad,
                 errors->tilt_sigma_rad);
  };
  write_errors(kOfAppearance, layer.appearance_errors);
  write_errors(kOfVerified, layer.verified_errors);
}

}  // namespace waystone
