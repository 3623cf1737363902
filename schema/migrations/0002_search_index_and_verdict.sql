-- Schema version 2: the search index over the descriptors of all planes, in a format of its own.

CREATE TABLE search_index (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  format INTEGER NOT NULL,
  list_count INTEGER NOT NULL CHECK (list_count >= 0),
  feature_count INTEGER NOT NULL CHECK (feature_count >= 0),
  centres_crc32c INTEGER NOT NULL,
  lists_crc32c INTEGER NOT NULL,
  centres BLOB NOT NULL,
  lists BLOB NOT NULL
) STRICT;

-- The model behind the probability of an answer, calibrated when the map was built.
CREATE TABLE verdict_model (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  intercept REAL NOT NULL,
  log_inliers REAL NOT NULL CHECK (log_inliers > 0),
  inlier_share REAL NOT NULL,
  positives INTEGER NOT NULL CHECK (positives >= 0),
  negatives INTEGER NOT NULL CHECK (negatives >= 0)
) STRICT;
