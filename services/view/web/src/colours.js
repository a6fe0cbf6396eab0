// Colour maps and what the pieces are coloured by.
import { Color } from "three";

/// Viridis at eleven places [van der Walt and Smith 2015], sRGB.
const VIRIDIS = [
  "#440154", "#482475", "#414487", "#355f8d", "#2a788e", "#21918c",
  "#22a884", "#44bf70", "#7ad151", "#bddf26", "#fde725",
].map((code) => new Color(code));

export const SOLVED = new Color("#3b7dd8");
export const SAMPLED = new Color("#e08a2c");
export const DIRECTED = new Color("#8a5cc9");
export const NEUTRAL = new Color("#8f959d");

/// The colour at a share of the scale in [0, 1].
export function viridis(share) {
  const at = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
  const low = Math.min(Math.floor(at), VIRIDIS.length - 2);
  return VIRIDIS[low].clone().lerp(VIRIDIS[low + 1], at - low);
}

/// CSS gradient of the scale.
export function viridisCss() {
  const stops = VIRIDIS.map((c) => `#${c.getHexString()}`);
  return `linear-gradient(to right, ${stops.join(", ")})`;
}
