-- Schema version 4: how the images of a catadioptric camera are unwrapped.

CREATE TABLE appearance_mirror (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  width INTEGER NOT NULL CHECK (width > 0),
  height INTEGER NOT NULL CHECK (height > 0),
  columns INTEGER NOT NULL CHECK (columns > 0),
  top_rad REAL NOT NULL,
  bottom_rad REAL NOT NULL CHECK (bottom_rad < top_rad),
  clockwise INTEGER NOT NULL CHECK (clockwise IN (0, 1)),
  centre_x REAL,
  centre_y REAL,
  inner_px REAL,
  outer_px REAL
) STRICT;
