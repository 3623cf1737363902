// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

// The accuracy benches: `waystone-bench NAME ARGS`. Each prints what it measured and, as its last
// line, the same as one JSON object. They return the program's exit code.
namespace waystone::bench {

using Args = std::vector<std::string>;

// world [--frames N] [--seed S] [--plan demo|other] [--repeat-poster P] [--bare-walls P] [--set
// NAME=VALUE]...: plane layer against the truth of rendered walks. --set as of `waystone build`.
int RunWorld(const Args& args);
// rgbd DIR [--map A:B] [--queries A:B:STEP] [--set NAME=VALUE]...: a TUM RGB-D folder with depth
// and poses; localization and transfer error against them.
int RunRgbd(const Args& args);
// pairs DIR... [--labels OUT] [--set NAME=VALUE]...: planes in two images against labelled matches
// (matches.csv in each folder); writes the labels it gave to OUT/NAME.txt.
int RunPairs(const Args& args);
// rendered-pairs [--pairs N] [--first SEED] [--set NAME=VALUE]...: the same against the truth of N
// pairs of frames of rendered buildings, and of N pairs of made matches of one plane with as many
// outliers, and of small planes in front of a large one.
int RunRenderedPairs(const Args& args);
// homographies DIR... [--set NAME=VALUE]...: pairs of photos of flat scenes (1.jpg and k.jpg, with
// the true homography in H_1_k.txt): error at the corners, beside OpenCV's MAGSAC.
int RunHomographies(const Args& args);
// verdicts [DATA]: localized, right and false answers and the reliability of the stated
// probability, on maps of the world and, with DATA, of kitchen and church, each queried with photos
// of all the others.
int RunVerdicts(const Args& args);
// directions [DIR...] [--detector NAME] [--photos]: Manhattan frames against vanishing points or
// poses, or against rendered truth without a folder; --photos prints each.
int RunDirections(const Args& args);
// segments IMAGE_OR_FOLDER...: repeatability and time of the segment detectors.
int RunSegments(const Args& args);
// relative [DIR]: rotations between places from the essential matrix against poses, and the
// traversability verdict against what is visible; a rendered walk without a folder.
int RunRelative(const Args& args);
// recall [DATA] [--only NAME] [--landmarks N,N,...] [--foreign N] [--keyframes N] [--search yes|no]
// [--exchanged yes|no] [--each yes|no] [--set NAME=VALUE]...: places of real data that exhaustive
// image search finds, and those that maps find, by the maps' size; photos of look-alike places and
// of other data that are wrongly found. Exchanged: queries are mapped, and mapped images are the
// queries.
int RunRecall(const Args& args);
// peers [DATA] [--only NAME,NAME] [--features sift,orb,akaze] [--foreign N]: maps beside plain
// image search over the same keyframes with the same features, on one core: found, wrong and
// foreign answers, milliseconds by stage, and bytes.
int RunPeers(const Args& args);
// cameras [DATA] [--only NAME] [--foreign N]: maps beside exhaustive image search, queried with
// photos of the same places changed as by another camera, hand or light, and by cameras of other
// focal lengths in rendered buildings.
int RunCameras(const Args& args);
int RunCollection(const Args& args);
// look-alikes [--buildings N] [--first SEED] [--width N] [--budgets yes|no] [--each yes|no] [--set
// NAME=VALUE]...: rendered buildings queried with their own places, with the same places a storey
// higher, where much looks alike, and with other buildings; and the weights of the keyframe's
// verdict, fitted to the answers. With budgets, each building keeps a different number of landmarks
// per keyframe, 30 to 100.
int RunLookAlikes(const Args& args);
// storeys [DATA] [--buildings N] [--first SEED] [--every N] [--each yes|no] [--set NAME=VALUE]...:
// maps of several look-alike storeys, made of every N-th image of rendered buildings and of the
// tower, queried with photos of each, beside exhaustive image search; and planes and edges that tie
// storeys together.
int RunStoreys(const Args& args);
// visits DATA [--visits N]: maps to which visits of the same place are added one by one, and maps
// of all the visits together, queried with the set's own queries and with photos of other places.
int RunVisits(const Args& args);
// orientation [--buildings N] [--frames N] [--camera rig|pinhole|both] [--set NAME=VALUE]...: the
// whole orientation layer of made buildings against their truth, and its time beside that of lines
// and features only.
int RunOrientation(const Args& args);
// building KITCHEN DEALERSHIP: the query's rotation in the building, and its axes as a gate, on
// maps with an orientation layer.
int RunBuilding(const Args& args);
// joining DATA [--only NAME] [--frames N]: maps of two halves beside the map of the whole, with the
// same queries; maps of look-alike places joined; and what adding a walk of 500 frames to a
// rendered map of N costs (0: not measured).
int RunJoining(const Args& args);
// joining-panoramas [PLACES] [--flats N] [--first-flat SEED]: the same with halves, for panoramas
// of made flats and of a folder as for kidnapped.
int RunJoiningPanoramas(const Args& args);
// linear DIR N...: seconds per frame of builds over the first N frames.
int RunLinear(const Args& args);
// campus N...: one map of N rendered buildings, each walked through twice: the builder's time and
// memory, links between visits, and queries.
int RunCampus(const Args& args);
// build SOURCE... [--frames N,N,...]: seconds of feature extraction and of whole builds, and the
// builds' peak memory, over the first N frames of each source.
int RunBuild(const Args& args);
// graphs [SOURCE...] [--map A:B] [--queries A:B:STEP] [--keyframes M:N] [--opencv-every N]: the
// image graph of the papers beside the plane graph over the same keyframes: size, time to build and
// to localize, recall. A source is `world`, a TUM RGB-D folder with depth and poses (--map and
// --queries are its frames, and --keyframes the conditions on keyframes), or a folder with map/,
// query*/ and poses.csv. Every N-th query also goes to OpenCV's matcher, which is slow.
int RunGraphs(const Args& args);
// poses [--buildings N] [--frames N] [--kitchen DIR] [--church DIR] [--flats N] [--first-flat SEED]
// [--panoramas DIR]: poses of queries on maps that were built with true poses: errors, recalls,
// consistency of the covariances (normalised error squared over its expectation) and time.
int RunPoses(const Args& args);
// reconstruction KITCHEN: the kitchen's first half as a plain video: its map, exported to COLMAP,
// whose mapper reconstructs poses of the keyframes, and the map with these poses, queried with the
// second half.
int RunReconstruction(const Args& args);
// scale [N...]: queries, opening and memory of maps of N features (100000 and 1000000), made from a
// rendered walk and planes that nobody sees, against the time of extraction and against exhaustive
// search.
int RunScale(const Args& args);
// compass [PLACES] [--csv PREFIX]: headings between rendered panoramas, and those of a folder with
// poses.csv and panorama/, by distance, beside a plain compass; times beside their floors.
int RunCompass(const Args& args);
// odometry [PLACES] [--walk NAME] [--k1 N] [--span N] [--max-loss X]: shape difference of the
// appearance layer of rendered walks, by odometry only and with loops closed, beside the paper's
// odometry and simulated wheels; and of a folder as for compass, in the order of its names.
int RunOdometry(const Args& args);
// study [--out DIR]: the paper's figures 8 to 11: shape difference and time over k1, k2 and steps
// of 1 to 4 panoramas in the office and the laboratory, by the paper's odometry and by ours, as
// tables and, in DIR, as SVG and CSV.
int RunStudy(const Args& args);
// page [N...]: how soon the page can be used on maps of N planes (500 and 10000), and frames per
// second of their graph, in Chromium without a graphics card.
int RunPage(const Args& args);

// serve [MAP PHOTO...] [--rounds N]: an HTTP server and its clients in one process: throughput of
// four clients, what HTTP adds to a query, and inspection while queries run. Without a map: the
// world.
int RunServe(const Args& args);
// kidnapped [PLACES]: panoramas queried against a map of all the others, rendered or of a folder as
// above, by appearance only and verified by features; photos to the front of each place; those of
// the other map; times beside decoding.
int RunKidnapped(const Args& args);

}  // namespace waystone::bench
