// SPDX-License-Identifier: Apache-2.0
// The pose of a query in numbers.
import type { ComponentChildren } from "preact";
import type { Answer, Pose } from "./api";
import { counted, degrees, unitOf, withDeviation } from "./words";

// Standard deviations of the position on each axis, and that of the rotation about the worst one.
const deviations = ({ covariance }: Pose) => covariance.map((row, i) => Math.sqrt(Math.max(0, row[i])));

function Position({ pose }: { pose: Pose }) {
  const sigma = deviations(pose);
  return (
    <>
      {pose.position.map((value, i) => withDeviation(value, sigma[i])).join(", ")} {unitOf(pose.unit)}{" "}
      <small>x, y, z in the frame “{pose.frame}” (1σ)</small>
    </>
  );
}

function Orientation({ pose }: { pose: Pose }) {
  return (
    <>
      {pose.orientation.map((value) => value.toFixed(3)).join(", ")} ±{" "}
      {degrees(Math.max(...deviations(pose).slice(3)), 2)} <small>quaternion x, y, z, w</small>
    </>
  );
}

// Names and values; none for a map without poses.
export function poseRows({ pose, pose_reason }: Answer): [string, ComponentChildren][] {
  if (!pose) return pose_reason ? [["Pose", `none: ${pose_reason}`]] : [];
  const whose = pose.camera === "map" ? "the map’s images" : "the query";
  const from = pose.inliers > 0 ? `${counted(pose.inliers, "inlier")}, with the calibration of ${whose}` : "the appearance alone";
  return [
    ["Position", <Position pose={pose} />],
    ["Orientation", <Orientation pose={pose} />],
    ["Pose from", from],
  ];
}

// Where the query is on a floor plan; none where it isn't on one.
export function planRows({ place }: Answer): [string, ComponentChildren][] {
  const plan = place?.plan;
  if (!plan) return [];
  return [["On the plan", <>{plan.x.toFixed(0)}, {plan.y.toFixed(0)} px <small>of “{plan.name}”</small></>]];
}
