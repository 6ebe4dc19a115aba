// Pictures of videos: colour as the browser decodes it, depth by its codes.

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
