"""Texture reads and bytes for each pixel of a refresh of the page, in a table.

Counted by twins of its shaders, at the size of the page's own window, in a headless Chromium.
"""

from __future__ import annotations

import json
import re

from apparatus import markdown, options
from web.browser import Browser, page

from hmdwarp.web.door import shaders

COUNTS = """
int reads = 0;
ivec2 noted(ivec2 at) { reads += 1; return at; }
vec2 noted(vec2 at) { reads += 1; return at; }
#define texelFetch(picture, at, level) texelFetch(picture, noted(at), level)
#define textureLod(picture, at, level) textureLod(picture, noted(at), level)
"""
_OUT = re.compile(r"^(?:layout\(location = 0\) )?out vec4 (\w+);", re.MULTILINE)
_PREFACE_ENDS = "precision highp usampler2D;\n"


def twin(name: str, text: str) -> str:
    """Return a shader that counts its reads: a fragment's colour is their number.

    A vertex becomes a point of its own, whose colour their number is.
    """
    body = text.replace(_PREFACE_ENDS, _PREFACE_ENDS + COUNTS).replace("void main() {", "void itself() {")
    if not name.endswith(".vert"):
        (out,) = _OUT.findall(text)
        return f"{body}\nvoid main() {{ itself(); {out} = vec4(float(reads)); }}\n"
    point = "vec4(vec2(gl_VertexID % SIDE, gl_VertexID / SIDE) * (2.0 / float(SIDE)) + 1.0 / float(SIDE) - 1.0, 0, 1)"
    ends = f"itself(); counted = float(reads); gl_Position = {point}; gl_PointSize = 1.0;"
    return f"{body}\nout float counted;\nvoid main() {{ {ends} }}\n"


SIDE = 160  # of the picture that has a pixel for each vertex of the mesh
POINTS = """#version 300 es
precision highp float;
in float counted;
out vec4 found;
void main() { found = vec4(counted); }
"""
# Draws each pass of a refresh twice: once into a picture of its reads, added up, and as it is.
COUNTED = r"""
async (twins, side, size) => {
  const { CHAINS, FILLS } = await import("./chain.js"), gl = chain.gl;
  const texels = new Map(), targets = new Map(), names = new Map(), found = {}, plain = {};
  const bytes = { [gl.R8UI]: 1, [gl.R32F]: 4, [gl.RGBA8]: 4, [gl.SRGB8_ALPHA8]: 4, [gl.RGBA16F]: 8 };
  for (const name of ["texture", "target", "program", "use", "draw"]) plain[name] = chain[name].bind(chain);
  const { shaders } = chain, names_in = (text, name) => new RegExp(`\\b${name}\\b`).test(text);
  let now = null, tally = null;
  chain.texture = (format, [width, height], filter) => {
    const made = plain.texture(format, [width, height], filter);
    texels.set(made, { bytes: bytes[format], count: width * height });
    return made;
  };
  chain.target = (textures, depth) => {
    const made = plain.target(textures, depth);
    const own = depth ? 8 : 0; // a depth buffer's, read and written
    targets.set(made, textures.reduce((sum, one) => sum + texels.get(one).bytes, own));
    return made;
  };
  chain.program = (fragment, how = {}) => {
    const real = plain.program(fragment, how);
    names.set(real, { fragment, vertex: how.vertex ?? "whole.vert", defines: how.defines ?? "" });
    return real;
  };
  chain.use = (real, values) => {
    now = { ...names.get(real), values };
    plain.use(real, values);
  };
  const sum = (sides, drawn) => {
    const picture = plain.texture(gl.RGBA16F, sides), into = plain.target([picture]);
    const pixels = new Float32Array(4 * sides[0] * sides[1]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, into);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    drawn(into);
    gl.disable(gl.BLEND);
    gl.bindFramebuffer(gl.FRAMEBUFFER, into);
    gl.readPixels(0, 0, ...sides, gl.RGBA, gl.FLOAT, pixels);
    let total = 0;
    for (let k = 0; k < pixels.length; k += 4) total += pixels[k];
    gl.deleteFramebuffer(into);
    gl.deleteTexture(picture);
    return total;
  };
  chain.draw = (target, sides, count = 3, ...rest) => {
    const { fragment, vertex, defines, values } = now;
    const usesTwins = (more) => (chain.shaders = { ...shaders, ...more });
    usesTwins({ [fragment]: twins[fragment] });
    const reads = sum(sides, (into) => {
      plain.use(plain.program(fragment, { vertex, defines: `${defines}\n#define TWIN` }), values);
      plain.draw(into, sides, count);
    });
    let ofVertices = 0;
    if (count > 3) {
      usesTwins({ [vertex]: twins[vertex], points: twins.points });
      ofVertices = sum([side, side], (into) => {
        plain.use(plain.program("points", { vertex, defines: `#define SIDE ${side}` }), values);
        gl.viewport(0, 0, side, side);
        gl.bindVertexArray(chain.vertices);
        gl.drawArrays(gl.POINTS, 0, count);
      });
    }
    chain.shaders = shaders;
    let moved = sides[0] * sides[1] * (targets.get(target) ?? 4);
    for (const [name, value] of Object.entries(values)) {
      const isOfVertices = names_in(shaders[vertex], name);
      if (!texels.has(value) || !(isOfVertices || names_in(shaders[fragment], name))) continue;
      const { bytes, count } = texels.get(value); // each texel once
      moved += bytes * (isOfVertices ? Math.min(count, ofVertices) : count);
    }
    tally.reads += reads + ofVertices;
    tally.bytes += moved;
    plain.use(plain.program(fragment, { vertex, defines }), values);
    plain.draw(target, sides, count, ...rest);
  };
  const late = size.map((each) => 1.25 * each), count = late[0] * late[1];
  const pose = { position: [0, 0, 0], orientation: [0, 0, 0, 1] };
  const isNear = (x, y) => (Math.floor(x / 80) + Math.floor(y / 50)) % 2;
  const depth = new Float32Array(count).map((_, k) => 0.25 + 0.5 * isNear(k % late[0], k / late[0]));
  const colour = new Uint8Array(4 * count).map((_, k) => (k % 4 === 3 ? 255 : k % 251));
  const counted = (name, act) => {
    tally = { reads: 0, bytes: 0 };
    act();
    found[name] = tally;
  };
  const fov = [-0.8, 0.8, -0.6, 0.6], wide = fov.map((angle) => Math.atan(1.25 * Math.tan(angle)));
  const coded = { codes: new Uint8Array(count).fill(90), kinds: new Uint8Array(count), step: 0.01, bend: 0 };
  const view = { pose, fov: wide }, takeIn = (depth) => chain.takeIn(0, { size: late, colour, depth, view });
  counted("taking in a coded frame", () => takeIn(coded));
  counted("taking in a raw frame", () => takeIn({ numbers: depth }));
  const head = { position: [0.03, 0.01, -0.02], orientation: [0, 0.02, 0, Math.sqrt(1 - 0.0004)] };
  const shown = { pose: head, fov, size };
  const scratch = chain.scratch(size);
  for (const name of Object.keys(CHAINS)) {
    counted(`\`${name}\`, warp alone`, () => chain.warpInto(0, shown, name));
    for (const fill of FILLS) {
      counted(`\`${name}\`, fill ${fill}`, () => chain.show(0, shown, name, scratch.target, [0, 0], fill));
    }
  }
  return found;
}
"""
SIZE = (640, 400)


def table() -> str:
    """Return it as Markdown."""
    texts = shaders()
    twins = {name: twin(name, text) for name, text in texts.items()} | {"points": POINTS}
    with Browser() as browser, page(texts) as address:
        browser.open(address)
        browser.until("globalThis.chain")
        found = browser.does(f"({COUNTED})({json.dumps(twins)}, {SIDE}, {json.dumps(SIZE)})")
    count = SIZE[0] * SIZE[1]
    rows = [(name, f"{tally['reads'] / count:.1f}", f"{tally['bytes'] / count:.0f}") for name, tally in found.items()]
    return markdown(("passes", "reads a pixel", "bytes a pixel"), rows)


if __name__ == "__main__":
    options(__doc__)
    print(table())
