// How much a session asks for: bits as the link carries them, pixels and frames as the bits allow.

const LEAST_SLACK_MS = 60; // that a frame may take beyond the shortest way
const CALM_MS = 3000, MOST_CALM_MS = 60_000; // without a queue before more is tried; doubled where that failed
const SETTLED_MS = 1000; // after a change, until it can be judged: its first picture is a large one
const LESS = 0.8, MORE = 1.3; // of the bits asked for, or of those that came
const LEAST_BITS = 0.14; // of a pixel, depth takes 0.1 of them: with fewer there are fewer pixels
const LEAST_MBIT = 0.2, LEAST_COLOUR_MBIT = 0.1;
const MOST_DECODING = 4; // frames that wait for the decoder
const FORGET_MS = 10_000; // the shortest way is that of the last 10 to 20 s
const SCALES = [1, 0.7, 0.5], RATES = [1, 0.5];

export class Pace {
  /** rate: of frames at best; `pixels`, set later: of all eyes' pictures at best. */
  constructor(rate) {
    Object.assign(this, { rate, pixels: 0, mbit: Infinity, colour: 0, best: 0, changed: -1e9, calm: 0, patience: CALM_MS, tried: -1e9, decodes: 0 });
    Object.assign(this, { way: 0, ways: [Infinity, Infinity], since: 0, got: 0, gotSince: NaN, received: 0, depth: 0.3 });
  }

  /** ms to the server and back at best, without what it does itself. */
  get shortest() {
    const least = Math.min(...this.ways);
    return least === Infinity ? 0 : least;
  }

  /** Note a frame: ms on its way, bytes and how many of them are depth, frames that wait for the decoder. slack: ms a busy page adds. */
  took(now, { way, bytes, depth, decoding, slack }) {
    if (now - this.since > FORGET_MS) [this.ways, this.since] = [[this.ways[1], Infinity], now];
    this.ways[1] = Math.min(this.ways[1], way);
    this.way += 0.3 * (way - this.way);
    this.depth += 0.1 * (depth / bytes - this.depth);
    if (this.mbit === Infinity) this.best += 0.1 * (8e-6 * bytes * this.rate - this.best);
    if (Number.isNaN(this.gotSince)) this.gotSince = this.changed = now;
    else this.got += bytes;
    if (now - this.gotSince > SETTLED_MS) [this.received, this.got, this.gotSince] = [(8e-3 * this.got) / (now - this.gotSince), 0, now];
    const isSlow = this.way - this.shortest > Math.max(LEAST_SLACK_MS, slack), isBehind = decoding > MOST_DECODING;
    if (isSlow || isBehind) this.calm = now;
    if (now - this.changed < SETTLED_MS + this.way) return;
    if (isSlow) this.less(now);
    else if (isBehind && this.decodes < SCALES.length - 1) [this.decodes, this.changed] = [this.decodes + 1, now];
    else if (now - this.calm > this.patience) this.more(now);
  }

  less(now) {
    if (now - this.tried < 2 * CALM_MS) this.patience = Math.min(2 * this.patience, MOST_CALM_MS);
    this.bits(Math.max(LEAST_MBIT, LESS * Math.min(this.mbit, this.received)));
    this.changed = now;
  }

  /** Ask for so many Mbit/s, of which depth takes its share as far as it is known by now: a new rate begins the videos anew. */
  bits(mbit) {
    this.mbit = mbit < this.best ? mbit : Infinity;
    this.colour = Math.max(LEAST_COLOUR_MBIT, (1 - this.depth) * mbit);
  }

  more(now) {
    if (now - this.tried > 4 * this.patience) this.patience = CALM_MS; // what was tried last has lasted
    this.decodes = Math.max(0, this.decodes - 1);
    if (this.mbit < Infinity) this.bits(MORE * this.mbit);
    [this.tried, this.changed, this.calm] = [now, now, now];
  }

  /** What to ask for: {mbit: of all colour, 0 for the best quality; scale: of the pixels' sides; rate: of frames}. */
  get wish() {
    const enough = (scale, rate) => 1e6 * this.mbit >= LEAST_BITS * this.pixels * scale ** 2 * this.rate * rate;
    const scale = SCALES.find((one, k) => k >= this.decodes && enough(one, 1)) ?? SCALES.at(-1);
    const rate = RATES.find((one) => enough(scale, one)) ?? RATES.at(-1);
    return { mbit: this.mbit === Infinity ? 0 : this.colour, scale, rate: rate * this.rate };
  }
}
