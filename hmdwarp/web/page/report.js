// What the page reports to a server that keeps it: its display, then a row of numbers a refresh, once a second.

import { compose, inverse } from "./head.js";

const COLUMNS = 23, MOST_ROWS = 256, EVERY_MS = 1000, MAGIC = [72, 87, 76, 71]; // HWLG

export class Report {
  /** display(): what the server is told of the display, while it stays the same. */
  constructor(feed, display) {
    Object.assign(this, { feed, display, count: 0, last: 0, told: null, isNew: false, socket: null, number: -1, drawn: null });
    this.message = new Uint8Array(4 + 8 * COLUMNS * MOST_ROWS);
    this.message.set(MAGIC);
    this.view = new DataView(this.message.buffer);
  }

  put(column, value) {
    this.view.setFloat64(4 + 8 * (this.count * COLUMNS + column), value, true);
  }

  putPose(column, { position, orientation }) {
    for (let k = 0; k < 3; k += 1) this.put(column + k, position[k]);
    for (let k = 0; k < 4; k += 1) this.put(column + 3 + k, orientation[k]);
  }

  /** Add a refresh. now: ms of the session; frame: what it shows; head: what it was warped to. */
  add(now, frame, head, chain, warp, script) {
    if (this.told === null) [this.told, this.isNew] = [JSON.stringify(this.display()), true];
    if (this.number !== frame.number) {
      const [eye] = frame.eyes;
      [this.number, this.drawn] = [frame.number, compose(eye.world_from_eye, inverse(eye.head_from_eye))];
    }
    this.put(0, now);
    this.put(1, frame.time);
    this.put(2, frame.number);
    this.put(3, chain);
    this.put(4, warp);
    this.put(5, script);
    this.put(6, frame.drawing);
    this.put(7, frame.decoded);
    this.put(8, Math.max(0, frame.heard - frame.asked));
    this.putPose(9, head);
    this.putPose(16, this.drawn);
    this.count += 1;
    if (this.count === MOST_ROWS || now - this.last > EVERY_MS) this.send(now);
  }

  /** Send what came before something changed: what comes then is a session of its own. */
  changed(now) {
    this.send(now);
    this.told = null;
  }

  send(now) {
    const { socket } = this.feed, count = this.count;
    [this.count, this.last] = [0, now];
    if (!count || socket.readyState !== WebSocket.OPEN) return;
    if (this.isNew || socket !== this.socket) socket.send(this.told);
    [this.socket, this.isNew] = [socket, false];
    socket.send(this.message.subarray(0, 4 + 8 * COLUMNS * count));
  }
}
