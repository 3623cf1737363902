// SPDX-License-Identifier: Apache-2.0
// Planes in space to turn around in, loaded when there are some to look at. The server's camera
// frame is x right, y down, z forward; three's has y up and looks along -z.
import {
  Box3, BufferGeometry, Color, DoubleSide, Float32BufferAttribute, Group, LineBasicMaterial, LineLoop,
  LineSegments, Matrix3, Mesh, NoColorSpace, PerspectiveCamera, Scene, ShaderMaterial, Sphere,
  type Texture, TextureLoader, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Space } from "./api";
import { cssColour } from "./colours";
import { trianglesOf } from "./triangles";

type Point3 = [number, number, number];
export type Side = "camera" | "side" | "above";

export interface SpaceView {
  look(from: Side): void;
  destroy(): void;
}

export interface Drawing {
  space: Space;
  colours: Map<number, string>; // of planes by their ids
  picture: string | null; // address of the keyframe's image
  size: [number, number]; // of the image in which image_from_camera has its pixels
}

const kFrustum = 0.3; // its length over how far the drawing reaches
const kAway = 1.6; // of who looks at the drawing, likewise
const kTint = 0.3; // of a plane's colour over its picture

const inThree = ([x, y, z]: Point3): Point3 => [x, -y, -z];

// The picture is projected from the camera onto the planes: each point of a plane has the pixel at
// which the camera saw it.
const kVertex = `
varying vec3 at;
void main() {
  at = vec3(position.x, -position.y, -position.z);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const kFragment = `
uniform sampler2D picture;
uniform mat3 imageFromCamera;
uniform vec2 size;
uniform vec3 colour;
uniform float tint;
varying vec3 at;
void main() {
  vec3 pixel = imageFromCamera * at;
  vec2 uv = (pixel.xy / pixel.z + 0.5) / size;
  vec3 seen = texture2D(picture, vec2(uv.x, 1.0 - uv.y)).rgb;
  gl_FragColor = vec4(mix(seen, colour, tint), 1.0);
}`;

function geometryOf(points: Point3[]): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(points.map(inThree).flat(), 3));
  return geometry;
}

// The colour as the style sheet writes it, whatever the renderer makes of colours.
function plainColour(css: string): Vector3 {
  const { r, g, b } = new Color(css).convertLinearToSRGB();
  return new Vector3(r, g, b);
}

function planeMeshes({ space, colours, size }: Drawing, picture: Texture | null): Group {
  const group = new Group();
  const [k0, k1, k2] = space.image_from_camera;
  for (const [i, plane] of space.planes.entries()) {
    if (plane.outline.length < 3) continue;
    const colour = colours.get(plane.id)!;
    const geometry = geometryOf(plane.outline);
    geometry.setIndex(trianglesOf(plane.outline, plane.normal!));
    const material = new ShaderMaterial({
      vertexShader: kVertex,
      fragmentShader: kFragment,
      side: DoubleSide,
      polygonOffset: true, // planes of one wall lie in each other
      polygonOffsetFactor: i,
      polygonOffsetUnits: i,
      uniforms: {
        picture: { value: picture },
        imageFromCamera: { value: new Matrix3().set(...k0, ...k1, ...k2) },
        size: { value: new Vector2(...size) },
        colour: { value: plainColour(colour) },
        tint: { value: picture ? kTint : 1 },
      },
    });
    group.add(new Mesh(geometry, material));
    group.add(new LineLoop(geometryOf(plane.outline), new LineBasicMaterial({ color: colour })));
  }
  return group;
}

function frustum({ space }: Drawing, length: number): LineSegments {
  const ends = space.corners.map((ray) => ray.map((x) => length * x) as Point3);
  const points = ends.flatMap((end, i): Point3[] => [[0, 0, 0], end, end, ends[(i + 1) % 4]]);
  return new LineSegments(geometryOf(points), new LineBasicMaterial({ color: cssColour("--text") }));
}

// What is drawn, with the camera: its middle and how far it reaches from there.
function extent({ space }: Drawing): Sphere {
  const box = new Box3(new Vector3(), new Vector3());
  for (const point of space.planes.flatMap((p) => p.outline)) {
    box.expandByPoint(new Vector3(...inThree(point)));
  }
  return box.getBoundingSphere(new Sphere());
}

export function showSpace(box: HTMLElement, drawing: Drawing): SpaceView {
  const renderer = new WebGLRenderer({ antialias: true, alpha: true });
  const camera = new PerspectiveCamera(50, 1, 0.01, 1000);
  const controls = new OrbitControls(camera, renderer.domElement);
  const scene = new Scene();
  const { center, radius } = extent(drawing);
  const draw = () => renderer.render(scene, camera);
  const fill = (picture: Texture | null) => {
    scene.clear();
    scene.add(planeMeshes(drawing, picture), frustum(drawing, kFrustum * radius));
    draw();
  };
  const resize = () => {
    renderer.setPixelRatio(devicePixelRatio);
    renderer.setSize(box.clientWidth, box.clientHeight, false);
    camera.aspect = box.clientWidth / Math.max(1, box.clientHeight);
    camera.updateProjectionMatrix();
    draw();
  };
  const look = (from: Side) => {
    const directions = { camera: [0.25, 0.2, 1], side: [1, 0.25, 0.35], above: [0.05, 1, 0.35] };
    controls.target.copy(center);
    camera.position.copy(center).addScaledVector(
      new Vector3(...directions[from] as Point3).normalize(), kAway * radius);
    controls.update();
    draw();
  };
  box.append(renderer.domElement);
  controls.addEventListener("change", draw);
  const resized = new ResizeObserver(resize);
  resized.observe(box);
  let gone = false;
  fill(null);
  look("camera");
  if (drawing.picture) {
    new TextureLoader().load(drawing.picture, (texture) => {
      texture.colorSpace = NoColorSpace;
      if (!gone) fill(texture);
    });
  }
  return {
    look,
    destroy() {
      gone = true;
      resized.disconnect();
      controls.dispose();
      renderer.dispose();
      renderer.domElement.remove();
    },
  };
}
