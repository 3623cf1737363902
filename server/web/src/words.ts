// SPDX-License-Identifier: Apache-2.0
// Numbers and outcomes as words.
import { type Answer, type Candidate, type Explanation } from "./api";

// Four matches always fit a homography, and a fifth one easily does.
const kByChance = 5;

// Rounded down, so that 89.9 % doesn't look like the 90 % that are needed.
export const percent = (share: number): string => `${Math.floor(100 * share)} %`;

// A probability; nothing is certain.
export const sure = (probability: number): string =>
  probability > 0.99 ? "over 99 %" : percent(probability);

export const counted = (n: number, what: string): string =>
  `${n.toLocaleString("en")} ${what}${n === 1 ? "" : "s"}`;

export function verdictInWords(answer: Answer): string {
  switch (answer.verdict) {
    case "localized":
      return answer.keyframe
        ? `This is near keyframe ${answer.keyframe.id}`
        : `This is near panorama ${answer.panorama?.node?.id}`;
    case "ambiguous":
      return "Several places look like this";
    case "not_in_map":
      return "This place isn’t in the map";
    case "bad_image":
      return "This file can’t be read as a photo";
    case "undecided":
      return "There was no time to decide";
  }
}

// What became of a candidate, and what would help it.
export function outcomeOf(c: Candidate, why: Explanation): { outcome: string; help: string } {
  const { gates } = why;
  const share = c.matches > 0 ? c.inliers / c.matches : 0;
  switch (c.stopped_by) {
    case null:
      return { outcome: c.place === 0 ? "Fits: the best place" : "Fits: another place", help: "" };
    case "settled":
      return { outcome: "Not tried: another place had settled it", help: "" };
    case "no_homography":
      return {
        outcome: "Looks alike, but no plane fits the matches",
        help: "If it should fit: get closer, or look at it more squarely.",
      };
    case "min_inliers":
      return {
        outcome: `${c.inliers} inliers of the ${gates.min_inliers} that are needed`,
        help: c.inliers <= kByChance
          ? "So few fit by chance: no sign of this surface."
          : "Show more of this surface: step back, or turn towards it.",
      };
    case "min_inlier_share":
      return {
        outcome: `${percent(share)} of the matches agree; ${percent(gates.min_inlier_share)} are needed`,
        help: "Patterns repeat here. Show something that is there only once.",
      };
    case "max_scale":
      return {
        outcome: `It would be seen over ${gates.max_scale} times larger or smaller than in the map`,
        help: "Take the photo from a distance more like the map’s.",
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
        ? `The best place is ${sure(answer.probability)} sure, and ${need} are needed.`
        : "No plane of the map fits the photo well enough.";
    case "place_probability":
      return `The best place fits, but is only ${sure(answer.probability)} sure; ${need} are needed.`;
    case "ambiguous_places":
      return `A second place has at least ${percent(why?.gates.ambiguous_share ?? 0)} of the best one’s inliers.`;
    case "shortlist_votes":
      return "Nothing in the map looks like anything in the photo.";
    case "features":
      return "There is too little to see in the photo.";
    default:
      return answer.message ?? answer.decided_by;
  }
}
