// Pictures of videos: colour as the browser decodes it, depth by its codes. And panels, whose pictures are files.

/** Videos: format of docs/feed.md, what WebCodecs calls them (Annex B, as no description is given), crf of one quality. */
export const VIDEOS = {
  av1: { colour: 6, type: "av01.0.13M.08", crf: 33 },
  hevc: { colour: 4, type: "hvc1.1.6.L153.B0", crf: 20 },
  vp9: { colour: 5, type: "vp09.00.51.08", crf: 29 },
  h264: { colour: 3, type: "avc1.640033", crf: 18 },
};
const typeOf = (colour) => Object.values(VIDEOS).find((video) => video.colour === colour).type;
const HEADER_BYTES = 24; // CRC-32, f64 step, f64 nearest, u32 bytes of the map
const MOST_CODE = 255;
const MOST_PANELS = 15, MOST_SIDE = 8192, MOST_UPDATE = 1 << 20; // as frames/layers/panels.py has them; bytes that a frame brings
const PLACE_BYTES = 76, FRAGMENT_BYTES = 14; // docs/feed.md: a panel's row, a fragment's head
const LENGTH_OFF = 1e-3; // of a quaternion, from 1

/** K of docs/feed.md, depth 3: where steps grow so that `steps` fit; 0 where they fit as they are. */
export function bendOf(steps) {
  if (steps <= MOST_CODE) return 0;
  let [low, high] = [1e-3, 1e12];
  for (let k = 0; k < 200; k += 1) {
    const middle = Math.sqrt(low * high);
    if (middle * Math.log1p(steps / middle) < MOST_CODE) low = middle;
    else high = middle;
  }
  return low;
}

/**
 * The videos to ask for, the best first: those of `names`, in their order, that the device decodes in hardware, then H.264.
 * wanted: one that counts if it is decoded at all. takes(config): whether a decoder does. None where it lacks depth's H.264.
 */
export async function decodable(names, wanted, takes = async (config) => (await VideoDecoder.isConfigSupported(config)).supported) {
  const decodes = (name, how) => takes({ codec: VIDEOS[name].type, ...how }).catch(() => false);
  if (!names.includes("h264") || !(await decodes("h264", {}))) return [];
  if (names.includes(wanted) && (await decodes(wanted, {}))) return [wanted];
  const quick = await Promise.all(names.map((name) => decodes(name, { hardwareAcceleration: "prefer-hardware" })));
  return [...names.filter((name, k) => quick[k] && name !== "h264"), "h264"];
}

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

class Video {
  constructor(size, type) {
    this.waiting = [];
    this.decoder = new VideoDecoder({
      output: (frame) => this.waiting.shift()?.(frame),
      error: () => this.waiting.splice(0).forEach((take) => take(null)),
    });
    this.decoder.configure({ codec: type, codedWidth: size[0], codedHeight: size[1], optimizeForLatency: true });
  }

  /** The picture, null where it cannot be decoded. */
  decode(bytes, place, begins) {
    if (this.decoder.state !== "configured") return Promise.resolve(null);
    return new Promise((take) => {
      this.waiting.push(take);
      this.decoder.decode(new EncodedVideoChunk({ type: begins ? "key" : "delta", timestamp: place, data: bytes }));
    });
  }

  close() {
    if (this.decoder.state !== "closed") this.decoder.close();
    this.waiting.splice(0).forEach((take) => take(null)); // a closed decoder gives nothing any more
  }
}

/** The streams of one eye, until a frame begins them anew. */
export class VideoEye {
  constructor({ size, colour }) {
    Object.assign(this, { size, format: colour, next: 0, colour: new Video(size, typeOf(colour)), depth: new Video(size, VIDEOS.h264.type) });
  }

  suits({ size, colour, begins }) {
    const goes = !begins && colour === this.format && `${size}` === `${this.size}` && this.colour.decoder.state === "configured" && this.depth.decoder.state === "configured";
    if (!goes) [this.colour, this.depth].forEach((video) => video.close());
    return goes;
  }

  /** {colour, depth: {codes, kinds, step, bend}}; null where a picture before it is missing. */
  decode(frame, eye) {
    this.last = this.decoded(frame, eye, this.last);
    return this.last;
  }

  async decoded({ place, begins }, { colour, depth }, earlier) {
    if (place !== this.next) return null;
    this.next += 1;
    const view = new DataView(depth.buffer), [step, nearest] = [4, 12].map((at) => view.getFloat64(at, true));
    const packed = view.getUint32(20, true), map = depth.subarray(HEADER_BYTES, HEADER_BYTES + packed);
    const [shown, luma, told] = await Promise.all([
      this.colour.decode(colour, place, begins),
      this.depth.decode(depth.subarray(HEADER_BYTES + packed), place, begins),
      inflated(map),
    ]);
    await earlier;
    const before = this.kinds; // after a key frame the map says what changed
    if (!begins) for (let k = 0; k < told.length; k += 1) told[k] ^= before[k];
    this.kinds = told;
    if (!shown || !luma) {
      for (const one of [shown, luma]) one?.close();
      return null;
    }
    const codes = new Uint8Array(luma.allocationSize({ rect: luma.visibleRect }));
    const [plane] = await luma.copyTo(codes, { rect: luma.visibleRect });
    luma.close();
    return { colour: shown, depth: { codes: this.rows(codes, plane), kinds: told, step, bend: bendOf(nearest / step) } };
  }

  /** The first plane's rows without gaps. */
  rows(codes, { offset, stride }) {
    const [width, height] = this.size;
    if (stride === width) return codes.subarray(offset, offset + width * height);
    const found = new Uint8Array(width * height);
    for (let row = 0; row < height; row += 1) found.set(codes.subarray(offset + row * stride, offset + row * stride + width), row * width);
    return found;
  }
}

/** The panels of a scene as far as they have come, as docs/feed.md has them; one shows the picture before until then. */
export class Panels {
  constructor(chain) {
    Object.assign(this, { chain, began: -1, last: Promise.resolve(), textures: new Map(), old: [], held: [] });
  }

  /** Take in what a frame brings, after those before it. Throws Error for what cannot be. */
  take(frame) {
    return (this.last = this.last.catch(() => {}).then(() => this.taken(frame)));
  }

  async taken(frame) {
    const { bytes: given, isPacked, length } = frame.panels, bytes = isPacked && length <= MOST_UPDATE ? await inflated(given) : given;
    if (length > MOST_UPDATE || bytes.length !== length) throw new Error(`${bytes.length} bytes of panels, said to be ${length}`);
    if (frame.began !== this.began) this.begin(frame.began);
    const view = new DataView(bytes.buffer, bytes.byteOffset, length), showing = Array.from({ length: view.getUint16(8, true) }, (_, k) => view.getUint16(10 + 2 * k, true));
    for (let at = 10 + 2 * showing.length; at < length; ) {
      const [number, index, count] = [0, 4, 8].map((field) => view.getUint32(at + field, true)), from = at + FRAGMENT_BYTES;
      at = from + view.getUint16(at + 12, true);
      if (at > length || index >= count) throw new Error("a fragment that does not fit");
      if (this.whole.has(number)) continue;
      const begun = this.begun.get(number) ?? new Map();
      this.begun.set(number, begun.set(index, bytes.slice(from, at)));
      if (begun.size !== count) continue;
      const parts = Array.from(begun.keys()).sort((a, b) => a - b).map((key) => begun.get(key));
      this.begun.delete(number);
      this.whole.add(number);
      const thing = new Blob(parts, { type: "image/png" });
      if (number) this.textures.set(number, await this.picture(thing));
      else this.places = this.placesIn(new DataView(await thing.arrayBuffer()));
    }
    const fits = !this.places || (showing.length === this.places.length && this.places.every(({ count }, k) => showing[k] < count));
    if (!fits) throw new Error("panels that show other pictures than they have");
    frame.showing = showing;
  }

  /** Another session: its pictures come again, and those of before stay until then. */
  begin(began) {
    this.old.push(...this.textures.values());
    Object.assign(this, { began, textures: new Map(), begun: new Map(), whole: new Set(), places: null });
  }

  async picture(file) {
    const header = new DataView(await file.slice(0, 24).arrayBuffer()), size = [16, 20].map((at) => header.getUint32(at));
    const most = Math.min(MOST_SIDE, this.chain.gl.getParameter(this.chain.gl.MAX_TEXTURE_SIZE));
    if (Math.max(...size) > most) throw new Error(`a picture of ${size.join("x")}: ${most} a side at most`);
    const bitmap = await createImageBitmap(file, { premultiplyAlpha: "none", colorSpaceConversion: "none" });
    const made = this.chain.picture(bitmap);
    bitmap.close();
    return made;
  }

  placesIn(view) {
    if (view.byteLength % PLACE_BYTES || view.byteLength > MOST_PANELS * PLACE_BYTES) throw new Error(`${view.byteLength} bytes of places`);
    let first = 1;
    return Array.from({ length: view.byteLength / PLACE_BYTES }, (_, k) => {
      const at = k * PLACE_BYTES, numbers = Array.from({ length: 9 }, (_, n) => view.getFloat64(at + 8 * n, true));
      const pose = { position: numbers.slice(0, 3), orientation: numbers.slice(3, 7) }, metres = numbers.slice(7);
      const isPlaced = numbers.every(Number.isFinite) && Math.abs(Math.hypot(...pose.orientation) - 1) <= LENGTH_OFF && Math.min(...metres) > 0;
      if (!isPlaced) throw new Error(`a panel at ${numbers.join(" ")}`);
      const [isOnHead, isOccluded] = [72, 73].map((byte) => view.getUint8(at + byte) !== 0), count = view.getUint16(at + 74, true);
      first += count;
      return { pose, metres, isOnHead, isOccluded, count, first: first - count };
    });
  }

  /** Show what a frame shows, as far as it has come: `laid` is what to lay over its picture. */
  show({ showing }) {
    this.places?.forEach((place, k) => {
      const picture = this.textures.get(place.first + showing?.[k]);
      if (picture) this.held[k] = { ...place, ...picture };
    });
    this.held.length = Math.min(this.held.length, this.places?.length ?? MOST_PANELS);
    this.old = this.old.filter(({ texture }) => this.held.some((panel) => panel?.texture === texture) || this.chain.gl.deleteTexture(texture));
  }

  get laid() {
    return this.held.filter(Boolean);
  }
}
