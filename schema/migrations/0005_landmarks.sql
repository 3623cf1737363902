-- Schema version 5: what keyframes keep beside the planes.

CREATE TABLE keyframe_landmarks (
  keyframe INTEGER PRIMARY KEY REFERENCES keyframes,
  landmark_count INTEGER NOT NULL CHECK (landmark_count > 0),
  positions_crc32c INTEGER NOT NULL,
  codes_crc32c INTEGER NOT NULL,
  positions BLOB NOT NULL,
  codes BLOB NOT NULL
) STRICT;

-- For people. The program doesn't read it.

CREATE VIEW landmark_list AS
SELECT l.keyframe, k.source, l.landmark_count AS landmarks
FROM keyframe_landmarks l JOIN keyframes k ON k.id = l.keyframe;
