// SPDX-License-Identifier: Apache-2.0
// Numbers, verdicts and outcomes as text.
import { type Answer, type Candidate, type Explanation, type Pose } from "./api";
import type { Vec2 } from "./pose_view";

// Four matches always fit a homography, and a fifth one easily does.
const kByChance = 5;

// Rounded down, so that 89.9 % doesn't read as the required 90 %; but 0.29 is 29 %, and not what is left of it in
// binary.
export const percent = (share: number): string => `${Math.floor(100 * share + 1e-9)}%`;

// A probability; never 100%.
export const probabilityText = (probability: number): string =>
  probability > 0.99 ? "over 99%" : percent(probability);

// An angle; never -0.
export const degrees = (rad: number, digits = 0): string =>
  `${(rad * (180 / Math.PI)).toFixed(digits).replace(/^-(?=[0.]*$)/, "")}°`;

export const counted = (n: number, what: string): string =>
  `${n.toLocaleString("en")} ${what}${n === 1 ? "" : "s"}`;

// The end of a text that takes at most `most` bytes as UTF-8.
export function endWithin(text: string, most: number): string {
  const bytes = new TextEncoder().encode(text);
  let start = Math.max(0, bytes.length - most);
  while ((bytes[start] & 0xc0) === 0x80) ++start; // the rest of a character
  return new TextDecoder().decode(bytes.subarray(start));
}

// A word of a shell's command line.
export const shellWord = (text: string): string =>
  /^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;

// The unit of a frame, behind a number.
export const unitOf = (unit: Pose["unit"]): string => (unit === "metres" ? "m" : "map units");

// A value and its standard deviation, to two digits of the latter.
export function withDeviation(value: number, sigma: number): string {
  const digits = sigma > 0 ? Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(sigma)))) : 3;
  return `${value.toFixed(digits)} ± ${sigma.toFixed(digits)}`;
}

export function verdictInWords(answer: Answer): string {
  switch (answer.verdict) {
    case "localized":
      return answer.keyframe
        ? `Localized near keyframe ${answer.keyframe.id}`
        : `Localized near panorama ${answer.panorama?.node?.id}`;
    case "ambiguous":
      return "Ambiguous: several places match";
    case "not_in_map":
      return "Not in this map";
    case "bad_image":
      return "The image was refused";
    case "undecided":
      return "Undecided: the deadline expired";
  }
}

// The outcome of a candidate, and what would improve it.
export function outcomeOf(c: Candidate, why: Explanation): { outcome: string; help: string } {
  const { gates } = why;
  const share = c.matches > 0 ? c.inliers / c.matches : 0;
  switch (c.stopped_by) {
    case null:
      return { outcome: c.place === 0 ? "Accepted: best place" : "Accepted: another place", help: "" };
    case "settled":
      return { outcome: "Not verified: another place was already accepted", help: "" };
    case "no_homography":
      return {
        outcome: "Similar features, but no homography fits the matches",
        help: "If this plane is in the image: move closer or view it more frontally.",
      };
    case "min_inliers":
      return {
        outcome: `${c.inliers} inliers; at least ${gates.min_inliers} are required`,
        help: c.inliers <= kByChance
          ? "So few inliers occur by chance: no evidence of this plane."
          : "Show more of this plane: step back or turn towards it.",
      };
    case "min_inlier_share":
      return {
        outcome: `Inlier ratio ${percent(share)}; at least ${percent(gates.min_inlier_share)} is required`,
        help: "Repetitive texture. Include something unique in the image.",
      };
    case "max_scale":
      return {
        outcome: `Scale differs from the map by more than a factor of ${gates.max_scale}`,
        help: "Take the image from a distance closer to the map’s.",
      };
    default:
      return { outcome: c.stopped_by, help: "" };
  }
}

export function decisionInWords(answer: Answer): string {
  const why = answer.explanation;
  const need = why ? percent(why.gates.min_probability) : "";
  switch (answer.decided_by) {
    case "homography_inliers":
      return answer.verdict === "localized"
        ? `The best place has a probability of ${probabilityText(answer.probability)}; at least ${need} is required.`
        : "No mapped plane fits the image well enough.";
    case "epipolar_inliers":
      return `A single epipolar geometry fits the matches with a keyframe. The probability is ${probabilityText(answer.probability)}; at least ${need} is required.`;
    case "place_probability":
      return `The best place has a probability of only ${probabilityText(answer.probability)}; at least ${need} is required.`;
    case "ambiguous_places":
      return `Another place matches, too, which leaves the best one with a probability of ${probabilityText(answer.probability)}.`;
    case "shortlist_votes":
      return "No mapped plane has similar features.";
    case "features":
      return "The image has too few features.";
    case "panorama_features":
      return "Decided by the feature matches with the nearest panorama.";
    case "panorama_signature":
      return "Decided by the Fourier signature of the panorama.";
    case "photo":
    case "photo_features":
      return "Decided by matching the photo with the mapped panoramas.";
    case "series":
      return "Decided by the sequence of images.";
    case "deadline":
      return "The deadline expired before verification.";
    default:
      return answer.message ?? answer.decided_by;
  }
}

// "3, 5" as ids; null for anything else.
export function idsIn(text: string): number[] | null {
  const words = text.split(/[\s,]+/).filter((word) => word !== "");
  return words.every((word) => /^\d+$/.test(word)) ? [...new Set(words.map(Number))] : null;
}

// "0,0 4.5,0 4.5,3" as corners; null for anything else.
export function cornersIn(text: string): Vec2[] | null {
  const words = text.split(/\s+/).filter((word) => word !== "");
  const corners = words.map((word) => word.split(",").map((number) => (number === "" ? NaN : Number(number))));
  return corners.every((c) => c.length === 2 && c.every(Number.isFinite)) ? (corners as Vec2[]) : null;
}

// A corner as text, to a pixel of the drawing.
export function cornerText(corner: Vec2, px_per_unit: number): string {
  const digits = Math.min(6, Math.max(0, Math.ceil(Math.log10(px_per_unit))));
  return corner.map((v) => Number(v.toFixed(digits))).join(",");
}

export const withoutLast = (text: string): string => text.trim().split(/\s+/).slice(0, -1).join(" ");
