// SPDX-License-Identifier: Apache-2.0
// The viewer of panoramas, loaded when there is one to look at.
import "pannellum/build/pannellum.js";

interface Viewer {
  destroy(): void;
}

declare global {
  interface Window {
    pannellum: { viewer(box: HTMLElement, options: Record<string, unknown>): Viewer };
  }
}

export function showPanorama(box: HTMLElement, src: string): Viewer {
  return window.pannellum.viewer(box, { type: "equirectangular", panorama: src, autoLoad: true });
}
