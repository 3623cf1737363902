// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

// Scenes of boxes lit by lamps and windows, for what World's grid can't show: furniture, changing
// light, mirrors, stairs. World frame: x east, y north, z up, metres.
namespace waystone {

enum class ScenePattern : uint8_t { kPlain, kNoise, kStripes, kBooks, kTiles };

// The appearance of a box's faces. Light is relative to that of a white wall in an evenly lit room.
struct SceneMaterial {
  double albedo = 0.8;    // share of light that is reflected, 0 to 1
  double contrast = 0;    // of the pattern, share of the albedo, 0 to 1
  double period_m = 0.2;  // of the pattern
  double gloss = 0;       // share of light that is mirrored, 0 to 1
  double glow = 0;        // light of its own when its lamp is on, or the day is bright
  int light = -1;         // the scene's light that it glows with
  ScenePattern pattern = ScenePattern::kPlain;
  uint64_t seed = 0;  // of the pattern
};

// A box, turned about the vertical.
struct SceneBox {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();
  double cosine = 1;  // of its yaw
  double sine = 0;
  bool is_wall = false;  // of the building: hides what lies behind for good
  SceneMaterial material;
};

// A lamp, or a window seen from inside. Lights only its own room.
struct SceneLight {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();  // of a window; zero shines all around
  double power = 1;
  int room = 0;
  bool is_window = false;
};

struct SceneRoom {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();   // south-west corner, seen from above
  Eigen::Vector2d high = Eigen::Vector2d::Zero();  // north-east corner
  double height_m = 2.5;

  Eigen::Vector2d Middle() const { return 0.5 * (low + high); }
  double Area() const { return (high - low).prod(); }
};

struct RoomScene {
  std::vector<SceneBox> boxes;
  std::vector<SceneLight> lights;
  std::vector<SceneRoom> rooms;
};

// How bright each of the scene's lights is: 0 is off, 1 its power.
using SceneLighting = std::vector<double>;

struct SceneHit {
  double t = 0;   // along the ray
  int box = -1;   // -1: nothing
  int axis = -1;  // of the box: the face that was hit is across it
};

// Casts rays from one place: boxes are sorted by their distance from there. Immutable and
// thread-safe; refers to the scene.
class SceneView {
 public:
  SceneView(const RoomScene& scene, const SceneLighting& lighting, const Eigen::Vector3d& centre);

  // The first surface along a unit ray.
  SceneHit Cast(const Eigen::Vector3d& ray) const;

  // The light along a unit ray from a hit; mirroring surfaces show one bounce.
  double Shade(const Eigen::Vector3d& ray, const SceneHit& hit, double cone_rad) const;

 private:
  struct NearBox {
    double nearest_m = 0;
    int box = 0;
  };
  double Reflected(const Eigen::Vector3d& point, const Eigen::Vector3d& ray,
                   const Eigen::Vector3d& normal, double cone_rad) const;
  double LightAt(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;
  double Diffuse(const SceneBox& box, const Eigen::Vector3d& point, const Eigen::Vector3d& ray,
                 const SceneHit& hit, double cone_rad) const;

  const RoomScene& scene_;
  const SceneLighting& lighting_;
  Eigen::Vector3d centre_;
  std::vector<NearBox> near_;
  std::vector<double> ambient_;  // of each room
};

// Whether the straight line between two points meets no wall. Pure; thread-safe.
bool SeesThrough(const RoomScene& scene, const Eigen::Vector3d& from, const Eigen::Vector3d& to);

// The room around a point seen from above; -1 for none. Pure; thread-safe.
int FindRoom(const RoomScene& scene, const Eigen::Vector2d& point);

}  // namespace waystone
