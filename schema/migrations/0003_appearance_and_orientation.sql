-- Schema version 3: the appearance layer (panoramas) and the orientation layer (the building's
-- axes). A map without a layer has no row in any of its tables.

CREATE TABLE appearance_layer (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  signature_rows INTEGER NOT NULL CHECK (signature_rows > 0),
  k1 INTEGER NOT NULL CHECK (k1 > 0),
  k2 INTEGER NOT NULL CHECK (k2 > 0),
  top_rad REAL NOT NULL,
  bottom_rad REAL NOT NULL CHECK (bottom_rad < top_rad),
  normalised INTEGER NOT NULL CHECK (normalised IN (0, 1)),
  metres_per_unit REAL CHECK (metres_per_unit > 0),
  dropped INTEGER NOT NULL CHECK (dropped >= 0)
) STRICT;

CREATE TABLE appearance_nodes (
  id INTEGER PRIMARY KEY,
  sequence INTEGER NOT NULL REFERENCES sequences,
  frame INTEGER NOT NULL CHECK (frame >= 0),
  source TEXT NOT NULL,
  time_s REAL,
  x REAL NOT NULL,
  y REAL NOT NULL,
  theta_rad REAL NOT NULL
) STRICT;

CREATE TABLE appearance_signatures (
  node INTEGER PRIMARY KEY REFERENCES appearance_nodes,
  magnitudes_crc32c INTEGER NOT NULL,
  phases_crc32c INTEGER NOT NULL,
  magnitudes BLOB NOT NULL,
  phases BLOB NOT NULL
) STRICT;

CREATE TABLE appearance_features (
  node INTEGER PRIMARY KEY REFERENCES appearance_nodes,
  feature_count INTEGER NOT NULL CHECK (feature_count > 0),
  bearings_crc32c INTEGER NOT NULL,
  codes_crc32c INTEGER NOT NULL,
  bearings BLOB NOT NULL,
  codes BLOB NOT NULL
) STRICT;

CREATE TABLE appearance_images (
  node INTEGER PRIMARY KEY REFERENCES appearance_nodes,
  jpeg_crc32c INTEGER NOT NULL,
  jpeg BLOB NOT NULL CHECK (length(jpeg) > 0)
) STRICT;

CREATE TABLE appearance_edges (
  a INTEGER NOT NULL REFERENCES appearance_nodes,
  b INTEGER NOT NULL REFERENCES appearance_nodes,
  kind INTEGER NOT NULL,
  distance REAL NOT NULL CHECK (distance >= 0),
  x REAL NOT NULL,
  y REAL NOT NULL,
  heading_rad REAL NOT NULL,
  deviation_rad REAL NOT NULL CHECK (deviation_rad >= 0),
  PRIMARY KEY (a, b),
  CHECK (a < b)
) STRICT, WITHOUT ROWID;

CREATE TABLE appearance_verdict (
  id INTEGER PRIMARY KEY CHECK (id IN (1, 2)),
  intercept REAL NOT NULL,
  positives INTEGER NOT NULL CHECK (positives >= 0),
  negatives INTEGER NOT NULL CHECK (negatives >= 0)
) STRICT;

CREATE TABLE appearance_verdict_terms (
  id INTEGER PRIMARY KEY,
  verdict INTEGER NOT NULL REFERENCES appearance_verdict,
  name TEXT NOT NULL,
  weight REAL NOT NULL
) STRICT;

CREATE TABLE orientation_layer (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  step INTEGER NOT NULL CHECK (step > 0)
) STRICT;

CREATE TABLE orientation_frames (
  id INTEGER PRIMARY KEY,
  sequence INTEGER NOT NULL REFERENCES sequences,
  frame INTEGER NOT NULL CHECK (frame >= 0),
  source TEXT NOT NULL,
  time_s REAL,
  reliable INTEGER NOT NULL CHECK (reliable IN (0, 1)),
  lines_x INTEGER NOT NULL CHECK (lines_x >= 0),
  lines_y INTEGER NOT NULL CHECK (lines_y >= 0),
  lines_z INTEGER NOT NULL CHECK (lines_z >= 0),
  qw REAL,
  qx REAL,
  qy REAL,
  qz REAL,
  covariance_crc32c INTEGER,
  covariance BLOB CHECK (length(covariance) = 72)
) STRICT;

CREATE TABLE orientation_turns (
  frame INTEGER PRIMARY KEY REFERENCES orientation_frames,
  direction INTEGER NOT NULL CHECK (direction IN (-1, 1)),
  angle_rad REAL NOT NULL,
  confirmed INTEGER NOT NULL CHECK (confirmed IN (0, 1)),
  axis_after INTEGER NOT NULL CHECK (axis_after IN (0, 1))
) STRICT;

CREATE TABLE orientation_nodes (
  frame INTEGER PRIMARY KEY REFERENCES orientation_frames,
  kind INTEGER NOT NULL,
  up INTEGER NOT NULL CHECK (up >= 0),
  right INTEGER NOT NULL CHECK (right >= 0),
  down INTEGER NOT NULL CHECK (down >= 0),
  left INTEGER NOT NULL CHECK (left >= 0)
) STRICT;

CREATE TABLE orientation_images (
  frame INTEGER PRIMARY KEY REFERENCES orientation_nodes,
  jpeg_crc32c INTEGER NOT NULL,
  jpeg BLOB NOT NULL CHECK (length(jpeg) > 0)
) STRICT;

CREATE TABLE orientation_edges (
  a INTEGER NOT NULL REFERENCES orientation_nodes,
  b INTEGER NOT NULL REFERENCES orientation_nodes,
  kind INTEGER NOT NULL,
  matches INTEGER NOT NULL CHECK (matches >= 0),
  PRIMARY KEY (a, b),
  CHECK (a < b)
) STRICT, WITHOUT ROWID;

CREATE TABLE corridors (
  first_frame INTEGER PRIMARY KEY REFERENCES orientation_frames,
  last_frame INTEGER NOT NULL REFERENCES orientation_frames,
  axis INTEGER NOT NULL CHECK (axis IN (0, 1)),
  CHECK (first_frame <= last_frame)
) STRICT;

-- For people. The program reads none of these.

CREATE VIEW appearance_node_list AS
SELECT n.id, s.name AS sequence, n.frame, n.source, n.time_s, n.x, n.y,
  round(degrees(n.theta_rad), 2) AS theta_deg,
  (SELECT count(*) FROM appearance_edges WHERE n.id IN (a, b)) AS edges,
  coalesce(f.feature_count, 0) AS features, length(i.jpeg) AS jpeg_bytes
FROM appearance_nodes n JOIN sequences s ON s.id = n.sequence
  LEFT JOIN appearance_features f ON f.node = n.id
  LEFT JOIN appearance_images i ON i.node = n.id;

CREATE VIEW appearance_edge_list AS
SELECT e.a, p.source AS a_source, e.b, q.source AS b_source,
  CASE e.kind WHEN 0 THEN 'consecutive' WHEN 1 THEN 'loop' END AS kind, e.distance, e.x, e.y,
  round(degrees(e.heading_rad), 2) AS heading_deg,
  round(degrees(e.deviation_rad), 2) AS deviation_deg
FROM appearance_edges e JOIN appearance_nodes p ON p.id = e.a JOIN appearance_nodes q ON q.id = e.b;

CREATE VIEW orientation_frame_list AS
SELECT f.id, s.name AS sequence, f.frame, f.source, f.time_s, f.reliable, f.lines_x, f.lines_y,
  f.lines_z,
  round(degrees(atan2(2 * (f.qy * f.qz - f.qw * f.qx), 2 * (f.qx * f.qz + f.qw * f.qy))), 2)
    AS heading_deg
FROM orientation_frames f JOIN sequences s ON s.id = f.sequence;

CREATE VIEW turn_list AS
SELECT t.frame, f.source, CASE t.direction WHEN 1 THEN 'left' ELSE 'right' END AS direction,
  round(degrees(t.angle_rad), 2) AS angle_deg,
  CASE t.confirmed WHEN 1 THEN 'turn' ELSE 'false turn' END AS verdict,
  CASE t.axis_after WHEN 0 THEN 'x' ELSE 'y' END AS axis_after
FROM orientation_turns t JOIN orientation_frames f ON f.id = t.frame;

CREATE VIEW orientation_node_list AS
SELECT n.frame, f.source, CASE n.kind WHEN 0 THEN 'traversable' WHEN 1 THEN 'turn' END AS kind,
  n.up, n.right, n.down, n.left,
  (SELECT count(*) FROM orientation_edges WHERE n.frame IN (a, b)) AS edges,
  length(i.jpeg) AS jpeg_bytes
FROM orientation_nodes n JOIN orientation_frames f ON f.id = n.frame
  LEFT JOIN orientation_images i ON i.frame = n.frame;

CREATE VIEW corridor_list AS
SELECT c.first_frame, f.source AS first_source, c.last_frame, l.source AS last_source,
  CASE c.axis WHEN 0 THEN 'x' ELSE 'y' END AS axis
FROM corridors c JOIN orientation_frames f ON f.id = c.first_frame
  JOIN orientation_frames l ON l.id = c.last_frame;
