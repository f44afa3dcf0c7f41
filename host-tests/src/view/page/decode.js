// From the text in the page to columns of numbers.

/** What is packed in the page, as bytes. */
async function unpack(text) {
  const compressed = Uint8Array.from(atob(text.trim()), c => c.charCodeAt(0));
  const stream = new Blob([compressed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Reads numbers of seven bits a byte. */
class Numbers {
  constructor(bytes) { this.bytes = bytes; this.at = 0; }

  get done() { return this.at >= this.bytes.length; }

  /** One that is not negative: up to 2^53. */
  count() {
    const bytes = this.bytes;
    let byte = bytes[this.at++], x = byte & 127;
    if (!(byte & 128)) return x;
    for (let unit = 128; byte & 128 && this.at < bytes.length; unit *= 128) {
      byte = bytes[this.at++];
      x += (byte & 127) * unit;
    }
    return x;
  }

  /** One of either sign. */
  number() {
    const x = this.count();
    return x % 2 ? -(x + 1) / 2 : x / 2;
  }
}

/** The columns by name. */
function columnsOf(head, bytes) {
  const columns = {};
  let at = 0;
  for (const [name, length] of head.columns) {
    columns[name] = new Numbers(bytes.subarray(at, at + length));
    at += length;
  }
  return columns;
}
