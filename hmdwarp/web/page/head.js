// Poses in float64, and where a head comes from when no headset has it: mouse and touch, a phone's
// own turn, a recording.

export const multiply = ([ax, ay, az, aw], [bx, by, bz, bw]) => [
  aw * bx + ax * bw + ay * bz - az * by,
  aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw,
  aw * bw - ax * bx - ay * by - az * bz,
];
export const conjugate = ([x, y, z, w]) => [-x, -y, -z, w];
export const matrixOf = ([x, y, z, w]) => [
  [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
  [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
  [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
];
export const times = (a, b) => a.map((row) => b[0].map((_, k) => row.reduce((sum, value, j) => sum + value * b[j][k], 0)));
export const apply = (a, v) => a.map((row) => row.reduce((sum, value, j) => sum + value * v[j], 0));
export const rotate = (q, v) => apply(matrixOf(q), v);
export const about = (axis, angle) => [...axis.map((value) => value * Math.sin(angle / 2)), Math.cos(angle / 2)];
const normalised = (q) => q.map((value) => value / Math.hypot(...q));

/** a_from_b, b_from_c -> a_from_c; {position, orientation xyzw}. */
export const compose = (a, b) => ({
  position: rotate(a.orientation, b.position).map((value, k) => value + a.position[k]),
  orientation: normalised(multiply(a.orientation, b.orientation)),
});
/** The pose of `pose` seen from `from`: the world origin plays no part. */
export const relativeTo = (pose, from) => ({
  position: rotate(conjugate(from.orientation), pose.position.map((value, k) => value - from.position[k])),
  orientation: normalised(multiply(conjugate(from.orientation), pose.orientation)),
});

/** An orientation turned by a rotation vector in the axes of the world. */
export const turnedBy = (vector, orientation) => {
  const angle = Math.hypot(...vector);
  return angle ? normalised(multiply(about(vector.map((value) => value / angle), angle), orientation)) : orientation;
};

export function between(a, b, share) {
  let dot = a.orientation.reduce((sum, value, k) => sum + value * b.orientation[k], 0);
  const sign = dot < 0 ? -1 : 1, angle = Math.acos(Math.min(Math.abs(dot), 1));
  const [from, to] = angle < 1e-6 ? [1 - share, share] : [Math.sin((1 - share) * angle), Math.sin(share * angle)].map((value) => value / Math.sin(angle));
  return {
    position: a.position.map((value, k) => value + share * (b.position[k] - value)),
    orientation: normalised(a.orientation.map((value, k) => from * value + sign * to * b.orientation[k])),
  };
}

/** A recording, played to its end and back, so that nothing jumps. samples: [seconds, x, y, z, qx, qy, qz, qw] in order. */
export class Recording {
  constructor(samples) {
    this.samples = samples.map(([seconds, ...pose]) => ({ ms: 1000 * seconds, position: pose.slice(0, 3), orientation: pose.slice(3) }));
  }

  /** ms from its first to its last sample. */
  get length() {
    return this.samples.at(-1).ms;
  }

  at(ms) {
    const last = this.samples.at(-1).ms || 1, passed = ms % (2 * last), wanted = Math.min(passed, 2 * last - passed);
    let low = 0, high = this.samples.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.samples[middle].ms <= wanted) low = middle;
      else high = middle;
    }
    const [a, b] = [this.samples[low], this.samples[high]];
    return between(a, b, Math.min(Math.max((wanted - a.ms) / (b.ms - a.ms), 0), 1));
  }
}

const TURN = 0.004, STEP = 0.0015; // radians a pixel, metres a millisecond
const KEYS = { KeyW: [0, 0, -1], KeyS: [0, 0, 1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyQ: [0, -1, 0], KeyE: [0, 1, 0] };

/** A head moved by mouse or touch (drag to look), keys (W A S D Q E), and a phone's own turn. */
export class ByHand {
  constructor(element, start) {
    Object.assign(this, { start, yaw: 0, pitch: 0, position: [...start.position], held: new Set(), last: 0, device: null });
    let from = null;
    element.addEventListener("pointerdown", (event) => {
      from = [event.clientX, event.clientY];
      element.setPointerCapture(event.pointerId);
    });
    element.addEventListener("pointermove", (event) => {
      if (!from) return;
      this.yaw += TURN * (event.clientX - from[0]);
      this.pitch = Math.min(Math.max(this.pitch + TURN * (event.clientY - from[1]), -1.5), 1.5);
      from = [event.clientX, event.clientY];
    });
    for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, () => (from = null));
    addEventListener("keydown", (event) => this.held.add(event.code));
    addEventListener("keyup", (event) => this.held.delete(event.code));
    addEventListener("blur", () => this.held.clear());
    addEventListener("deviceorientation", (event) => {
      if (event.alpha !== null) this.device = event;
    });
  }

  turn() {
    if (!this.device) return multiply(about([0, 1, 0], this.yaw), about([1, 0, 0], this.pitch));
    // Source: W3C Device Orientation, 3.1: intrinsic Z-X'-Y'' of a device that lies flat, x east.
    const [alpha, beta, gamma] = [this.device.alpha, this.device.beta, this.device.gamma].map((degrees) => (degrees * Math.PI) / 180);
    const turned = multiply(multiply(about([0, 0, 1], alpha), about([1, 0, 0], beta)), about([0, 1, 0], gamma));
    const upright = about([0, 0, 1], (-(screen.orientation?.angle ?? 0) * Math.PI) / 180);
    return multiply(about([0, 1, 0], this.yaw), multiply(multiply(about([1, 0, 0], -Math.PI / 2), turned), upright));
  }

  at(ms) {
    const orientation = normalised(multiply(this.start.orientation, this.turn()));
    const passed = Math.min(Math.max(ms - this.last, 0), 100);
    this.last = Math.max(ms, this.last);
    for (const key of this.held) {
      if (!KEYS[key]) continue;
      const way = rotate(orientation, KEYS[key]);
      this.position = this.position.map((value, k) => value + STEP * passed * way[k]);
    }
    return { position: [...this.position], orientation };
  }
}
