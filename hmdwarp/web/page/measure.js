// What drawing takes on this device: by its own timer where the browser has one, else by waiting for it. And what keeps a
// session within its budget by moving between chains, as hmdwarp's own governor does, with its numbers.
// Source: evidence by cumulative sums: Page, E. S. (1954), Continuous inspection schemes, Biometrika 41, eq. 1.

const LEAST_MS = 4; // of a burst by the page's clock, which is coarse: 0.1 ms in some browsers
const TRIES = 3; // where something else took the device meanwhile
const LOOK_MS = 2, MOST_LOOKS = 2000; // between looks at whether the timer has a result, and how many
const TIMED = { gpu: "EXT_disjoint_timer_query_webgl2", wall: "waiting until a pixel can be read: this browser has no EXT_disjoint_timer_query_webgl2" };

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

// As pipeline/governor.py has them, with the reasons.
const CLIP = 0.25, ENOUGH = 1, MARGIN = 0.95, WINDOW = 31, PATIENCE = 60, TRIAL = 240, BACK_OFF = 4, SETTLING = 2;

export function median(values) {
  const sorted = [...values].sort((a, b) => a - b), middle = sorted.length >> 1;
  return sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
}

const kept = (values, value, most) => {
  values.push(value);
  if (values.length > most) values.shift();
};

export class Governor {
  /** levels: {name, ms of an eye}, from the cheapest to the best; it starts at the best within the budget, else at the cheapest. */
  constructor(levels, budget) {
    const fits = levels.filter(({ ms }) => ms <= budget).length;
    Object.assign(this, { levels, budget, at: Math.max(fits - 1, 0), refresh: -1, failures: levels.map(() => 0) });
    this.stay(0, false);
  }

  get level() {
    return this.levels[this.at];
  }

  stay(arrived, climbed) {
    Object.assign(this, { arrived, climbed, room: this.levels.map(() => 0), window: [], evidence: 0, against: [] });
  }

  /** Count the ms of a refresh's worse eye. Returns why another level is next, in words; "" to stay. */
  measured(ms) {
    this.refresh += 1;
    if (this.refresh - this.arrived < SETTLING) return "";
    kept(this.window, ms, WINDOW);
    this.evidence = Math.min(Math.max(0, this.evidence + Math.min(Math.max(ms / this.budget - 1, -CLIP), CLIP)), ENOUGH);
    if (this.evidence) kept(this.against, ms, WINDOW >> 1);
    else this.against.length = 0;
    if (this.evidence >= ENOUGH && this.at > 0) return this.down();
    return this.window.length < WINDOW ? "" : this.up(median(this.window));
  }

  down() {
    const ms = median(this.against);
    let to = this.at - 1;
    while (to > 0 && this.expected(to, ms) > this.budget) to -= 1;
    if (this.climbed) {
      const failures = this.failures[this.at], lasted = this.refresh - this.arrived >= TRIAL * BACK_OFF ** failures;
      if (lasted) this.failures[this.at] = Math.max(0, failures - 1);
      else for (let k = this.at; k < this.failures.length; k += 1) this.failures[k] = Math.max(failures + 1, this.failures[k]);
    }
    return this.change(to, `${ms.toFixed(1)} ms exceeds the ${this.budget.toFixed(1)} ms budget`);
  }

  up(ms) {
    let to = -1;
    for (let k = this.at + 1; k < this.levels.length; k += 1) {
      this.room[k] = this.expected(k, ms) <= MARGIN * this.budget ? this.room[k] + 1 : 0;
      if (this.room[k] >= PATIENCE * BACK_OFF ** this.failures[k]) to = k;
    }
    return to < 0 ? "" : this.change(to, `expected to take ${this.expected(to, ms).toFixed(1)} of ${this.budget.toFixed(1)} ms`);
  }

  /** ms of a level, by what was measured before. */
  expected(k, ms) {
    return (ms * this.levels[k].ms) / this.level.ms;
  }

  change(to, why) {
    const climbed = to > this.at;
    this.stay(this.refresh + 1, climbed);
    this.at = to;
    return why;
  }
}
