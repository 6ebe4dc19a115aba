// `?bench`: every chain on the same late frames at this device's resolution, against the server's truth.

import { CHAINS, FILLS } from "./chain.js";
import { ANY_DEPTH, Feed, RGBA8 } from "./feed.js";
import { compose } from "./head.js";
import { Stopwatch, median } from "./measure.js";

const INSTANTS = 3; // of the recording, evenly spread
const ROUNDS = 3, BURST = 64; // times of each chain at each, and draws of one

/** PSNR in dB of (h, w, 4) bytes against those of the truth, at most 100. */
export function psnr(pixels, truth) {
  let squares = 0;
  for (let at = 0; at < pixels.length; at += 1) if (at % 4 < 3) squares += (pixels[at] - truth[at]) ** 2;
  return Math.min(100, 10 * Math.log10((255 ** 2 * 0.75 * pixels.length) / squares));
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

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
 * wide(eye): {fov, size} as it is rendered; latency: ms; display: what is told of the display. Returns that, how times were taken, and a row for each chain and fill.
 * Throws Error where the server refuses or goes.
 */
export async function bench({ chain, address, head, eye, wide, latency, display, reports, told }) {
  const { feed, next } = frames(address), watch = new Stopwatch(chain, BURST), scratch = chain.scratch(eye.size), begun = performance.now();
  const { fov, size } = wide(eye), rows = Object.keys(CHAINS).flatMap((name) => FILLS.map((fill) => ({ warp: name, fill, warp_ms: [], total_ms: [], psnr_db: [] })));
  const at = Array.from({ length: INSTANTS }, (_, k) => latency + ((k + 1) * Math.max(head.length - latency, 0)) / (INSTANTS + 1));
  const asks = (ms, view, sides) => ({ time: ms, size: sides, head: head.at(ms), eyes: [{ world_from_eye: compose(head.at(ms), eye.head_from_eye), head_from_eye: eye.head_from_eye, fov: view }] });
  try {
    for (const [k, ms] of at.entries()) {
      told(`Measuring each chain, ${k + 1} of ${INSTANTS} ..`);
      const late = await next(asks(ms - latency, fov, size)), truth = (await next(asks(ms, eye.fov, eye.size))).eyes[0].colour;
      const [picture] = late.eyes, shown = { pose: compose(head.at(ms), eye.head_from_eye), fov: eye.fov, size: eye.size };
      chain.takeIn(0, { size, colour: picture.colour, depth: { numbers: new Float32Array(picture.depth.buffer) }, view: { pose: picture.world_from_eye, fov: picture.fov } });
      for (const row of rows) {
        row.warp_ms.push(...(await watch.times(() => chain.warpInto(0, shown, row.warp), ROUNDS)));
        row.total_ms.push(...(await watch.times(() => chain.show(0, shown, row.warp, scratch.target, [0, 0], row.fill), ROUNDS)));
        chain.show(0, shown, row.warp, scratch.target, [0, 0], row.fill); // again, to be read at once: in a headset others draw meanwhile
        row.psnr_db.push(psnr(chain.pixels(scratch.target, eye.size), truth));
      }
    }
    const about = { ...display, clock: watch.clock, how: watch.how, seconds: (performance.now() - begun) / 1000 };
    const found = rows.map((row) => ({ ...row, warp_ms: median(row.warp_ms), total_ms: median(row.total_ms), psnr_db: mean(row.psnr_db) }));
    if (reports) feed.socket.send(JSON.stringify({ display: about, bench: found }));
    return { ...about, rows: found };
  } finally {
    chain.dropped(scratch);
    feed.close();
  }
}
