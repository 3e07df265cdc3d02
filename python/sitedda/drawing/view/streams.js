// Streams of small whole numbers become values of all frames.

/** The streams that stand in a page, by the name of their view. */
export class PageStreams {
  constructor(view) {
    this.view = view;
  }

  /** Deflated bytes; they can be read once. */
  deflated(name) {
    const node = document.getElementById(`${this.view}-${name}`);
    const text = node.textContent.trim();
    node.remove();  // megabytes of text are not needed twice
    return Uint8Array.fromBase64 ? Uint8Array.fromBase64(text) : fromBase64(text);
  }
}

export async function inflate(streams, name) {
  const bytes = streams.deflated(name);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function fromBase64(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

export async function floats(streams, name) {
  return new Float32Array((await inflate(streams, name)).buffer);
}

export async function integers(streams, name) {
  return new Int32Array((await inflate(streams, name)).buffer);
}

/** Sums of zigzag differences: whole numbers of all frames, frame after frame. */
export function summed(bytes, width, wide, frames, things) {
  const values = wide ? new Int32Array(frames * things) : new Int16Array(frames * things);
  const sums = new Int32Array(things);
  for (let f = 0; f < frames; f++) {
    const at = f * things * width, to = f * things;
    for (let i = 0; i < things; i++) {
      let code = bytes[at + i];
      if (width > 1) code |= bytes[at + things + i] << 8;
      if (width > 2) code |= bytes[at + 2 * things + i] << 16;
      if (width > 3) code |= bytes[at + 3 * things + i] << 24;
      sums[i] += (code >>> 1) ^ -(code & 1);
      values[to + i] = sums[i];
    }
  }
  return values;
}

export async function channel(streams, described, frames, things) {
  const bytes = await inflate(streams, described.name);
  const values = summed(bytes, described.bytes, described.wide, frames, things);
  return {values, quantum: described.quantum, root: described.root};
}

/** Value i of a channel; of some the roots are stored. */
export function value(channel, i) {
  const x = channel.values[i] * channel.quantum;
  return channel.root ? Math.sign(x) * x * x : x;
}
