// A session: asks for frames, shows the newest that is old enough, warped to where the head is now.

import { Chain, CHAINS } from "./chain.js";
import { VideoEye } from "./coded.js";
import { DEPTH_VIDEO8, Feed, H264, RGBA8, ANY_DEPTH } from "./feed.js";
import { ByHand, Recording, compose, relativeTo } from "./head.js";
import { Pace } from "./pace.js";
import { Predictor } from "./predict.js";
import { Report } from "./report.js";

const asked = new URLSearchParams(location.search);
const number = (name, usual, least, most) => {
  const given = Number(asked.get(name) ?? usual);
  return Number.isFinite(given) ? Math.min(Math.max(given, least), most) : usual;
};
const RATE_HZ = number("rate", 30, 1, 120); // of requests
const GUARD = number("guard", 1.25, 1, 2); // the rendered picture's tangents over the shown one's
const LONG_SIDE = number("size", 640, 64, 4096); // pixels of the shown picture in a window
const UP_RAD = 0.61; // half a window's field of view, up and down
const QUALITY = number("crf", 18, 0, 51);
const MOST_KEPT = 128; // frames that wait until they are old enough
const SHARE = 0.7; // of a refresh that a chain may take
const TRIES = 3;
const LEAST_SHARE = 0.8, MOST_SLOW = 3; // of the display's refreshes; seconds below it
const LEAST_SAVING = 0.75; // of a chain's time that a cheaper one takes at most
const NAMES = Object.keys(CHAINS);
const $ = (name) => document.getElementById(name);

const even = (side) => Math.max(64, 2 * Math.round(side / 2));
const lines = {}; // what is told, by who tells it
let telling = ""; // all of them, also in a headset's view
function told(text, by = "page") {
  lines[by] = text;
  telling = $("told").textContent = Object.values(lines).filter(Boolean).join(" ");
}
const figures = { refreshes: 0, stale: 0, frames: 0, since: performance.now(), script: 0, decode: 0, period: 0, last: 0 };

/** A view's guarded field of view and the size that keeps its pixels per tangent: whole ones are added on each side. */
function guarded(fov, shown) {
  const size = shown.map((side) => even(side * GUARD));
  return { fov: fov.map((angle, k) => Math.atan((Math.tan(angle) * size[k >> 1]) / shown[k >> 1])), size };
}

/** Views of a window: one eye, in the middle of the head. */
function windowEyes(size) {
  const up = UP_RAD, right = Math.atan((Math.tan(up) * size[0]) / size[1]);
  return [{ head_from_eye: { position: [0, 0, 0], orientation: [0, 0, 0, 1] }, fov: [-right, right, -up, up], size }];
}

function fovOf(matrix) {
  // Of an OpenGL projection matrix, column-major: x' = (m0 x + m8 z) / -z.
  const [m0, m5, m8, m9] = [matrix[0], matrix[5], matrix[8], matrix[9]];
  return [(m8 - 1) / m0, (m8 + 1) / m0, (m9 - 1) / m5, (m9 + 1) / m5].map(Math.atan);
}

const poseOf = ({ position: p, orientation: q }) => ({ position: [p.x, p.y, p.z], orientation: [q.x, q.y, q.z, q.w] });

class Session {
  constructor(about, chain, feed) {
    Object.assign(this, { about, chain, kept: [], shownNumber: 0, begun: performance.now(), lastAsk: -1e9, coded: [], anew: true, looks: [], coming: 0, isCoded: "VideoDecoder" in window && !asked.has("raw") });
    this.chosen = CHAINS[asked.get("warp")] ? asked.get("warp") : null;
    this.isForced = this.chosen !== null;
    this.feed = feed((frame) => this.arrived(frame));
    this.costs = {};
    this.pace = new Pace(RATE_HZ);
    this.predictor = new Predictor();
    this.report = about.reports ? new Report(this.feed, () => this.display()) : null;
  }

  time() {
    return performance.now() - this.begun;
  }

  /** Ask for a frame for the head as it will be, where there is room for one. eyes: {head_from_eye, fov, size} as they are shown. */
  ask(head, eyes) {
    const now = performance.now(), { mbit, scale, rate } = this.pace.wish;
    this.predictor.saw(now, head);
    if (now - this.lastAsk < 1000 / rate || !this.feed.hasRoom(1000 / rate, this.pace.shortest)) return;
    this.lastAsk = now;
    const ahead = Math.max(Number($("latency").value), this.feed.round) + 500 / rate, then = this.predictor.at(now, ahead);
    const wide = eyes.map((eye) => guarded(eye.fov, eye.size));
    const sides = [0, 1].map((axis) => Math.max(...wide.map(({ size }) => size[axis])));
    this.pace.pixels = eyes.length * sides[0] * sides[1];
    this.feed.ask({
      sent: now, time: this.time(), head_time: this.time() + ahead, size: sides.map((side) => even(scale * side)), head: then, rate, anew: this.anew,
      colour: this.isCoded ? H264 : RGBA8, depth: this.isCoded ? DEPTH_VIDEO8 : ANY_DEPTH,
      quality: this.isCoded && !mbit ? 1 + QUALITY : 0, mbit: mbit / eyes.length,
      eyes: eyes.map((eye, k) => ({ world_from_eye: compose(then, eye.head_from_eye), head_from_eye: eye.head_from_eye, fov: wide[k].fov })),
    });
    this.anew = false;
  }

  async arrived(frame) {
    this.coming += 1;
    await this.decoded(frame);
    this.coming -= 1;
  }

  async decoded(frame) {
    const begun = performance.now();
    figures.frames += 1;
    let pictures = null;
    if (frame.colour === RGBA8) {
      pictures = frame.eyes.map((eye) => ({ colour: eye.colour, depth: { numbers: new Float32Array(eye.depth.buffer) } }));
    } else {
      this.coded = frame.eyes.map((_, k) => (this.coded[k]?.suits(frame) ? this.coded[k] : new VideoEye(frame)));
      this.adapt(frame);
      pictures = await Promise.all(frame.eyes.map((eye, k) => this.coded[k].decode(frame, eye)));
      if (pictures.includes(null)) {
        this.anew = true; // a picture before it is missing: the streams begin again
        return;
      }
    }
    figures.decode = performance.now() - begun;
    this.kept.push({ ...frame, pictures, decoded: figures.decode });
    this.kept.sort((a, b) => a.number - b.number); // maps of depth unpack in any order
    while (this.kept.length > MOST_KEPT) this.drop(this.kept.shift());
  }

  /** Follow the link and the decoder, unless somebody chose a quality. */
  adapt({ heard, way, bytes, eyes }) {
    const depth = eyes.reduce((sum, eye) => sum + eye.depth.length, 0);
    const decoding = Math.max(...this.coded.map(({ colour }) => colour.decoder.decodeQueueSize));
    if (!asked.has("crf")) this.pace.took(heard, { way, bytes, depth, decoding, slack: 2 * figures.period });
  }

  drop({ pictures }) {
    for (const { colour } of pictures) if (colour.close) colour.close();
  }

  /** Take in the newest frame that is as old as asked for. Returns whether there is any. */
  takeIn() {
    const old = performance.now() - Number($("latency").value);
    const due = this.kept.filter((frame) => frame.asked <= old).length;
    if (due) {
      const frame = this.kept[due - 1];
      frame.pictures.forEach((picture, k) => {
        this.chain.takeIn(k, { size: frame.size, ...picture, view: { pose: frame.eyes[k].world_from_eye, fov: frame.eyes[k].fov } });
      });
      this.kept.splice(0, due).forEach((frame) => this.drop(frame));
      this.shown = frame;
    } else figures.stale += 1;
    return this.shown !== undefined;
  }

  /** Measure every chain on what is shown, and choose the best that fits a refresh of `interval` ms. */
  choose(shown, interval) {
    this.interval = interval;
    if (this.chosen && this.costs[this.chosen] !== undefined) return;
    for (const name of NAMES) {
      this.chain.show(0, shown, name); // compiles
      this.chain.finish();
      const begun = performance.now();
      for (let k = 0; k < TRIES; k += 1) this.chain.show(0, shown, name);
      this.chain.finish();
      this.costs[name] = (performance.now() - begun) / TRIES;
    }
    const eyes = this.shown.eyes.length, fits = NAMES.filter((name) => eyes * this.costs[name] <= SHARE * interval);
    const cheapest = Math.min(...Object.values(this.costs)); // where none fits, the best of those that cost about as little
    this.chosen ??= fits[0] ?? NAMES.find((name) => this.costs[name] <= 1.5 * cheapest);
    $("chain").value = this.chosen;
  }

  /** Take the next cheaper chain after seconds in a row with too few refreshes, unless somebody chose this one. */
  govern(refreshes) {
    this.slow = refreshes < LEAST_SHARE * (1000 / this.interval) ? (this.slow ?? 0) + 1 : 0;
    const cheaper = NAMES.filter((name) => this.costs[name] < LEAST_SAVING * this.costs[this.chosen]);
    if (this.isForced || this.slow < MOST_SLOW || !cheaper.length) return;
    [this.chosen, this.slow] = [cheaper[0], 0];
    $("chain").value = this.chosen;
  }

  /** What the next refresh shows: its views, their late eyes, and the pixels of each, the bottom row first. */
  look() {
    return new Promise((look) => this.looks.push(look));
  }

  seen(views, target, corners) {
    const gl = this.chain.gl, [width, height] = views[0].size, bytes = 4 * width * height, pixels = new Uint8Array(bytes * views.length);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    views.forEach((_, k) => gl.readPixels(...corners[k], width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels.subarray(k * bytes, (k + 1) * bytes)));
    const { eyes, size, time, asked } = this.shown;
    return { views, pixels, late: eyes.map(({ world_from_eye, fov }) => ({ pose: world_from_eye, fov, size })), time, age: performance.now() - asked, chain: this.chosen };
  }

  show(head, eyes, target, corners, interval) {
    if (!this.takeIn()) return;
    const views = eyes.map((eye) => ({ pose: compose(head, eye.head_from_eye), fov: eye.fov, size: eye.size }));
    this.choose(views[0], interval);
    views.forEach((view, k) => this.chain.show(Math.min(k, this.shown.eyes.length - 1), view, this.chosen, target, corners[k]));
    figures.refreshes += 1;
    const now = performance.now();
    figures.period += 0.1 * (Math.min(now - figures.last, 1000) - figures.period);
    figures.last = now;
    this.looks.splice(0).forEach((look) => look(this.seen(views, target, corners)));
    this.head = head;
    if (this.report && `${eyes.length} ${eyes[0].size}` !== this.reported) {
      this.report.changed(this.time());
      [this.reported, this.eyes] = [`${eyes.length} ${eyes[0].size}`, eyes];
    }
  }

  /** Note what a refresh took that began at `begun`. */
  ended(begun) {
    const took = performance.now() - begun;
    figures.script += took;
    if (!this.report || !this.head) return;
    this.report.add(this.time(), this.shown, this.head, NAMES.indexOf(this.chosen), this.costs[this.chosen] ?? 0, took);
    this.head = null;
  }

  /** What a report says of the display. */
  display() {
    const [{ size: [width, height], fov: [left, right, down, up] }] = this.eyes, [wide, high] = this.shown.size;
    return {
      browser: navigator.userAgent.slice(0, 300), renderer: this.chain.renderer().slice(0, 300), trace: this.xr ? "webxr" : $("head").value,
      eyes: this.eyes.length, width, height, rendered_width: wide, rendered_height: high, left, right, down, up,
      rate_hz: Math.min(Math.max(Math.round(1000 / this.interval), 1), 1000), latency_ms: Number($("latency").value), guard: GUARD, chains: NAMES,
    };
  }
}

function tellFigures(session) {
  const passed = (performance.now() - figures.since) / 1000, frame = session.shown;
  if (!frame) return;
  session.govern(figures.refreshes / passed);
  const rows = {
    "age of the shown frame": `${(performance.now() - frame.asked).toFixed(0)} ms`,
    "round trip": `${session.feed.round.toFixed(0)} ms`,
    "drawn by the server in": `${frame.drawing.toFixed(1)} ms`,
    "decoded in": `${figures.decode.toFixed(1)} ms`,
    [`warped by ${session.chosen}, an eye`]: `${(session.costs[session.chosen] ?? NaN).toFixed(2)} ms`,
    "script, a refresh": `${(figures.script / Math.max(figures.refreshes, 1)).toFixed(2)} ms`,
    "refreshes a second": (figures.refreshes / passed).toFixed(0),
    "frames a second": (figures.frames / passed).toFixed(0),
    "refreshes without a new frame": `${((100 * figures.stale) / Math.max(figures.refreshes, 1)).toFixed(0)} %`,
    "received": `${((8e-6 * session.feed.bytes) / passed).toFixed(1)} Mbit/s`,
    "asked for": `${session.pace.wish.mbit ? `${session.pace.mbit.toFixed(1)} Mbit/s` : `quality ${QUALITY}`}, ${session.pace.wish.rate.toFixed(0)} Hz`,
    "rendered, shown": `${frame.size.join("x")}, ${session.size.join("x")}`,
  };
  $("figures").replaceChildren(...Object.entries(rows).map(([name, value]) => {
    const row = document.createElement("tr");
    row.append(...[name, value].map((text) => Object.assign(document.createElement("td"), { textContent: text })));
    return row;
  }));
  Object.assign(figures, { since: performance.now(), refreshes: 0, frames: 0, stale: 0, script: 0 });
  session.feed.bytes = 0;
}

async function headOf(name, about) {
  if (name === "hand") return new ByHand($("shown"), about.viewpoint);
  return new Recording((await (await fetch(`traces/${name}.json`)).json()).samples);
}

/** A headset's own place in the scene: where the scene is seen from, turned the same way, its floor at 0. */
function placeOf({ position: [x, y, z], orientation: [, turnY, , turnW] }, hasFloor) {
  const length = Math.hypot(turnY, turnW) || 1;
  return { position: [x, hasFloor ? 0 : y, z], orientation: [0, turnY / length, 0, turnW / length] };
}

const UNSEEN = { hidden: "The headset shows something else: this goes on after it.", "visible-blurred": "The headset shows something in front." };

async function enterVr(session, gl) {
  const refused = (error) => told(`No VR: ${error.message}`, "xr");
  const xr = await navigator.xr.requestSession("immersive-vr", { optionalFeatures: ["local-floor"] }).catch(refused);
  if (!xr?.requestReferenceSpace) return;
  await gl.makeXRCompatible();
  const layer = new XRWebGLLayer(xr, gl, { antialias: false, depth: false });
  xr.updateRenderState({ baseLayer: layer });
  const floor = await xr.requestReferenceSpace("local-floor").catch(() => null);
  const space = floor ?? (await xr.requestReferenceSpace("local")), place = placeOf(session.about.viewpoint, floor !== null);
  xr.addEventListener("visibilitychange", () => told(UNSEEN[xr.visibilityState] ?? "", "xr"));
  xr.addEventListener("end", () => {
    session.xr = null;
    told("VR has ended; the window goes on.", "xr");
    setTimeout(() => told("", "xr"), 5000);
  });
  told("", "xr");
  session.xr = xr;
  let last = 0, seen = null;
  const refresh = (now, frame) => {
    xr.requestAnimationFrame(refresh);
    const viewer = frame.getViewerPose(space), begun = performance.now();
    if (viewer) {
      const own = poseOf(viewer.transform), head = compose(place, own);
      const ports = viewer.views.map((view) => layer.getViewport(view));
      const eyes = viewer.views.map((view, k) => ({
        head_from_eye: relativeTo(poseOf(view.transform), own), fov: fovOf(view.projectionMatrix), size: [ports[k].width, ports[k].height],
      }));
      seen = [head, eyes, layer.framebuffer, ports.map(({ x, y }) => [x, y])];
      session.size = eyes[0].size;
      session.ask(head, eyes);
    }
    if (!seen || gl.isContextLost()) return;
    told(viewer ? "" : "The headset does not know where it is: the picture stays.", "tracking");
    session.show(...seen, xr.frameRate ? 1000 / xr.frameRate : Math.max(now - last, 8));
    if (telling) seen[1].forEach((eye, k) => session.chain.tell(telling, eye, layer.framebuffer, seen[3][k]));
    session.ended(begun);
    last = now;
  };
  xr.requestAnimationFrame(refresh);
}

async function begin() {
  const [about, shaders] = await Promise.all(["session.json", "shaders.json"].map(async (name) => (await fetch(name)).json()));
  const canvas = $("shown"), chain = new Chain(canvas, shaders);
  const address = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/feed`;
  const session = new Session(about, chain, (frame) => new Feed(address, { frame, told: (text) => told(text, "feed") }));
  $("scene").textContent = about.scene;
  $("chain").append(...NAMES.map((name) => new Option(name)));
  $("chain").onchange = () => Object.assign(session, { chosen: $("chain").value, isForced: true });
  $("head").append(new Option("by hand", "hand"), ...about.traces.map((name) => new Option(name)));
  $("latency").value = number("latency", 200, 0, 800);
  const tellLatency = () => ($("latency-told").textContent = `${$("latency").value} ms`);
  $("latency").oninput = () => {
    tellLatency();
    session.report?.changed(session.time());
  };
  tellLatency();
  const wanted = asked.get("trace");
  if (wanted !== null && !about.traces.includes(wanted)) told(`There is no trace ${wanted}: ${about.traces.join(", ")}`);
  $("head").value = about.traces.includes(wanted) ? wanted : about.head;
  let head = await headOf($("head").value, about);
  $("head").onchange = async () => {
    head = await headOf($("head").value, about);
    session.report?.changed(session.time());
  };
  $("more").onclick = () => {
    $("figures").hidden = !$("figures").hidden;
    $("more").setAttribute("aria-expanded", String(!$("figures").hidden));
  };
  addEventListener("keydown", (event) => {
    if (event.code === "KeyH") $("panel").hidden = !$("panel").hidden;
  });
  $("panel").onsubmit = (event) => event.preventDefault();
  if (await navigator.xr?.isSessionSupported("immersive-vr")) $("enter").hidden = false;
  $("enter").onclick = () => enterVr(session, chain.gl);
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    told("The graphics were taken away (another program, or too little memory): waiting for them ..");
  });
  const tellHidden = () => told(document.hidden ? "This page is hidden: it goes on when it is seen." : "", "seen");
  document.addEventListener("visibilitychange", tellHidden);
  canvas.addEventListener("webglcontextrestored", () => location.reload());
  setInterval(() => tellFigures(session), 1000);
  let last = 0, interval = 1000 / 60;
  const refresh = (now) => {
    requestAnimationFrame(refresh);
    if (session.xr || chain.gl.isContextLost()) return;
    const begun = performance.now(), ratio = innerWidth / innerHeight;
    const size = (ratio > 1 ? [LONG_SIDE, LONG_SIDE / ratio] : [LONG_SIDE * ratio, LONG_SIDE]).map(even);
    if (`${size}` !== `${session.size}`) [session.size, canvas.width, canvas.height] = [size, ...size];
    if (now > last) interval = Math.min(interval, now - last || interval);
    last = now;
    const eyes = windowEyes(size), pose = head.at(session.time());
    session.ask(pose, eyes);
    session.show(pose, eyes, null, [[0, 0]], Math.max(interval, 4));
    session.ended(begun);
  };
  requestAnimationFrame(refresh);
  globalThis.hmdwarp = { session, chain, figures };
}

if (!asked.has("quiet")) begin().catch((error) => told(error.message));
