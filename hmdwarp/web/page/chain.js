// The passes of a refresh on the device: depth in, warp, pull, panels, push. WebGL 2, the shaders of hmdwarp.

import { apply, matrixOf, relativeTo, times } from "./head.js";

const TOLD = { size: [768, 192], metres: [0.6, 0.15], pose: { position: [0, 0, -2], orientation: [0, 0, 0, 1] }, isOnHead: true, letters: 40 };

// As IterativeSettings and DEPTH_LIMITS of hmdwarp have them.
const LIMITS = { depth_tolerance: 0.03, depth_floor: 0.02 }, SHEET = 1, CONVERGED = 0.75;
const NEARER = 1 + 2 ** -10, EDGE_ON_M = 1e-6; // as client/effects/text.py has them
const GRID = 64; // cells a side, as CloudXR.js draws
const LEAST_SIDE = 4; // pixels of the pyramid's top
const MOST_PYRAMIDS = 2; // sizes of shown pictures: the window's and the headset's
/** Every chain, the best first; each says which warp it runs. */
export const CHAINS = { iterative: "iterative", "mesh:grid=64": "mesh", rotation: "rotation" };

export const FILLS = ["none", "pyramid"];

const tangents = (fov) => fov.map(Math.tan);

/** The matrix from eye points (x, y, -1) to pixels; the origin is bottom left, or top left. */
function camera(fov, [width, height], isTopFirst) {
  const [left, right, down, up] = tangents(fov), [sx, sy] = [width / (right - left), height / (up - down)];
  return isTopFirst
    ? [[sx, 0, left * sx], [0, -sy, -up * sy], [0, 0, -1]]
    : [[sx, 0, left * sx], [0, sy, down * sy], [0, 0, -1]];
}

function inverted([[a, b, c], [d, e, f], [g, h, i]]) {
  const [A, B, C] = [e * i - f * h, f * g - d * i, d * h - e * g], det = a * A + b * B + c * C;
  return [[A, c * h - b * i, b * f - c * e], [B, a * i - c * g, c * d - a * f], [C, b * g - a * h, a * e - b * d]].map((row) => row.map((value) => value / det));
}

/** H and e of the map between pixels of two views; {pose, fov, size, isTopFirst}. Source: McMillan and Bishop 1995. */
export function mapBetween(from, to) {
  const there = relativeTo(from.pose, to.pose), k = camera(to.fov, to.size, to.isTopFirst);
  return { H: times(times(k, matrixOf(there.orientation)), inverted(camera(from.fov, from.size, from.isTopFirst))), e: apply(k, there.position) };
}

const placeTo = ({ pose, isOnHead }, shown) => relativeTo(pose, isOnHead ? shown.head_from_eye : shown.pose);

/** From shown pixels to (u w, v w, w) on a panel, w its inverse depth in 1/m; null where its front is not seen. */
function panelFromShown(panel, shown) {
  const { position: at, orientation } = placeTo(panel, shown), axes = [0, 1, 2].map((k) => matrixOf(orientation).map((row) => row[k]));
  const [across, up, facing] = axes.map((axis) => axis[0] * at[0] + axis[1] * at[1] + axis[2] * at[2]);
  if (!(facing <= -EDGE_ON_M)) return null;
  const inverse = axes[2].map((value) => value / facing);
  const ofRay = [across, up].map((along, k) => axes[k].map((value, j) => (value - along * inverse[j]) / panel.metres[k] + 0.5 * inverse[j]));
  return times([...ofRay, inverse], inverted(camera(shown.fov, shown.size, false)));
}

/** First pixel and extent of what may show a panel: all of the view where a part of it lies behind the eye; null for none. */
function boxOf(map, size) {
  const shownFromPanel = inverted(map), corners = [[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]].map((corner) => apply(shownFromPanel, corner));
  const before = corners.filter(([, , depth]) => depth > 0).length;
  if (before < 4) return before && { low: [0, 0], extent: size };
  const ends = size.map((side, k) => {
    const places = corners.map((corner) => corner[k] / corner[2]);
    return [Math.max(Math.floor(Math.min(...places)) - 1, 0), Math.min(Math.ceil(Math.max(...places)) + 1, side)];
  });
  return ends.every(([low, high]) => low < high) && { low: ends.map(([low]) => low), extent: ends.map(([low, high]) => high - low) };
}

/** What whole.vert reads. */
const seen = ({ mask, fov }) => (mask ? { edges: tangents(fov) } : {});

const movesWholePixels = ({ H: [[a, b, x], [c, d, y], [f, g, h]], e }) =>
  [a - 1, b, x - Math.round(x), c, f, g, h - 1, Math.abs(d) - 1, y - Math.round(y), ...e].every((off) => Math.abs(off) <= 1e-9);

export class Chain {
  /** shaders: texts by name. Throws Error, with what is missing, where the device cannot. */
  constructor(canvas, shaders, options = {}) {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, ...options });
    if (!gl) throw new Error("This browser has no WebGL 2.");
    if (!gl.getExtension("EXT_color_buffer_float")) throw new Error("This device draws no float textures (EXT_color_buffer_float).");
    Object.assign(this, { gl, canvas, shaders, programs: new Map(), eyes: [], pyramids: new Map(), vertices: gl.createVertexArray() });
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  }

  program(fragment, { vertex = "whole.vert", defines = "" } = {}) {
    const key = `${vertex} ${fragment} ${defines}`, gl = this.gl;
    if (this.programs.has(key)) return this.programs.get(key);
    const program = gl.createProgram();
    for (const [kind, name] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, this.shaders[name].replace("\n", `\n${defines}\n`));
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(`${name}: ${gl.getShaderInfoLog(shader)}`);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(`${fragment}: ${gl.getProgramInfoLog(program)}`);
    const uniforms = new Map();
    for (let k = 0; k < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); k += 1) {
      const { name, type } = gl.getActiveUniform(program, k);
      uniforms.set(name, { type, at: gl.getUniformLocation(program, name) });
    }
    this.programs.set(key, { program, uniforms });
    return this.programs.get(key);
  }

  /** Use a program with its uniforms; textures are {texture}. */
  use(found, values) {
    const gl = this.gl;
    gl.useProgram(found.program);
    let unit = 0;
    for (const [name, value] of Object.entries(values)) {
      const uniform = found.uniforms.get(name);
      if (!uniform) continue;
      if (value instanceof WebGLTexture) {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, value);
        gl.uniform1i(uniform.at, unit++);
      } else if (uniform.type === gl.FLOAT_MAT3) gl.uniformMatrix3fv(uniform.at, true, value.flat());
      else if (uniform.type === gl.FLOAT) gl.uniform1f(uniform.at, value);
      else if (uniform.type === gl.FLOAT_VEC2) gl.uniform2fv(uniform.at, value);
      else if (uniform.type === gl.FLOAT_VEC3) gl.uniform3fv(uniform.at, value);
      else if (uniform.type === gl.FLOAT_VEC4) gl.uniform4fv(uniform.at, value);
      else if (uniform.type === gl.INT_VEC2) gl.uniform2iv(uniform.at, value);
      else gl.uniform1i(uniform.at, value);
    }
  }

  texture(format, [width, height], filter = this.gl.NEAREST, levels = 1) {
    const gl = this.gl, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, levels, format, width, height);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, filter);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return texture;
  }

  target(textures, depth = null) {
    const gl = this.gl, target = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    textures.forEach((texture, k) => gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + k, gl.TEXTURE_2D, texture, 0));
    gl.drawBuffers(textures.map((_, k) => gl.COLOR_ATTACHMENT0 + k));
    if (depth) gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    return target;
  }

  draw(target, [width, height], count = 3, [x, y] = [0, 0], mask = null) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.viewport(x, y, width, height);
    gl.bindVertexArray(mask ? mask.vertices : this.vertices);
    if (mask) gl.drawElements(gl.TRIANGLES, mask.count, gl.UNSIGNED_INT, 0);
    else gl.drawArrays(gl.TRIANGLES, 0, count);
  }

  /**
   * Triangles of a view that can be seen, as WebXR has them: tangents x, y, and three indices each; null for all of it.
   * old: what it takes the place of.
   */
  mask(places, indices, old = null) {
    const gl = this.gl;
    if (!indices.length) return old && this.unmask(old);
    const mask = old ?? { vertices: gl.createVertexArray(), buffers: [gl.createBuffer(), gl.createBuffer()] };
    gl.bindVertexArray(mask.vertices);
    [[gl.ARRAY_BUFFER, places], [gl.ELEMENT_ARRAY_BUFFER, indices]].forEach(([target, values], k) => {
      gl.bindBuffer(target, mask.buffers[k]);
      gl.bufferData(target, values, gl.STATIC_DRAW);
    });
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    gl.bindVertexArray(null);
    return Object.assign(mask, { count: indices.length });
  }

  unmask({ vertices, buffers }) {
    this.gl.deleteVertexArray(vertices);
    for (const buffer of buffers) this.gl.deleteBuffer(buffer);
    return null;
  }

  /** A picture to draw into that is not shown, until it is dropped. */
  scratch(size, format = this.gl.RGBA8) {
    const texture = this.texture(format, size);
    return { texture, target: this.target([texture]) };
  }

  dropped({ texture, target }) {
    this.gl.deleteFramebuffer(target);
    this.gl.deleteTexture(texture);
  }

  /** (h, w, 4) bytes of what was drawn, the top row first. */
  pixels(target, [width, height]) {
    const gl = this.gl, found = new Uint8Array(4 * width * height), turned = new Uint8Array(4 * width * height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, found);
    for (let row = 0; row < height; row += 1) turned.set(found.subarray(4 * width * row, 4 * width * (row + 1)), 4 * width * (height - 1 - row));
    return turned;
  }

  /** The textures of an eye's rendered picture, made once for a size. */
  eye(k, size, isCoded) {
    const key = `${size} ${isCoded}`, gl = this.gl;
    if (this.eyes[k]?.key === key) return this.eyes[k];
    const old = this.eyes[k];
    if (old) for (const texture of [old.colour, old.given, old.kinds, old.depth]) if (texture) gl.deleteTexture(texture);
    if (old) gl.deleteFramebuffer(old.into);
    const depth = this.texture(gl.R32F, size);
    this.eyes[k] = {
      key, size, depth,
      colour: this.texture(gl.SRGB8_ALPHA8, size, gl.LINEAR),
      given: this.texture(isCoded ? gl.R8UI : gl.R32F, size),
      kinds: isCoded ? this.texture(gl.R8UI, size) : null,
      into: this.target([depth]),
    };
    return this.eyes[k];
  }

  /**
   * Take in an eye's late picture, the top row first: colour as bytes (sRGB, coverage) or a VideoFrame;
   * depth as {numbers} in 1/m or {codes, kinds, step, bend}; view {pose, fov}.
   */
  takeIn(k, { size, colour, depth, view }) {
    const gl = this.gl, isCoded = depth.codes !== undefined, eye = this.eye(k, size, isCoded), [width, height] = size;
    const put = (texture, format, type, pixels) => {
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, format, type, pixels);
    };
    put(eye.colour, gl.RGBA, gl.UNSIGNED_BYTE, colour);
    if (isCoded) {
      put(eye.given, gl.RED_INTEGER, gl.UNSIGNED_BYTE, depth.codes);
      put(eye.kinds, gl.RED_INTEGER, gl.UNSIGNED_BYTE, depth.kinds);
    } else put(eye.given, gl.RED, gl.FLOAT, depth.numbers);
    eye.view = { ...view, size, isTopFirst: true };
    gl.disable(gl.DEPTH_TEST);
    const given = isCoded ? { codes: eye.given, kinds: eye.kinds, code_step: depth.step, bend: depth.bend } : { given: eye.given };
    this.use(this.program("depth_in.frag", { defines: isCoded ? "#define CODED" : "" }), { ...given, ...LIMITS, rendered_size: size });
    this.draw(eye.into, size);
  }

  /** Levels of the shown picture, the finest first, made once for a size. */
  pyramid(size) {
    const key = `${size}`, gl = this.gl;
    if (this.pyramids.has(key)) return this.pyramids.get(key);
    const levels = [];
    for (let [width, height] = size; ; [width, height] = [(width + 1) >> 1, (height + 1) >> 1]) {
      const colour = this.texture(gl.RGBA16F, [width, height], gl.LINEAR), whole = levels.length ? this.texture(gl.RGBA16F, [width, height], gl.LINEAR) : null;
      const depth = this.texture(gl.R32F, [width, height]);
      let nearest = null;
      if (!levels.length) {
        nearest = gl.createRenderbuffer();
        gl.bindRenderbuffer(gl.RENDERBUFFER, nearest);
        gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
      }
      levels.push({ size: [width, height], colour, whole, depth, nearest, into: this.target([colour, depth], nearest), over: this.target([whole ?? colour]) });
      if (Math.max(width, height) <= LEAST_SIDE) break;
    }
    this.pyramids.set(key, levels);
    if (this.pyramids.size > MOST_PYRAMIDS) this.forget(...this.pyramids.entries().next().value);
    return levels;
  }

  forget(key, levels) {
    const gl = this.gl;
    for (const { colour, whole, depth, nearest, into, over } of levels) {
      for (const texture of [colour, whole, depth]) gl.deleteTexture(texture);
      for (const target of [into, over]) gl.deleteFramebuffer(target);
      gl.deleteRenderbuffer(nearest);
    }
    this.pyramids.delete(key);
  }

  warp(name, eye, shown, level) {
    const gl = this.gl;
    const sizes = { rendered_size: eye.size, shown_size: shown.size, rendered_colour: eye.colour, rendered_inverse_depth: eye.depth };
    if (name === "mesh") {
      gl.bindFramebuffer(gl.FRAMEBUFFER, level.into);
      gl.enable(gl.DEPTH_TEST);
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
      gl.clearBufferfv(gl.COLOR, 1, [-1, 0, 0, 0]);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      this.use(this.program("mesh.frag", { vertex: "mesh.vert" }), { ...sizes, ...mapBetween(eye.view, shown), cells: GRID });
      this.draw(level.into, shown.size, 6 * GRID * GRID);
      gl.disable(gl.DEPTH_TEST);
      return;
    }
    const map = mapBetween(shown, eye.view), back = mapBetween(eye.view, shown);
    const limits = { ...LIMITS, sheet: SHEET, most_pixels: CONVERGED, last_centre: eye.size.map((side) => side - 0.5) };
    gl.bindTexture(gl.TEXTURE_2D, eye.colour);
    const filter = movesWholePixels(map) ? gl.NEAREST : gl.LINEAR; // an unmoved head stays bit-exact
    for (const which of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, which, filter);
    if (shown.mask) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, level.into);
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]); // a hole, as what the fill reads is never of a frame before
      gl.clearBufferfv(gl.COLOR, 1, [-1, 0, 0, 0]);
    }
    this.use(this.over(shown, name), { ...sizes, ...map, ...limits, ...seen(shown), rendered_pixel: eye.size.map((side) => 1 / side), depth_ratio: [...back.H[2], back.e[2]] });
    this.draw(level.into, shown.size, 3, [0, 0], shown.mask);
  }

  /** A program over all of a view that can be seen. */
  over({ mask }, fragment, defines = "") {
    return this.program(fragment, { defines: `${mask ? "#define SEEN" : ""}\n${defines}` });
  }

  /** Warp alone, before holes are filled. */
  warpInto(k, shown, chain) {
    const [level] = this.pyramid(shown.size);
    this.warp(CHAINS[chain], this.eyes[k], shown, level);
    return level;
  }

  /** A panel's picture as panel.frag reads it: premultiplied light with mip levels, the bottom row first. source: the top row first. */
  picture(source) {
    const gl = this.gl, texels = [source.width, source.height], count = 1 + Math.floor(Math.log2(Math.max(...texels)));
    const texture = this.texture(gl.RGBA16F, texels, gl.LINEAR, count), turned = [[1 / texels[0], 0, 0], [0, -1 / texels[1], 1], [0, 0, 1]];
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_NEAREST);
    let [size, before] = [texels, this.texture(gl.SRGB8_ALPHA8, texels)];
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, ...size, gl.RGBA, gl.UNSIGNED_BYTE, source);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ZERO, gl.ONE, gl.ZERO);
    for (let level = 0; level < count; level += 1) {
      const next = texels.map((side) => Math.max(side >> level, 1)), made = this.scratch(next, gl.RGBA16F);
      const values = { panel: before, panel_texels: size, level_texels: next, panel_from_shown: turned, corner: [0, 0] };
      if (!level) gl.enable(gl.BLEND);
      this.use(this.program("panel.frag", { defines: level ? "#define LEVEL" : "" }), values);
      this.draw(made.target, next);
      gl.disable(gl.BLEND);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.copyTexSubImage2D(gl.TEXTURE_2D, level, 0, 0, 0, 0, ...next);
      gl.deleteFramebuffer(made.target);
      gl.deleteTexture(before);
      [size, before] = [next, made.texture];
    }
    gl.deleteTexture(before);
    return { texture, texels };
  }

  /** Blend a panel over an eye's picture, at a corner of a framebuffer. panel: {pose, isOnHead, metres, texture, texels}. */
  blend(panel, shown, target, corner, defines = "", more = {}) {
    const map = panelFromShown(panel, shown), box = map && boxOf(map, shown.size);
    if (!box) return;
    this.use(this.program("panel.frag", { defines }), { panel: panel.texture, panel_texels: panel.texels, panel_from_shown: map, corner, ...more });
    this.draw(target, box.extent, 3, box.low.map((low, k) => corner[k] + low));
  }

  /** Lay panels over a warped picture, the farthest first. A hole's fill comes under them all the same: "over" is associative. */
  lay(panels, shown, { over, depth }) {
    const gl = this.gl, away = (panel) => Math.hypot(...placeTo(panel, shown).position), hidden = { shown_inverse_depth: depth, nearer: NEARER };
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    for (const panel of [...panels].sort((a, b) => away(b) - away(a))) this.blend(panel, shown, over, [0, 0], ...(panel.isOccluded ? ["#define OCCLUDED", hidden] : []));
    gl.disable(gl.BLEND);
  }

  /** Show an eye in a framebuffer (null: the canvas), at a corner of it. shown: {pose, head_from_eye, fov, size, mask}. */
  show(k, shown, chain, target = null, corner = [0, 0], fill = "pyramid", panels = []) {
    const levels = this.pyramid(shown.size), [finest] = levels, last = levels.length - 1;
    this.warpInto(k, shown, chain);
    if (fill === "none") {
      this.lay(panels, shown, finest);
      this.use(this.over(shown, "push.frag", "#define ALONE"), { colours: finest.colour, is_last: true, corner, ...seen(shown) });
      this.draw(target, shown.size, 3, corner, shown.mask);
      return;
    }
    for (let n = 1; n <= last; n += 1) {
      this.use(this.program("pull.frag"), { colours: levels[n - 1].colour, depths: levels[n - 1].depth });
      this.draw(levels[n].into, levels[n].size);
    }
    for (let n = last - 1; n > 0; n -= 1) {
      const above = levels[n + 1];
      this.use(this.program("push.frag"), { colours: levels[n].colour, above: n === last - 1 ? above.colour : above.whole, is_last: false, corner: [0, 0] });
      this.draw(levels[n].over, levels[n].size);
    }
    const above = levels[Math.min(1, last)];
    this.lay(panels, shown, finest);
    this.use(this.over(shown, "push.frag"), { colours: finest.colour, above: last > 1 ? above.whole : above.colour, is_last: true, corner, ...seen(shown) });
    this.draw(target, shown.size, 3, corner, shown.mask);
  }

  /** What a warp finds, with panels over it: (h, w, 4) floats of premultiplied light and coverage, the bottom row first. */
  read(k, shown, chain, panels = []) {
    const gl = this.gl, found = new Float32Array(4 * shown.size[0] * shown.size[1]), level = this.warpInto(k, shown, chain);
    this.lay(panels, shown, level);
    gl.bindFramebuffer(gl.FRAMEBUFFER, level.into);
    gl.readPixels(0, 0, ...shown.size, gl.RGBA, gl.FLOAT, found);
    return found;
  }

  /** The device's own name, where the browser tells it. */
  renderer() {
    const more = this.gl.getExtension("WEBGL_debug_renderer_info");
    return String(this.gl.getParameter(more ? more.UNMASKED_RENDERER_WEBGL : this.gl.RENDERER));
  }

  /** Write a line for people over an eye's picture, 2 m ahead of the head. */
  tell(text, eye, target, corner) {
    const gl = this.gl, [width, height] = TOLD.size;
    if (this.told?.text !== text) {
      const paper = (this.told?.paper ?? new OffscreenCanvas(width, height)), pen = paper.getContext("2d");
      Object.assign(pen, { fillStyle: "#000c", font: "30px system-ui, sans-serif", textAlign: "center" });
      pen.clearRect(0, 0, width, height);
      pen.fillRect(0, 0, width, height);
      pen.fillStyle = "#fff";
      const rows = text.match(new RegExp(`.{1,${TOLD.letters}}(?: |$)`, "g")) ?? [text];
      rows.forEach((row, k) => pen.fillText(row.trim(), width / 2, height / 2 + 10 + 36 * (k - (rows.length - 1) / 2), width));
      gl.deleteTexture(this.told?.texture ?? null);
      this.told = { text, paper, ...TOLD, ...this.picture(paper) };
    }
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    this.blend(this.told, eye, target, corner, "#define ENCODED");
    gl.disable(gl.BLEND);
  }

  /** Wait until the device has drawn; the only way that every browser has. */
  finish() {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, null);
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }
}
