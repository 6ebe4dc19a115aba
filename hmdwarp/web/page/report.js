// What the page reports to a server that keeps it, once a second: its display where that has changed, misses, and each refresh.

const MOST_ROWS = 256, EVERY_MS = 1000;
const PLACES = [3, 3, 3, 6, 6, 6, 8, 8, 8, 8]; // decimals of a row: when it was shown, its frame's age, ms of the warp, the head

export class Report {
  /** display(): what the server is told of the display, while it stays the same. */
  constructor(feed, display) {
    Object.assign(this, { feed, display, socket: null, last: 0, told: null, isNew: true });
    this.clear();
  }

  clear() {
    Object.assign(this, { rows: [], delays: [], missed: 0 });
  }

  /** Add a refresh. now: ms of the session; frame: what it shows; head: what it was warped to; ms: of the warp; interval: of the display. */
  add(now, frame, head, warp, ms, interval) {
    if (this.told === null) Object.assign(this, { told: this.display(), isNew: true, shown: now, number: -1 });
    const round = (value, k) => Number(value.toFixed(PLACES[k]));
    const row = [now, now - frame.time, ms, ...head.position, ...head.orientation].map(round);
    if (this.number !== frame.number) this.delays.push(row[1]); // its age when it is first shown
    this.missed += Math.max(0, Math.round((now - this.shown) / interval) - 1);
    Object.assign(this, { number: frame.number, shown: now, warp });
    if (this.rows.push(row) === MOST_ROWS || now - this.last > EVERY_MS) this.send(now);
  }

  /** Send what came before something changed: what comes then is a session of its own. */
  changed(now) {
    this.send(now);
    this.told = null;
  }

  send(now) {
    const { socket } = this.feed, { rows, delays, missed, warp } = this;
    this.last = now;
    this.clear();
    if (!rows.length || socket.readyState !== WebSocket.OPEN) return;
    const display = this.isNew || socket !== this.socket ? this.told : null;
    Object.assign(this, { socket, isNew: false });
    socket.send(JSON.stringify({ display, warp, missed, delays_ms: delays, refreshes: rows }));
  }
}
