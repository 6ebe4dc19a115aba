// The feed in a browser: requests go up, frames come down, as docs/feed.md has them.

import { rotate } from "./head.js";

const VERSION = 3, ASK = 1, FRAME = 2, REFUSAL = 3;
export const RGBA16F = 1, RGBA8 = 2, ANY_DEPTH = 1, DEPTH_VIDEO8 = 4, NONE = 255;
const ASK_BYTES = 180, FRAME_BYTES = 80, EYE_BYTES = 144, PART_BYTES = 32, FATE_BYTES = 17, INPUT_BYTES = 73;
const TAKES_SESSION = 2, TAKES_INPUTS = 8, MOST_FATES = 512, MOST_INPUTS = 512;
const MOST_ACTED = 2 ** 14 - MOST_INPUTS; // a server keeps so many inputs of a session, those told again included
export const PUSH = 1, SWITCH = 2, GRAB = 3, RELEASE = 4;
const PANELS = "panels", PANELS_BYTES = 20_000; // a layer, and how much of it a frame may bring
const MOST_IN_FLIGHT = 8; // requests without an answer
const LOST_MS = 1000; // after which a request gets no answer any more: a newer one took its place
const AGAIN_MS = 1000; // before a lost server is called again

const ns = (ms) => BigInt(Math.round(ms * 1e6));

function putPose(view, at, pose) {
  [...pose.position, ...pose.orientation].forEach((value, k) => view.setFloat64(at + 8 * k, value, true));
  return at + 56;
}

function putAngles(view, at, fov) {
  fov.forEach((angle, k) => view.setFloat64(at + 8 * k, angle, true));
  return at + 32;
}

function getPose(view, at) {
  const values = Array.from({ length: 7 }, (_, k) => view.getFloat64(at + 8 * k, true));
  return { position: values.slice(0, 3), orientation: values.slice(3) };
}

/**
 * A request's bytes. eyes: {world_from_eye, head_from_eye, fov: [left, right, down, up] in radians}.
 * panels: {size, fovs} of the shown pictures where the scene's panels are wished; fates: {number, arrived, time}, null where there is no session.
 * inputs: {time, action, hand}, what people did with a hand whose ray is along -z.
 */
export function encodeAsk({ number, sent, time, head_time, received, size, head, eyes, colour, depth, anew, rate, quality, mbit, panels = null, fates = null, inputs = [] }) {
  const bytes = ASK_BYTES + EYE_BYTES * eyes.length + (panels ? 40 + 32 * eyes.length : 0) + (fates ? 16 + FATE_BYTES * fates.length : 0) + (inputs.length ? 2 + INPUT_BYTES * inputs.length : 0);
  const view = new DataView(new ArrayBuffer(bytes));
  [72, 87, 70, 68].forEach((letter, k) => view.setUint8(k, letter)); // HWFD
  view.setUint16(4, VERSION, true);
  view.setUint16(6, ASK, true);
  view.setUint32(8, bytes, true);
  view.setBigUint64(12, BigInt(number), true);
  [sent, time, head_time].forEach((instant, k) => view.setBigInt64(20 + 8 * k, ns(instant), true));
  view.setBigUint64(44, BigInt(received), true);
  view.setUint32(84, size[0], true);
  view.setUint32(88, size[1], true);
  [eyes.length, colour, depth, quality, anew ? 1 : 0, panels ? 1 : 0, 0, (fates ? TAKES_SESSION : 0) + (inputs.length ? TAKES_INPUTS : 0)].forEach((value, k) => view.setUint8(92 + k, value));
  view.setFloat64(100, rate, true);
  view.setFloat64(108, mbit, true);
  let at = putPose(view, 124, head);
  for (const eye of eyes) {
    at = putPose(view, putPose(view, at, eye.world_from_eye), eye.head_from_eye);
    at = putAngles(view, at, eye.fov);
  }
  if (panels) {
    panels.size.forEach((side, k) => view.setUint32(at + 4 * k, side, true));
    at = panels.fovs.reduce((there, fov) => putAngles(view, there, fov), at + 8);
    new TextEncoder().encodeInto(PANELS, new Uint8Array(view.buffer, at));
    [1, 1].forEach((count, k) => view.setUint16(at + 20 + 2 * k, count, true)); // a row of one number
    view.setFloat64(at + 24, PANELS_BYTES, true);
    at += 32;
  }
  if (fates) {
    view.setUint16(at + 14, fates.length, true);
    fates.forEach((fate, k) => {
      view.setBigUint64(at + 16 + FATE_BYTES * k, BigInt(fate.number), true);
      view.setUint8(at + 24 + FATE_BYTES * k, fate.arrived ? 1 : 0);
      view.setBigInt64(at + 25 + FATE_BYTES * k, ns(fate.time), true);
    });
    at += 16 + FATE_BYTES * fates.length;
  }
  if (inputs.length) view.setUint16(at, inputs.length, true);
  inputs.forEach(({ time, action, hand }, k) => {
    const from = at + 2 + INPUT_BYTES * k; // its target stays empty: what the hand means
    view.setBigInt64(from, ns(time), true);
    view.setUint8(from + 8, action);
    [...hand.position, ...rotate(hand.orientation, [0, 0, -1])].forEach((value, n) => view.setFloat64(from + 25 + 8 * n, value, true));
  });
  return view.buffer;
}

/** What a server's message says: {kind: "frame" | "refusal", ..}. Throws Error for anything else. */
export function decode(buffer) {
  const view = new DataView(buffer), kind = view.getUint16(6, true);
  if (view.getUint32(0, true) !== 0x44465748 || view.getUint32(8, true) !== buffer.byteLength) throw new Error("no message of the feed");
  const number = Number(view.getBigUint64(12, true));
  if (kind === REFUSAL) {
    return { kind: "refusal", number, why: new TextDecoder().decode(new Uint8Array(buffer, 24, view.getUint32(20, true))) };
  }
  if (kind !== FRAME || view.getUint16(4, true) !== VERSION) throw new Error(`a message of kind ${kind}`);
  const ms = (at) => Number(view.getBigInt64(at, true)) / 1e6;
  const [count, colour, depth, begins] = [68, 69, 70, 71].map((at) => view.getUint8(at));
  const size = [view.getUint32(60, true), view.getUint32(64, true)], parts = view.getUint8(76);
  let at = FRAME_BYTES + EYE_BYTES * count, from = at + 8 * count + PART_BYTES * parts;
  const eyes = Array.from({ length: count }, (_, k) => {
    const first = FRAME_BYTES + EYE_BYTES * k;
    const eye = { world_from_eye: getPose(view, first), head_from_eye: getPose(view, first + 56) };
    eye.fov = [0, 1, 2, 3].map((angle) => view.getFloat64(first + 112 + 8 * angle, true));
    for (const name of ["colour", "depth"]) {
      const length = view.getUint32(at, true);
      eye[name] = new Uint8Array(buffer.slice(from, from + length)); // a copy: numbers are aligned
      from += length;
      at += 4;
    }
    return eye;
  });
  let panels = null;
  for (let k = 0; k < parts; k += 1, at += PART_BYTES) {
    const name = new TextDecoder().decode(new Uint8Array(buffer, at, 16)).replace(/\0+$/, ""), bytes = view.getUint32(at + 28, true);
    if (name === PANELS) panels = { isPacked: view.getUint8(at + 18) !== 0, length: view.getUint32(at + 20, true), bytes: new Uint8Array(buffer, from, bytes) };
    from += bytes;
  }
  if (from > buffer.byteLength) throw new Error("a frame that is cut short");
  return { kind: "frame", number, asked: ms(20), received: ms(28), sent: ms(36), drawing: ms(44), time: ms(52), size, colour, depth,
    begins: begins !== 0, place: view.getUint32(72, true), eyes, bytes: buffer.byteLength, panels, takes: view.getUint8(77), began: view.getUint16(78, true) };
}

/** One server, called again whenever it is gone. told(text): a line for people, "" once all is well. */
export class Feed {
  constructor(address, { frame, told }) {
    Object.assign(this, { address, frame, told, number: 0, newest: 0, bytes: 0, answered: new Map(), closed: false, fates: null });
    Object.assign(this, { reacts: false, began: -1, acted: [], known: 0, toldIn: new Map() }); // inputs, how many the server is known to have
    this.asked = new Map(); // when each request that has no answer yet was sent
    [this.round, this.work] = [0, 0]; // ms from a request to its frame, and of the server's in it, smoothed
    this.open();
  }

  open() {
    this.socket = new WebSocket(this.address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.told("");
    this.socket.onmessage = (message) => this.take(message.data);
    this.socket.onclose = () => {
      this.asked.clear();
      this.known = 0;
      if (this.closed) return;
      this.told("Connection lost: the last image stays. Reconnecting ..");
      const strange = () => this.told("The server does not accept this browser any more: open the address that it printed last.");
      fetch("session.json", { method: "HEAD" }).then((answer) => answer.status === 403 && strange(), () => {}); // browsers keep a body that nothing reads
      setTimeout(() => this.open(), AGAIN_MS);
    };
  }

  close() {
    this.closed = true;
    this.socket.close();
  }

  /** Whether another request may go up: so many are under way as the shortest round trip has room for. */
  hasRoom(interval, shortest) {
    const lost = performance.now() - Math.max(LOST_MS, 4 * this.round);
    for (const [number, sent] of this.asked) if (sent < lost) this.asked.delete(number);
    const most = Math.min(MOST_IN_FLIGHT, 1 + Math.ceil((shortest + this.work) / interval));
    return this.socket.readyState === WebSocket.OPEN && this.asked.size < most && this.socket.bufferedAmount === 0;
  }

  ask(request) {
    this.number += 1;
    this.asked.set(this.number, request.sent);
    const fates = this.fates?.slice(0, MOST_FATES) ?? null; // each told until a request that told it is answered
    for (const fate of fates ?? []) [fate.in, fate.time] = [fate.in ?? this.number, fate.time ?? request.time];
    const inputs = this.reacts ? this.acted.slice(this.known, this.known + MOST_INPUTS) : [];
    if (inputs.length) this.toldIn.set(this.number, [this.known, this.known + inputs.length]);
    this.socket.send(encodeAsk({ ...request, number: this.number, received: this.newest, fates, inputs }));
    return this.number;
  }

  /** Tell what people did, with the requests from now on until one that told it is answered. */
  act(time, action, hand) {
    if (this.reacts && this.acted.length < MOST_ACTED) this.acted.push({ time, action, hand });
  }

  heardInputs({ number, began }) {
    const [from, to] = this.toldIn.get(number) ?? [0, 0];
    if (from <= this.known) this.known = Math.max(this.known, to);
    if (began !== this.began) [this.began, this.known] = [began, 0]; // it knows nothing of what it was told before
    for (const older of this.toldIn.keys()) if (older <= number) this.toldIn.delete(older);
  }

  take(data) {
    const message = decode(data), now = performance.now();
    for (const number of this.asked.keys()) if (number <= message.number) this.asked.delete(number);
    if (message.kind === "refusal") {
      this.told(`The server refused: ${message.why}`);
      return;
    }
    this.reacts = (message.takes & TAKES_INPUTS) !== 0;
    this.heardInputs(message);
    if (message.panels && message.takes & TAKES_SESSION) {
      this.fates = (this.fates ?? []).filter((fate) => !(fate.in <= message.number));
      for (let number = this.newest + 1; number <= message.number; number += 1) this.fates.push({ number, arrived: number === message.number });
    }
    this.newest = message.number;
    this.bytes += message.bytes;
    const took = now - message.asked, work = message.sent - message.received;
    this.round = this.round ? this.round + 0.1 * (took - this.round) : took;
    this.work += 0.1 * (work - this.work);
    this.frame({ ...message, heard: now, way: Math.max(0, took - work) });
  }
}
