// A session: asks for frames, shows the newest that is old enough, warped to where the head is now.

import { bench } from "./bench.js";
import { Chain, CHAINS } from "./chain.js";
import { Panels, VIDEOS, VideoEye, decodable } from "./coded.js";
import { ANY_DEPTH, DEPTH_VIDEO8, Feed, GRAB, PUSH, RELEASE, RGBA8, SWITCH } from "./feed.js";
import { ByHand, Recording, compose, relativeTo } from "./head.js";
import { Governor, Stopwatch } from "./measure.js";
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
const BENCHED = "walk"; // the recording of ?bench, where none is chosen
const MOST_KEPT = 128; // frames that wait until they are old enough
const SHARE = 0.7; // of a refresh that a chain may take
const TRIES = 3;
const LEAST_BUDGET = 1.5; // times the cheapest chain, where none fits
const MISSED = 1.5; // of the display's interval: a refresh that took longer was missed
const BEAT_MS = 50; // of what measures how late this page runs
const HELD_MS = 600, MOVED_PX = 8; // of a press that shows or hides what is told, and of one that drags
const NAMES = Object.keys(CHAINS);
const $ = (name) => document.getElementById(name);

const even = (side) => Math.max(64, 2 * Math.round(side / 2));
const lines = { first: "Connecting .." }; // what is told, by who tells it
let telling = lines.first; // all of them, also in a headset's view
function told(text, by = "page") {
  lines[by] = text;
  telling = $("told").textContent = Object.values(lines).filter(Boolean).join(" ");
}
const ages = []; // of the shown frame in ms, at the last refreshes
const AGES = 600;
let late = 0, due = performance.now() + BEAT_MS; // ms by which a busy processor delays this page, decaying
setInterval(() => {
  const now = performance.now();
  [late, due] = [Math.max(0.97 * late, now - due), now + BEAT_MS];
}, BEAT_MS);
const figures = { all: 0, refreshes: 0, stale: 0, frames: 0, since: performance.now(), script: 0, decode: 0, period: 0, last: 0 };

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
    Object.assign(this, { about, chain, kept: [], shownNumber: 0, begun: performance.now(), lastAsk: -1e9, coded: [], anew: true, looks: [], coming: 0 });
    [this.videos, this.video] = [[], "none"]; // by name, the best first, until it is known what the device decodes; and the one in use
    this.chosen = CHAINS[asked.get("warp")] ? asked.get("warp") : null;
    this.isForced = this.chosen !== null;
    this.feed = feed((frame) => this.arrived(frame));
    [this.costs, this.watch, this.why] = [{}, new Stopwatch(chain), "being measured"]; // ms of an eye, by chain
    this.pace = new Pace(RATE_HZ);
    this.predictor = new Predictor();
    this.panels = new Panels(chain);
    this.report = about.reports ? new Report(this.feed, () => this.display()) : null;
  }

  time() {
    return performance.now() - this.begun;
  }

  /** Push, switch, grab or let go what a hand points at, along its -z. What is held may be thrown by a push, so it is let go. */
  act(action, hand) {
    if (!hand) return;
    this.feed.act(this.time(), action, hand);
    if (action === PUSH) this.letGo();
  }

  letGo() {
    if (this.holding) this.act(RELEASE, this.gaze);
    this.holding = null;
  }

  /** Ask for a frame for the head as it will be, where there is room for one. eyes: {head_from_eye, fov, size} as they are shown. */
  ask(head, eyes) {
    const now = performance.now(), { mbit, scale, rate } = this.pace.wish;
    this.gaze = head;
    this.predictor.saw(now, head);
    if (now - this.lastAsk < 1000 / rate || !this.feed.hasRoom(1000 / rate, this.pace.shortest)) return;
    this.lastAsk = now;
    if (this.holding) this.act(GRAB, this.holding(head)); // what is held follows the hand
    const ahead = Math.max(Number($("latency").value), this.feed.round) + 500 / rate, then = this.predictor.at(now, ahead);
    const wide = eyes.map((eye) => guarded(eye.fov, eye.size));
    const sides = [0, 1].map((axis) => Math.max(...wide.map(({ size }) => size[axis])));
    this.pace.pixels = eyes.length * sides[0] * sides[1];
    const coded = VIDEOS[this.choose()], most = coded ? Math.min(scale, this.most(this.video)) : scale;
    this.feed.ask({
      sent: now, time: this.time(), head_time: this.time() + ahead, size: sides.map((side) => even(most * side)), head: then, rate, anew: this.anew,
      colour: coded?.colour ?? RGBA8, depth: coded ? DEPTH_VIDEO8 : ANY_DEPTH,
      quality: coded && !mbit ? 1 + this.quality : 0, mbit: mbit / eyes.length,
      panels: this.about.panels ? { size: eyes[0].size, fovs: eyes.map(({ fov }) => fov) } : null,
      eyes: eyes.map((eye, k) => ({ world_from_eye: compose(then, eye.head_from_eye), head_from_eye: eye.head_from_eye, fov: wide[k].fov })),
    });
    this.anew = false;
  }

  get quality() {
    return number("crf", VIDEOS[this.video].crf, 0, 51);
  }

  /** The share of the pictures' sides at which the server still codes them. */
  most(name) {
    return Math.min(1, Math.sqrt(this.about.most_work / (this.pace.pixels * this.about.videos[name])));
  }

  /** Take the best video that the server codes at full size, in the time between two frames. */
  choose() {
    if (this.feed.work > 1000 / RATE_HZ) this.videos.splice(0, this.videos.length - 1); // to H.264
    const name = this.videos.find((one) => this.most(one) === 1) ?? this.videos.at(-1) ?? "none";
    if (name !== this.video) this.report?.changed(this.time());
    return (this.video = name);
  }

  async arrived(frame) {
    this.coming += 1;
    const taken = frame.panels && this.panels.take(frame).catch((error) => told(`The server's panels cannot be read: ${error.message}`, "panels"));
    await this.decoded(frame, taken);
    this.coming -= 1;
  }

  async decoded(frame, taken) {
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
        this.drop({ pictures: pictures.filter((one) => one !== null) });
        this.anew = true; // a picture before it is missing: the streams begin again
        return;
      }
    }
    figures.decode = performance.now() - begun;
    await taken;
    this.kept.push({ ...frame, pictures });
    this.kept.sort((a, b) => a.number - b.number); // maps of depth unpack in any order
    while (this.kept.length > MOST_KEPT) this.drop(this.kept.shift());
  }

  /** Follow the link and the decoder, unless somebody chose a quality. */
  adapt({ heard, way, bytes, eyes }) {
    const depth = eyes.reduce((sum, eye) => sum + eye.depth.length, 0);
    const decoding = Math.max(...this.coded.map(({ colour }) => colour.decoder.decodeQueueSize));
    if (!asked.has("crf")) this.pace.took(heard, { way, bytes, depth, decoding, slack: 2 * Math.max(figures.period, late) });
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
      this.panels.show(frame);
      this.kept.splice(0, due).forEach((frame) => this.drop(frame));
      this.shown = frame;
    } else figures.stale += 1;
    return this.shown !== undefined;
  }

  /** The chain in use: the cheapest until it is known what each takes. */
  get inUse() {
    return this.chosen ?? NAMES.at(-1);
  }

  /** What an eye's chain may take, in ms: a share of the refresh; where that is too little for any, a bit more than the least. */
  budget(levels) {
    const share = (SHARE * this.interval) / this.shown.eyes.length;
    return levels[0].ms <= share ? share : LEAST_BUDGET * levels[0].ms;
  }

  /** Measure every chain on what is shown, as it is shown; then the governor chooses. Somebody's own choice is measured alone. */
  async measure(shown, eyes) {
    const key = `${shown.size} ${eyes} ${this.isForced ? this.chosen : ""}`;
    if (this.measured === key) return;
    [this.measured, this.governor] = [key, null];
    const scratch = this.chain.scratch(shown.size), costs = {};
    for (const name of this.isForced ? [this.chosen] : NAMES) {
      const times = await this.watch.times(() => this.chain.show(0, shown, name, scratch.target, [0, 0], "pyramid", this.panels.laid), TRIES);
      costs[name] = Math.min(...times); // other load can only make a chain slower
    }
    this.chain.dropped(scratch);
    if (this.measured !== key) return; // another size, or somebody's choice, meanwhile
    Object.assign(this.costs, costs);
    if (this.isForced) this.why = "selected manually";
    else this.govern(costs);
  }

  /** Begin with the best chain that fits; those that take longer than a better one are left out. */
  govern(costs) {
    const front = NAMES.filter((name, k) => NAMES.slice(0, k).every((better) => costs[better] > costs[name]));
    const levels = front.map((name) => ({ name, ms: Math.max(costs[name], 1e-3) })).reverse();
    this.governor = new Governor(levels, this.budget(levels));
    const { name, ms } = this.governor.level, least = levels[0].ms <= (SHARE * this.interval) / this.shown.eyes.length;
    this.take(name, `${least ? "the best" : "no warp meets the budget; the best"} within ${this.governor.budget.toFixed(2)} ms an eye: ${ms.toFixed(2)}`);
  }

  take(name, why) {
    [this.chosen, this.why, $("chain").value] = [name, why, name];
  }

  /** Tell the governor what a refresh took: by the device's timer, else by whether it came in time. */
  judge(period) {
    const governor = this.governor, timed = this.watch.take();
    if (!governor) return;
    governor.budget = this.budget(governor.levels);
    const inTime = period < MISSED * this.interval, paced = inTime ? Math.min(governor.level.ms, governor.budget) : (governor.budget * period) / this.interval;
    const ms = this.watch.clock === "gpu" ? timed / this.shown.eyes.length : paced;
    const before = governor.level.name, why = Number.isNaN(ms) ? "" : governor.measured(ms);
    if (why) this.take(governor.level.name, `switched from ${before}: ${why}`);
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
    return { views, pixels, late: eyes.map(({ world_from_eye, fov }) => ({ pose: world_from_eye, fov, size })), time, age: performance.now() - asked, chain: this.inUse, video: this.video };
  }

  show(head, eyes, target, corners, interval) {
    if (this.isBusy || !this.takeIn()) return;
    const views = eyes.map((eye) => ({ pose: compose(head, eye.head_from_eye), head_from_eye: eye.head_from_eye, fov: eye.fov, size: eye.size, mask: eye.mask ?? null }));
    this.interval = interval;
    this.measure(views[0], eyes.length);
    if (!figures.all) told("", "first");
    if (ages.push(performance.now() - this.shown.asked) > AGES) ages.shift();
    const isTimed = this.watch.begin(), { laid } = this.panels;
    views.forEach((view, k) => this.chain.show(Math.min(k, this.shown.eyes.length - 1), view, this.inUse, target, corners[k], "pyramid", laid));
    if (isTimed) this.watch.end();
    figures.all += 1;
    figures.refreshes += 1;
    const now = performance.now();
    this.judge(now - figures.last);
    figures.period += 0.1 * (Math.min(now - figures.last, 1000) - figures.period);
    figures.last = now;
    this.looks.splice(0).forEach((look) => look(this.seen(views, target, corners)));
    const isOwn = this.shown.eyes.length === eyes.length; // not still a window's, in a headset
    this.head = isOwn ? head : null;
    if (isOwn && `${eyes.length} ${eyes[0].size}` !== this.reported) {
      this.report?.changed(this.time());
      [this.reported, this.eyes] = [`${eyes.length} ${eyes[0].size}`, eyes];
      if (asked.has("bench")) this.bench();
    }
  }

  /** Measure every chain at this display's resolution, while nothing else is drawn. */
  async bench() {
    const [eye] = this.eyes, names = this.about.traces, played = $("head").value === "hand" ? (names.includes(BENCHED) ? BENCHED : names[0]) : $("head").value;
    this.isBusy = true;
    try {
      const found = await bench({
        chain: this.chain, address: this.feed.address, head: await headOf(played, this.about), eye, wide: ({ fov, size }) => guarded(fov, size),
        latency: Number($("latency").value), display: { ...this.display(), trace: played }, reports: this.about.reports, told: (text) => told(text, "bench"),
      });
      this.benched = found;
      told(`Measured by ${found.how}${this.about.reports ? "; the server keeps it" : "; start the server with --out to keep it"}.`, "bench");
    } catch (error) {
      told(`Not measured: ${error.message}`, "bench");
    }
    this.isBusy = false;
  }

  /** Note what a refresh took that began at `begun`. */
  ended(begun) {
    const took = performance.now() - begun;
    figures.script += took;
    if (!this.report || !this.head) return;
    this.report.add(this.time(), this.shown, this.head, this.inUse, this.costs[this.inUse] ?? 0, this.interval);
    this.head = null;
  }

  /** What a report says of the display. */
  display() {
    const [{ size: [width, height] }] = this.eyes, [wide, high] = this.shown.size;
    return {
      browser: navigator.userAgent.slice(0, 300), renderer: this.chain.renderer().slice(0, 300), codec: this.video, trace: this.xr ? "webxr" : $("head").value,
      width, height, rendered_width: wide, rendered_height: high, rate_hz: Math.round(1000 / this.interval), latency_ms: Number($("latency").value), guard: GUARD,
    };
  }
}

function tellFigures(session) {
  const passed = (performance.now() - figures.since) / 1000, frame = session.shown, cost = session.costs[session.inUse];
  if (!frame) return;
  const took = Number.isFinite(cost) ? `${cost.toFixed(2)} ms` : "not measured yet", highest = Math.max(...ages, 1);
  $("ages").setAttribute("points", ages.map((age, k) => `${((240 * k) / Math.max(ages.length - 1, 1)).toFixed(1)},${(40 - (38 * age) / highest).toFixed(1)}`).join(" "));
  $("ages-told").textContent = `Age of the shown frame at the last ${ages.length} refreshes: up to ${highest.toFixed(0)} ms`;
  $("acts").hidden = !session.feed.reacts;
  const rows = {
    "age of the shown frame": `${(performance.now() - frame.asked).toFixed(0)} ms`,
    "round trip": `${session.feed.round.toFixed(0)} ms`,
    "drawn by the server in": `${frame.drawing.toFixed(1)} ms`,
    "decoded in": `${figures.decode.toFixed(1)} ms`,
    [`warped by ${session.inUse}, an eye`]: took,
    "chosen": session.why,
    "timed by": session.watch.clock === "gpu" ? "GPU timer" : "waiting: no GPU timer",
    "script, a refresh": `${(figures.script / Math.max(figures.refreshes, 1)).toFixed(2)} ms`,
    "refreshes a second": (figures.refreshes / passed).toFixed(0),
    "frames a second": (figures.frames / passed).toFixed(0),
    "refreshes without a new frame": `${((100 * figures.stale) / Math.max(figures.refreshes, 1)).toFixed(0)} %`,
    "video": session.video,
    "received": `${((8e-6 * session.feed.bytes) / passed).toFixed(1)} Mbit/s`,
    "requested": `${session.pace.wish.mbit ? `${session.pace.mbit.toFixed(1)} Mbit/s` : session.video === "none" ? "all" : `quality ${session.quality}`}, ${session.pace.wish.rate.toFixed(0)} Hz`,
    "rendered, shown": `${frame.size.join("x")}, ${session.size.join("x")}`,
  };
  session.line = [
    `${rows["age of the shown frame"]} old, round trip ${rows["round trip"]}, drawn in ${rows["drawn by the server in"]}, decoded in ${rows["decoded in"]},`,
    `${session.inUse} ${took}, ${session.video} ${rows.received}, ${rows["refreshes without a new frame"]} without a new frame`,
  ].join(" ");
  $("rows").replaceChildren(...Object.entries(rows).map(([name, value]) => {
    const row = document.createElement("tr");
    row.append(...[name, value].map((text) => Object.assign(document.createElement("td"), { textContent: text })));
    return row;
  }));
  Object.assign(figures, { since: performance.now(), refreshes: 0, frames: 0, stale: 0, script: 0 });
  session.feed.bytes = 0;
}

let byHand = null; // one for all of a page's life, as it listens

async function headOf(name, about) {
  if (name === "hand") return (byHand ??= new ByHand($("shown"), about.viewpoint));
  return new Recording((await (await fetch(`traces/${name}.json`)).json()).samples);
}

/** A headset's own place in the scene: where the scene is seen from, turned the same way, its floor at 0. */
function placeOf({ position: [x, y, z], orientation: [, turnY, , turnW] }, hasFloor) {
  const length = Math.hypot(turnY, turnW) || 1;
  return { position: [x, hasFloor ? 0 : y, z], orientation: [0, turnY / length, 0, turnW / length] };
}

/** Call act() where something is held, from an event to any of others. */
function onHeld(target, begins, ends, act) {
  let timer = 0, from = null;
  target.addEventListener(begins, (event) => ([from, timer] = [event, setTimeout(act, HELD_MS)]));
  const isHeld = ({ type, clientX: x, clientY: y }) => type === "pointermove" && (!from || Math.hypot(x - from.clientX, y - from.clientY) < MOVED_PX);
  for (const name of ends) target.addEventListener(name, (event) => isHeld(event) || clearTimeout(timer));
}

const UNSEEN = { hidden: "The headset shows something else: this goes on after it.", "visible-blurred": "The headset shows something in front." };

async function enterVr(session, gl) {
  const refused = (error) => told(`No VR: ${error.message}`, "xr");
  const xr = await navigator.xr.requestSession("immersive-vr", { optionalFeatures: ["local-floor"] }).catch(refused);
  if (!xr?.requestReferenceSpace) return;
  const masks = []; // by a view's number, where the browser tells what its lens hides
  xr.addEventListener("visibilitymaskchange", ({ index, vertices, indices }) => (masks[index] = session.chain.mask(vertices, indices, masks[index])));
  onHeld(xr, "selectstart", ["selectend"], () => (session.tells = !session.tells));
  await gl.makeXRCompatible();
  const layer = new XRWebGLLayer(xr, gl, { antialias: false, depth: false });
  xr.updateRenderState({ baseLayer: layer });
  const floor = await xr.requestReferenceSpace("local-floor").catch(() => null);
  const space = floor ?? (await xr.requestReferenceSpace("local")), place = placeOf(session.about.viewpoint, floor !== null);
  space.addEventListener("reset", () => session.predictor.forget());
  xr.addEventListener("visibilitychange", () => told(UNSEEN[xr.visibilityState] ?? "", "xr"));
  xr.addEventListener("end", () => {
    session.xr = null;
    session.letGo();
    masks.splice(0).forEach((mask) => mask && session.chain.unmask(mask));
    told("VR has ended; the window goes on.", "xr");
    setTimeout(() => told("", "xr"), 5000);
  });
  told("", "xr");
  session.xr = xr;
  let last = 0, seen = null, newest = null;
  const pressed = new Map(); // by controller: since when, and where it pointed before the finger moved it
  const handOf = ({ targetRaySpace }, frame) => {
    const pose = frame.getPose(targetRaySpace, space);
    return pose && compose(place, poseOf(pose.transform));
  };
  xr.addEventListener("selectstart", ({ inputSource, frame }) => pressed.set(inputSource, [performance.now(), handOf(inputSource, frame)]));
  xr.addEventListener("selectend", ({ inputSource }) => {
    const [since, hand] = pressed.get(inputSource) ?? [-HELD_MS, null];
    if (performance.now() - since < HELD_MS) session.act(PUSH, hand);
  });
  xr.addEventListener("squeezestart", ({ inputSource, frame }) => {
    session.act(GRAB, handOf(inputSource, frame));
    session.holding = () => newest && handOf(inputSource, newest);
  });
  xr.addEventListener("squeezeend", () => session.letGo());
  const refresh = (now, frame) => {
    xr.requestAnimationFrame(refresh);
    newest = frame;
    const viewer = frame.getViewerPose(space), begun = performance.now();
    if (viewer) {
      const own = poseOf(viewer.transform), head = compose(place, own);
      const ports = viewer.views.map((view) => layer.getViewport(view));
      const eyes = viewer.views.map((view, k) => ({
        head_from_eye: relativeTo(poseOf(view.transform), own), fov: fovOf(view.projectionMatrix), size: [ports[k].width, ports[k].height], mask: masks[view.index ?? k],
      }));
      seen = [head, eyes, layer.framebuffer, ports.map(({ x, y }) => [x, y])];
      session.size = eyes[0].size;
      session.ask(head, eyes);
    }
    if (!seen || gl.isContextLost()) return;
    told(viewer ? "" : "The headset does not know where it is: the picture stays.", "tracking");
    session.show(...seen, xr.frameRate ? 1000 / xr.frameRate : Math.max(now - last, 8));
    const line = telling || (session.tells ? session.line : "");
    if (line) seen[1].forEach((eye, k) => session.chain.tell(line, eye, layer.framebuffer, seen[3][k]));
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
  if ("VideoDecoder" in window && !asked.has("raw")) session.videos = await decodable(Object.keys(about.videos), asked.get("codec") ?? about.codec);
  $("chain").append(...NAMES.map((name) => new Option(name)));
  $("chain").value = session.inUse;
  $("chain").onchange = () => Object.assign(session, { chosen: $("chain").value, isForced: true, governor: null });
  $("head").append(new Option("manual", "hand"), ...about.traces.map((name) => new Option(name)));
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
  const hide = () => ($("panel").hidden = !$("panel").hidden);
  addEventListener("keydown", ({ code, repeat }) => {
    if (code === "KeyH") hide();
    const action = { KeyZ: PUSH, KeyL: SWITCH, KeyB: GRAB }[code];
    if (!action || repeat || session.xr) return;
    session.act(action, session.gaze);
    if (action === GRAB) session.holding = (head) => head;
  });
  addEventListener("keyup", ({ code }) => code === "KeyB" && session.letGo());
  addEventListener("blur", () => session.letGo());
  onHeld(canvas, "pointerdown", ["pointermove", "pointerup", "pointercancel"], hide);
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
    const begun = performance.now(), ratio = canvas.clientWidth / Math.max(canvas.clientHeight, 1) || 1;
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

begin().catch((error) => {
  told(error.message);
  throw error; // for the console
});
