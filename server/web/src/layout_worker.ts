// SPDX-License-Identifier: Apache-2.0
// Lays out a graph beside the page's thread. Takes {nodes, edges: flat pairs of node indices},
// posts positions (x, y, x, y, ...) every few rounds, then null, and ends by itself. Deterministic: nodes start
// on a circle in their order, which for a map is the order of the walk.
import Graph from "graphology";
import forceAtlas2 from "graphology-layout-forceatlas2";

const kRounds = 40; // posts before it ends
const kIterations = 10; // a post, of a small graph
const kLargeNodes = 2000; // from here on fewer, since each takes long
const kLargeIterations = 3;

self.onmessage = (event: MessageEvent<{ nodes: number; edges: Uint32Array }>) => {
  const { nodes, edges } = event.data;
  const graph = new Graph({ type: "undirected" });
  for (let i = 0; i < nodes; ++i) {
    const angle = (2 * Math.PI * i) / nodes;
    graph.addNode(i, { x: nodes * Math.cos(angle), y: nodes * Math.sin(angle) });
  }
  for (let i = 0; i < edges.length; i += 2) graph.mergeEdge(edges[i], edges[i + 1]);
  const settings = { ...forceAtlas2.inferSettings(graph), barnesHutOptimize: nodes > 500 };
  const iterations = nodes > kLargeNodes ? kLargeIterations : kIterations;
  for (let round = 0; round < kRounds; ++round) {
    forceAtlas2.assign(graph, { iterations, settings });
    const positions = new Float32Array(2 * nodes);
    graph.forEachNode((node, { x, y }) => {
      positions[2 * Number(node)] = x;
      positions[2 * Number(node) + 1] = y;
    });
    self.postMessage(positions);
  }
  self.postMessage(null); // the end
  self.close();
};
