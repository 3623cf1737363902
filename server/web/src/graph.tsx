// SPDX-License-Identifier: Apache-2.0
// The graph of surfaces on a canvas: sized by features.
import Graph from "graphology";
import Sigma from "sigma";
import { EdgeLineProgram, type NodeHoverDrawingFunction, NodePointProgram } from "sigma/rendering";
import { createNodeImageProgram } from "@sigma/node-image";
import { useEffect, useRef, useState } from "preact/hooks";
import { holdPicture, pictureAddress, picturesAreFetched, thumbnailPath } from "./api";
import { colourOf, cssColour } from "./colours";
import type { SurfaceGraph } from "./surfaces";
import { useMedia } from "./use";

const kMostPictures = 300; // nodes; more would load too many images at once
const kLargeNodes = 2000; // from here on the graph is drawn with the simplest programs
const kFullSizeNodes = 500; // from here on nodes shrink, so that they don't cover each other
const kFullSizeWidth = 700; // px, of the canvas; likewise
const kMinSize = 3;
const kMaxSize = 16;

// Shows images in the nodes, as they arrive. Returns a function that gives them back.
function addPictures(graph: Graph, map: string, { surfaces }: SurfaceGraph): () => void {
  if (surfaces.length > kMostPictures) return () => {};
  const show = (node: number, image: string) => graph.mergeNodeAttributes(node, { type: "image", image });
  if (!picturesAreFetched()) {
    for (const { id, reference } of surfaces) show(id, pictureAddress(thumbnailPath(map, reference)));
    return () => {};
  }
  const held = surfaces.map(({ id, reference }) => {
    const { value, release } = holdPicture(thumbnailPath(map, reference));
    value.then((address) => show(id, address), () => {}); // or stays a circle
    return release;
  });
  return () => held.forEach((release) => release());
}

function graphOf({ surfaces, edges }: SurfaceGraph, width: number): Graph {
  const graph = new Graph({ type: "undirected" });
  const most = surfaces.reduce((most, { features }) => Math.max(most, features), 1);
  const scale =
    Math.min(1, Math.sqrt(kFullSizeNodes / surfaces.length)) * Math.min(1, width / kFullSizeWidth);
  surfaces.forEach(({ id, features }, i) => {
    const angle = (2 * Math.PI * i) / surfaces.length;
    graph.addNode(id, {
      x: Math.cos(angle),
      y: Math.sin(angle),
      size: scale * (kMinSize + (kMaxSize - kMinSize) * Math.sqrt(features / most)),
      color: colourOf(id),
      label: `surface ${id}`,
      type: "circle",
    });
  });
  for (const [a, b] of edges) graph.mergeEdge(a, b, { size: scale });
  return graph;
}

// Starts the layout; returns a function that stops it.
function layOut(graph: Graph, { surfaces, edges }: SurfaceGraph, settled: () => void): () => void {
  const indexOf = new Map(surfaces.map(({ id }, i) => [id, i]));
  const pairs = edges.flatMap(([a, b]) => [indexOf.get(a)!, indexOf.get(b)!]);
  const worker = new Worker("/page/layout_worker.js", { type: "module" });
  worker.onmessage = ({ data }: MessageEvent<Float32Array | null>) => {
    if (!data) return settled();
    graph.updateEachNodeAttributes((node, attributes) => {
      const i = indexOf.get(Number(node))!;
      return { ...attributes, x: data[2 * i], y: data[2 * i + 1] };
    }, { attributes: ["x", "y"] });
  };
  worker.postMessage({ nodes: surfaces.length, edges: Uint32Array.from(pairs) });
  return () => worker.terminate();
}

// The selected node: a ring around it, and its label on the page's background.
const drawChosen: NodeHoverDrawingFunction = (context, data, settings) => {
  const label = data.label ?? "";
  context.font = `600 ${settings.labelSize}px ${settings.labelFont}`;
  const left = data.x + data.size + 3;
  context.fillStyle = cssColour("--ground");
  context.fillRect(left - 2, data.y - settings.labelSize, context.measureText(label).width + 4,
    1.8 * settings.labelSize);
  context.fillStyle = cssColour("--text");
  context.fillText(label, left, data.y + settings.labelSize / 3);
  context.beginPath();
  context.arc(data.x, data.y, data.size + 2, 0, 2 * Math.PI);
  context.strokeStyle = cssColour("--accent");
  context.lineWidth = 3;
  context.stroke();
};

function makeSigma(graph: Graph, box: HTMLElement): Sigma {
  const large = graph.order >= kLargeNodes;
  return new Sigma(graph, box, {
    allowInvalidContainer: true,
    hideEdgesOnMove: large,
    hideLabelsOnMove: large,
    edgeProgramClasses: large ? { line: EdgeLineProgram } : {},
    nodeProgramClasses: {
      ...(large ? { circle: NodePointProgram } : {}),
      image: createNodeImageProgram({ padding: 0.12, keepWithinCircle: true, size: { mode: "max", value: 128 } }),
    },
    defaultEdgeColor: cssColour("--line"),
    labelColor: { color: cssColour("--text") },
    labelFont: "system-ui, sans-serif",
    labelSize: 12,
    labelRenderedSizeThreshold: 9,
    labelDensity: 0.6,
    zIndex: true,
    defaultDrawNodeHover: drawChosen,
  });
}

// The selected surface and its neighbours stand out. `chosen` is asked anew at each drawing.
function highlight(sigma: Sigma, graph: Graph, chosen: () => string | null) {
  const near = (node: string) => {
    const id = chosen();
    return id !== null && (node === id || graph.areNeighbors(node, id));
  };
  sigma.setSetting("nodeReducer", (node, data) => {
    const id = chosen();
    if (id === null) return data;
    if (node === id) return { ...data, highlighted: true, forceLabel: true, zIndex: 2 };
    return near(node)
      ? { ...data, forceLabel: true, zIndex: 1 }
      : { ...data, color: cssColour("--line"), label: "", type: "circle" };
  });
  sigma.setSetting("edgeReducer", (edge, data) => {
    const id = chosen();
    if (id === null || !graph.hasExtremity(edge, id)) return data;
    return { ...data, color: cssColour("--accent"), size: 2 };
  });
}

export interface GraphProps {
  map: string;
  surfaces: SurfaceGraph;
  selected: number | null; // a plane; what is selected in the graph is a surface, by its first plane
  select: (plane: number) => void;
}

export function PlaneGraph(props: GraphProps) {
  const { map, surfaces, selected, select } = props;
  const box = useRef<HTMLDivElement>(null);
  const sigma = useRef<Sigma | null>(null);
  const chosen = useRef<string | null>(null);
  const [state, setState] = useState<"moving" | "settled">("moving");
  const dark = useMedia("(prefers-color-scheme: dark)");
  useEffect(() => {
    const graph = graphOf(surfaces, box.current!.clientWidth);
    const giveBack = addPictures(graph, map, surfaces);
    setState("moving");
    const stop = layOut(graph, surfaces, () => setState("settled"));
    const renderer = makeSigma(graph, box.current!);
    highlight(renderer, graph, () => chosen.current);
    renderer.on("clickNode", ({ node }) => select(Number(node)));
    sigma.current = renderer;
    return () => {
      stop();
      renderer.kill();
      giveBack();
      sigma.current = null;
    };
  }, [map, surfaces, dark]);
  useEffect(() => {
    const surface = selected === null ? undefined : surfaces.ofPlane.get(selected);
    chosen.current = surface === undefined ? null : String(surface);
    sigma.current?.refresh({ skipIndexation: true });
  }, [selected, surfaces, dark]);
  const camera = () => sigma.current?.getCamera();
  return (
    <div class="graph" data-state={state}>
      <div
        class="canvas"
        ref={box}
        role="img"
        aria-label="Graph of surfaces. The table of planes has the same information."
      />
      <div class="tools">
        <button aria-label="Zoom in" onClick={() => camera()?.animatedZoom()}>+</button>
        <button aria-label="Zoom out" onClick={() => camera()?.animatedUnzoom()}>−</button>
        <button onClick={() => camera()?.animatedReset()}>Fit</button>
      </div>
    </div>
  );
}
