// `?bench`: every chain on the same late frames at this device's resolution, against the server's truth.

import { CHAINS, FILLS } from "./chain.js";
import { ANY_DEPTH, Feed, RGBA8 } from "./feed.js";
import { compose } from "./head.js";
import { Stopwatch } from "./measure.js";

const INSTANTS = 3; // of the recording, evenly spread
const ROUNDS = 3, BURST = 64; // times of each chain at each, and draws of one
const BLOCKS = 8; // parts of a picture on each side, whose means tell whether two devices show the same
const STEPS = 256; // of a level that a mean is told in

/** (h, w, 4) bytes beside those of the truth, the top row first: mean square of levels, and the means of its parts. */
export function compared(pixels, truth, [width, height]) {
  const edges = [width, height].map((side) => Array.from({ length: Math.min(BLOCKS, side) + 1 }, (_, k) => Math.floor((k * side) / Math.min(BLOCKS, side))));
  const means = [];
  let squares = 0;
  for (let row = 0; row + 1 < edges[1].length; row += 1) for (let column = 0; column + 1 < edges[0].length; column += 1) {
    const sums = [0, 0, 0], [left, right, top, low] = [edges[0][column], edges[0][column + 1], edges[1][row], edges[1][row + 1]];
    for (let y = top; y < low; y += 1) for (let x = left; x < right; x += 1) for (let k = 0; k < 3; k += 1) {
      const at = 4 * (y * width + x) + k;
      sums[k] += pixels[at];
      squares += (pixels[at] - truth[at]) ** 2;
    }
    means.push(...sums.map((sum) => Math.round((STEPS * sum) / ((right - left) * (low - top)))));
  }
  return { square: squares / (3 * width * height), means };
}

/** A connection of its own, which asks for one frame at a time. */
function frames(address) {
  let [take, fail] = [() => {}, () => {}];
  const feed = new Feed(address, { frame: (frame) => take(frame), told: (text) => text && fail(new Error(text)) });
  const opened = new Promise((go, stop) => {
    fail = stop;
    feed.socket.addEventListener("open", go);
  });
  const next = async (request) => {
    await opened;
    return new Promise((found, lost) => {
      [take, fail] = [found, lost];
      feed.ask({ sent: performance.now(), head_time: request.time, rate: 1, anew: false, colour: RGBA8, depth: ANY_DEPTH, quality: 0, mbit: 0, ...request });
    });
  };
  return { feed, next };
}

/**
 * Run it, and send what was found to a server that keeps it. head: a recording; eye: {head_from_eye, fov, size} as it is shown;
 * wide(eye): {fov, size} as it is rendered; latency: ms; display: what is told of the display. Returns the rows that were sent.
 * Throws Error where the server refuses or goes.
 */
export async function bench({ chain, address, head, eye, wide, latency, display, reports, told }) {
  const { feed, next } = frames(address), watch = new Stopwatch(chain, BURST), scratch = chain.scratch(eye.size), begun = performance.now();
  const { fov, size } = wide(eye), rows = Object.keys(CHAINS).flatMap((name) => FILLS.map((fill) => ({ chain: name, fill, warp_ms: [], total_ms: [], square: [], means: [] })));
  const at = Array.from({ length: INSTANTS }, (_, k) => latency + ((k + 1) * Math.max(head.length - latency, 0)) / (INSTANTS + 1));
  const asks = (ms, view, sides) => ({ time: ms, size: sides, head: head.at(ms), eyes: [{ world_from_eye: compose(head.at(ms), eye.head_from_eye), head_from_eye: eye.head_from_eye, fov: view }] });
  try {
    for (const [k, ms] of at.entries()) {
      told(`Measuring each chain, ${k + 1} of ${INSTANTS} ..`);
      const late = await next(asks(ms - latency, fov, size)), truth = (await next(asks(ms, eye.fov, eye.size))).eyes[0].colour;
      const [picture] = late.eyes, shown = { pose: compose(head.at(ms), eye.head_from_eye), fov: eye.fov, size: eye.size };
      chain.takeIn(0, { size, colour: picture.colour, depth: { numbers: new Float32Array(picture.depth.buffer) }, view: { pose: picture.world_from_eye, fov: picture.fov } });
      for (const row of rows) {
        row.warp_ms.push(...(await watch.times(() => chain.warpInto(0, shown, row.chain), ROUNDS)));
        row.total_ms.push(...(await watch.times(() => chain.show(0, shown, row.chain, scratch.target, [0, 0], row.fill), ROUNDS)));
        const { square, means } = compared(chain.pixels(scratch.target, eye.size), truth, eye.size);
        row.square.push(square);
        row.means.push(means);
      }
    }
    const found = { ...display, clock: watch.clock, how: watch.how, instants_ms: at, seconds: (performance.now() - begun) / 1000, rows };
    if (reports) feed.socket.send(JSON.stringify({ bench: found }));
    return found;
  } finally {
    chain.dropped(scratch);
    feed.close();
  }
}
