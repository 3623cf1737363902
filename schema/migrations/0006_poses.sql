-- Schema version 6: where keyframes, planes and features are in a frame that the user gave.

CREATE TABLE pose_layer (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  frame TEXT NOT NULL,
  unit INTEGER NOT NULL,
  position_sigma REAL NOT NULL,
  rotation_sigma_rad REAL NOT NULL
) STRICT;

CREATE TABLE keyframe_poses (
  keyframe INTEGER PRIMARY KEY REFERENCES keyframes,
  qw REAL NOT NULL,
  qx REAL NOT NULL,
  qy REAL NOT NULL,
  qz REAL NOT NULL,
  x REAL NOT NULL,
  y REAL NOT NULL,
  z REAL NOT NULL
) STRICT;

CREATE TABLE plane_poses (
  plane INTEGER PRIMARY KEY REFERENCES planes,
  nx REAL NOT NULL,
  ny REAL NOT NULL,
  nz REAL NOT NULL,
  distance REAL NOT NULL,
  covariance_crc32c INTEGER NOT NULL,
  covariance BLOB NOT NULL
) STRICT;

CREATE TABLE plane_depths (
  plane INTEGER PRIMARY KEY REFERENCES planes,
  feature_count INTEGER NOT NULL CHECK (feature_count > 0),
  depths_crc32c INTEGER NOT NULL,
  depths BLOB NOT NULL
) STRICT;

CREATE TABLE landmark_depths (
  keyframe INTEGER PRIMARY KEY REFERENCES keyframes,
  landmark_count INTEGER NOT NULL CHECK (landmark_count > 0),
  depths_crc32c INTEGER NOT NULL,
  depths BLOB NOT NULL
) STRICT;

-- For people. The program doesn't read it.

CREATE VIEW pose_list AS
SELECT p.keyframe, k.source, p.x, p.y, p.z, l.frame,
  CASE l.unit WHEN 1 THEN 'metres' ELSE 'unknown' END AS unit
FROM keyframe_poses p JOIN keyframes k ON k.id = p.keyframe CROSS JOIN pose_layer l;
