#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a map file holds, a line a row, read by Python alone: `summarize.py v3_walk.db > v3_walk.txt`.

Texts are hexadecimal, blobs are their stored CRC-32C, absent values are "-"."""
import sqlite3
import sys

# The lines' names and the columns of FORMAT.md that they show.
TABLES = {
    "map": "map: name, program, feature_type, length(options)",
    "sequences": "sequence: id, name, kind, frames, skipped, camera_model, camera_width, "
                 "camera_height, camera_params_crc32c",
    "keyframes": "keyframe: id, sequence, stretch, frame, source, time_s, width, height",
    "keyframe_images": "picture: keyframe, jpeg_crc32c",
    "keyframe_landmarks": "landmarks: keyframe, landmark_count, positions_crc32c, codes_crc32c",
    "planes": "plane: id, reference_keyframe, feature_count, vertex_count, outline_crc32c",
    "plane_features": "features: plane, keypoints_crc32c, votes_crc32c, descriptors_crc32c",
    "plane_views": "view: plane, keyframe, inliers, homography_crc32c",
    "edges": "edge: a, b, from_keyframe, to_keyframe, third_eigenvalue, homology_crc32c",
    "search_index": "index: list_count, feature_count, centres_crc32c, lists_crc32c",
    "verdict_model": "verdict: intercept, log_inliers, inlier_share, positives, negatives",
    "appearance_layer": "appearance: signature_rows, k1, k2, top_rad, bottom_rad, normalised, "
                        "metres_per_unit, dropped",
    "appearance_nodes": "node: id, sequence, frame, source, time_s, x, y, theta_rad",
    "appearance_signatures": "signature: node, magnitudes_crc32c, phases_crc32c",
    "appearance_features": "bearings: node, feature_count, bearings_crc32c, codes_crc32c",
    "appearance_edges": "relation: a, b, kind, distance, x, y, heading_rad, deviation_rad",
    "appearance_verdict": "model: id, intercept, positives, negatives",
    "appearance_verdict_terms": "term: verdict, name, weight",
    "orientation_layer": "orientation: step",
    "orientation_frames": "frame: id, sequence, frame, source, time_s, reliable, lines_x, lines_y, "
                          "lines_z, qw, qx, qy, qz, covariance_crc32c",
    "orientation_nodes": "direction: frame, kind, up, right, down, left",
    "orientation_edges": "traversal: a, b, kind, matches",
}


def text_of(value):
    if value is None:
        return "-"
    if isinstance(value, bytes):
        return value.hex() or "''"
    if isinstance(value, float):
        return f"{value:.17g}"
    return str(value)


def main():
    database = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True)
    database.text_factory = bytes
    there = {name.decode() for (name,) in database.execute("SELECT name FROM sqlite_schema")}
    for table, line in TABLES.items():
        if table not in there:
            continue
        name, columns = line.split(": ")
        for row in database.execute(f"SELECT {columns} FROM {table} ORDER BY 1, 2"
                                    if ", " in columns else f"SELECT {columns} FROM {table}"):
            print(name, *map(text_of, row))


main()
