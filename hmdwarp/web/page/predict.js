// Where the head will be when a frame is seen: hmdwarp's predictor `cautious`, with its numbers.

import { between, conjugate, multiply, turnedBy } from "./head.js";

const WINDOW = 30, TESTED = 50, ENDED = [0, 20, 40]; // ms, as poses/predictors/cautious.py has them
const FADES = 200, HORIZON = 150, MOVES = 105, MISSED = 0.25, TOO_FAR = 4;
const KNOWN = 40 + TESTED + WINDOW, GAP = 100;
const JUMP = [20, 2000, 0.25, 15]; // degrees and degrees/s, m and m/s, as poses/reading/plausibility.py has them

const minus = (a, b) => a.map((value, k) => value - b[k]);
const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);
const scaled = (a, share) => a.map((value) => share * value);

/** The rotation vector from one orientation to another, in the axes of the world. */
function turn(from, to) {
  const [x, y, z, w] = multiply(to, conjugate(from)), length = Math.hypot(x, y, z);
  const angle = 2 * Math.atan2(length, Math.abs(w)) * (w < 0 ? -1 : 1);
  return length < 1e-12 ? [0, 0, 0] : scaled([x, y, z], angle / length);
}

/** A motion of the last window, less where such a one has just failed. way(a, b): between poses; at(ms): before now, null if unknown. */
function trusted(way, at) {
  const moved = way(at(WINDOW), at(0)), share = TESTED / WINDOW, foreseen = scaled(moved, share), squared = dot(foreseen, foreseen);
  if (squared === 0) return moved;
  let doubt = 0;
  for (const ended of ENDED) {
    const window = at(ended + TESTED + WINDOW), began = at(ended + TESTED);
    const off = window ? minus(scaled(way(window, began), share), way(began, at(ended))) : foreseen;
    const along = Math.max(dot(off, foreseen), 0);
    doubt += MISSED * dot(off, off) + (TOO_FAR * along * along) / squared;
  }
  return scaled(moved, squared / (squared + doubt / ENDED.length));
}

/** Whether a head cannot have moved so: the space in which it is tracked has. */
function jumps(from, to, ms) {
  const angle = (Math.hypot(...turn(from.orientation, to.orientation)) * 180) / Math.PI, length = Math.hypot(...minus(to.position, from.position));
  return (angle > Math.max(JUMP[0], (JUMP[1] * ms) / 1000)) || (length > Math.max(JUMP[2], (JUMP[3] * ms) / 1000));
}

export class Predictor {
  constructor() {
    this.heads = []; // {ms, pose}, those that differ from the one before
  }

  saw(ms, pose) {
    const last = this.heads.at(-1);
    if (last && `${last.pose.position} ${last.pose.orientation}` === `${pose.position} ${pose.orientation}`) return;
    if (last && (ms - last.ms > GAP || jumps(last.pose, pose, ms - last.ms))) this.forget();
    this.heads.push({ ms, pose });
    while (this.heads[1]?.ms <= ms - KNOWN) this.heads.shift();
  }

  /** Begin again, as after a recentre: what was before says nothing of what comes. */
  forget() {
    this.heads.length = 0;
  }

  /** The head so many ms after `now`, when it was seen last. */
  at(now, ahead) {
    const last = this.heads.at(-1), reach = Math.min(ahead, HORIZON);
    if (last.ms - this.heads[0].ms < WINDOW || now - last.ms >= TESTED || reach <= 0) return last.pose;
    const found = new Map(), at = (back) => found.get(back) ?? found.set(back, this.before(last.ms - back)).get(back);
    const turning = trusted((a, b) => turn(a.orientation, b.orientation), at), moving = trusted((a, b) => minus(b.position, a.position), at);
    const angle = (-FADES * Math.expm1(-reach / FADES)) / WINDOW, length = Math.min(reach, MOVES) / WINDOW;
    return {
      position: last.pose.position.map((value, k) => value + length * moving[k]),
      orientation: turnedBy(scaled(turning, angle), last.pose.orientation),
    };
  }

  before(ms) {
    const next = this.heads.findIndex((head) => head.ms > ms);
    if (next < 0) return this.heads.at(-1).pose;
    if (next === 0) return null;
    const [a, b] = [this.heads[next - 1], this.heads[next]];
    return between(a.pose, b.pose, (ms - a.ms) / (b.ms - a.ms));
  }
}
