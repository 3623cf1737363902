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
