-- Schema version 1. FORMAT.md says what every column means. Comments stand between the statements
-- on purpose: SQLite would store those inside one in every map.

CREATE TABLE map (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  name TEXT NOT NULL,
  program TEXT NOT NULL,
  feature_type INTEGER NOT NULL,
  options TEXT NOT NULL
) STRICT;

CREATE TABLE sequences (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  kind TEXT NOT NULL,
  frames INTEGER NOT NULL CHECK (frames >= 0),
  skipped INTEGER NOT NULL CHECK (skipped BETWEEN 0 AND frames),
  camera_model INTEGER,
  camera_width INTEGER,
  camera_height INTEGER,
  camera_params_crc32c INTEGER,
  camera_params BLOB
) STRICT;

CREATE TABLE keyframes (
  id INTEGER PRIMARY KEY,
  sequence INTEGER NOT NULL REFERENCES sequences,
  stretch INTEGER NOT NULL CHECK (stretch >= 0),
  frame INTEGER NOT NULL CHECK (frame >= 0),
  source TEXT NOT NULL,
  time_s REAL,
  width INTEGER NOT NULL CHECK (width > 0),
  height INTEGER NOT NULL CHECK (height > 0)
) STRICT;

-- Apart from keyframes, so that a scan of those doesn't read every picture.
CREATE TABLE keyframe_images (
  keyframe INTEGER PRIMARY KEY REFERENCES keyframes,
  jpeg_crc32c INTEGER NOT NULL,
  jpeg BLOB NOT NULL CHECK (length(jpeg) > 0)
) STRICT;

CREATE TABLE planes (
  id INTEGER PRIMARY KEY,
  reference_keyframe INTEGER NOT NULL REFERENCES keyframes,
  feature_count INTEGER NOT NULL CHECK (feature_count >= 0),
  vertex_count INTEGER NOT NULL CHECK (vertex_count >= 0),
  outline_crc32c INTEGER NOT NULL,
  outline BLOB NOT NULL
) STRICT;

CREATE TABLE plane_features (
  plane INTEGER PRIMARY KEY REFERENCES planes,
  keypoints_crc32c INTEGER NOT NULL,
  votes_crc32c INTEGER NOT NULL,
  descriptors_crc32c INTEGER NOT NULL,
  keypoints BLOB NOT NULL,
  votes BLOB NOT NULL,
  descriptors BLOB NOT NULL
) STRICT;

CREATE TABLE plane_views (
  plane INTEGER NOT NULL REFERENCES planes,
  keyframe INTEGER NOT NULL REFERENCES keyframes,
  inliers INTEGER NOT NULL CHECK (inliers >= 0),
  homography_crc32c INTEGER NOT NULL,
  homography BLOB NOT NULL CHECK (length(homography) = 72),
  PRIMARY KEY (plane, keyframe)
) STRICT, WITHOUT ROWID;

CREATE TABLE edges (
  a INTEGER NOT NULL REFERENCES planes,
  b INTEGER NOT NULL REFERENCES planes,
  from_keyframe INTEGER NOT NULL REFERENCES keyframes,
  to_keyframe INTEGER NOT NULL REFERENCES keyframes,
  third_eigenvalue REAL NOT NULL,
  homology_crc32c INTEGER NOT NULL,
  homology BLOB NOT NULL CHECK (length(homology) = 72),
  PRIMARY KEY (a, b),
  CHECK (a < b)
) STRICT, WITHOUT ROWID;

-- What the tables above must hold: their rows, and a CRC over every column that isn't a blob.
CREATE TABLE contents (
  table_name TEXT PRIMARY KEY,
  row_count INTEGER NOT NULL,
  crc32c INTEGER NOT NULL
) STRICT, WITHOUT ROWID;

-- For people. The program reads none of these.

CREATE VIEW map_summary AS
SELECT name, program,
  CASE feature_type WHEN 0 THEN 'sift' WHEN 1 THEN 'orb' WHEN 2 THEN 'akaze' END AS features,
  (SELECT count(*) FROM sequences) AS sequences,
  (SELECT count(*) FROM keyframes) AS keyframes,
  (SELECT count(*) FROM planes) AS planes,
  (SELECT count(*) FROM edges) AS edges,
  (SELECT coalesce(sum(feature_count), 0) FROM planes) AS plane_features
FROM map;

CREATE VIEW sequence_list AS
SELECT id, name, kind, frames, skipped,
  (SELECT count(*) FROM keyframes WHERE sequence = s.id) AS keyframes,
  CASE camera_model WHEN 0 THEN 'SIMPLE_PINHOLE' WHEN 1 THEN 'PINHOLE' WHEN 2 THEN 'SIMPLE_RADIAL'
    WHEN 3 THEN 'RADIAL' WHEN 4 THEN 'OPENCV' WHEN 5 THEN 'OPENCV_FISHEYE'
    WHEN 6 THEN 'FULL_OPENCV' WHEN 100 THEN 'EQUIRECTANGULAR' END AS camera,
  camera_width, camera_height
FROM sequences s;

CREATE VIEW keyframe_list AS
SELECT k.id, s.name AS sequence, k.stretch, k.frame, k.source, k.time_s, k.width, k.height,
  coalesce(v.planes, 0) AS planes, length(i.jpeg) AS jpeg_bytes
FROM keyframes k JOIN sequences s ON s.id = k.sequence
  LEFT JOIN (SELECT keyframe, count(*) AS planes FROM plane_views GROUP BY keyframe) v
    ON v.keyframe = k.id
  LEFT JOIN keyframe_images i ON i.keyframe = k.id;

CREATE VIEW neighbour_list AS
SELECT a AS plane, b AS neighbour FROM edges UNION ALL SELECT b, a FROM edges;

CREATE VIEW plane_list AS
SELECT p.id, p.reference_keyframe, k.source AS reference_source, p.feature_count AS features,
  p.vertex_count AS vertices,
  (SELECT count(*) FROM plane_views WHERE plane = p.id) AS views,
  (SELECT min(keyframe) FROM plane_views WHERE plane = p.id) AS first_keyframe,
  (SELECT max(keyframe) FROM plane_views WHERE plane = p.id) AS last_keyframe,
  (SELECT group_concat(neighbour, ' ') FROM neighbour_list WHERE plane = p.id) AS neighbours
FROM planes p JOIN keyframes k ON k.id = p.reference_keyframe;

CREATE VIEW view_list AS
SELECT v.plane, v.keyframe, k.source, v.inliers, v.keyframe = p.reference_keyframe AS is_reference
FROM plane_views v JOIN keyframes k ON k.id = v.keyframe JOIN planes p ON p.id = v.plane;

CREATE VIEW edge_list AS
SELECT e.a, e.b, e.from_keyframe, f.source AS from_source, e.to_keyframe, t.source AS to_source,
  e.third_eigenvalue
FROM edges e JOIN keyframes f ON f.id = e.from_keyframe JOIN keyframes t ON t.id = e.to_keyframe;
