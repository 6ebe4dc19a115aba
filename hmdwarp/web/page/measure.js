// What drawing takes on this device: by its own timer where the browser has one, else by waiting for it.

const LEAST_MS = 4; // of a burst by the page's clock, which is coarse: 0.1 ms in some browsers
const TRIES = 3; // where something else took the device meanwhile
const LOOK_MS = 2, MOST_LOOKS = 2000; // between looks at whether the timer has a result, and how many
const TIMED = { gpu: "EXT_disjoint_timer_query_webgl2", wall: "waiting until a pixel can be read" };

export class Stopwatch {
  /** most: draws of one burst. */
  constructor(chain, most = 8) {
    const gl = chain.gl, timer = gl.getExtension(TIMED.gpu);
    Object.assign(this, { chain, gl, timer, most, clock: timer ? "gpu" : "wall", waiting: [], free: [] });
  }

  /** How times are taken, for people. */
  get how() {
    return TIMED[this.clock];
  }

  /** ms of one draw(), so many times. */
  async times(draw, count) {
    const found = [];
    draw(); // compiles, and allocates
    this.chain.finish();
    while (found.length < count) found.push(await this.time(draw));
    return found;
  }

  async time(draw) {
    for (let k = 0; k < TRIES && this.clock === "gpu"; k += 1) {
      const ms = await this.byTimer(draw);
      if (ms > 0) return ms;
      if (ms === 0) this.clock = "wall"; // a timer that measures nothing
    }
    return this.byWaiting(draw);
  }

  /** ms by the device's timer; NaN where something else took the device meanwhile. */
  async byTimer(draw) {
    const { gl, timer } = this, query = gl.createQuery();
    gl.getParameter(timer.GPU_DISJOINT_EXT); // forgets what was before
    gl.beginQuery(timer.TIME_ELAPSED_EXT, query);
    draw();
    gl.endQuery(timer.TIME_ELAPSED_EXT);
    const ms = await this.result(query);
    return gl.getParameter(timer.GPU_DISJOINT_EXT) ? NaN : ms;
  }

  async result(query) {
    const { gl } = this;
    gl.flush();
    let isKnown = false;
    for (let k = 0; k < MOST_LOOKS && !isKnown; k += 1) {
      await new Promise((go) => setTimeout(go, LOOK_MS));
      isKnown = gl.getQueryParameter(query, gl.QUERY_RESULT_AVAILABLE);
    }
    const ms = isKnown ? gl.getQueryParameter(query, gl.QUERY_RESULT) / 1e6 : NaN;
    gl.deleteQuery(query);
    return ms;
  }

  /** The same by the page's clock, without what waiting itself takes. */
  byWaiting(draw) {
    const waited = (count) => {
      const begun = performance.now();
      for (let k = 0; k < count; k += 1) draw();
      this.chain.finish();
      return performance.now() - begun;
    };
    const empty = waited(0);
    for (let count = 1; ; count *= 2) {
      const took = waited(count);
      if (took >= LEAST_MS || 2 * count > this.most) return Math.max(took - empty, 0) / count;
    }
  }

  /** Begin to time a refresh; whether there is a timer for it. */
  begin() {
    const { gl, timer } = this;
    if (this.clock !== "gpu" || this.waiting.length > 3) return false;
    this.waiting.push(this.free.pop() ?? gl.createQuery());
    gl.beginQuery(timer.TIME_ELAPSED_EXT, this.waiting.at(-1));
    return true;
  }

  end() {
    this.gl.endQuery(this.timer.TIME_ELAPSED_EXT);
  }

  /** ms of the oldest refresh that was timed, once known; NaN before. */
  take() {
    const { gl } = this, [query] = this.waiting;
    if (!query || !gl.getQueryParameter(query, gl.QUERY_RESULT_AVAILABLE)) return NaN;
    const ms = gl.getQueryParameter(query, gl.QUERY_RESULT) / 1e6;
    this.free.push(this.waiting.shift());
    return ms;
  }
}
