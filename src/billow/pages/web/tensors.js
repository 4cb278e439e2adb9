// What a page holds: base64 of gzip of a safetensors file, arrays by name and a record.

const KINDS = {
  F32: Float32Array, F64: Float64Array, U8: Uint8Array, U16: Uint16Array, U32: Uint32Array,
};

export function fromBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const letters = atob(text), bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

// Numbers of half precision, for browsers without Float16Array.
export function fromHalves(words) {
  const values = new Float32Array(words.length);
  for (let i = 0; i < words.length; i++) {
    const sign = words[i] & 0x8000 ? -1 : 1, exponent = (words[i] >> 10) & 31, rest = words[i] & 1023;
    if (exponent === 0) values[i] = sign * rest * 2 ** -24;
    else if (exponent === 31) values[i] = rest ? NaN : sign * Infinity;
    else values[i] = sign * (1 + rest / 1024) * 2 ** (exponent - 15);
  }
  return values;
}

export async function unpacked(text) {
  const packed = new Blob([fromBase64(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  const bytes = new Uint8Array(await new Response(packed).arrayBuffer());
  const size = Number(new DataView(bytes.buffer).getBigUint64(0, true));
  const head = JSON.parse(new TextDecoder().decode(bytes.subarray(8, 8 + size)));
  const record = JSON.parse(head.__metadata__.billow), tensors = {};
  for (const [name, told] of Object.entries(head)) {
    if (name === "__metadata__") continue;
    const [begin, end] = told.data_offsets, raw = bytes.slice(8 + size + begin, 8 + size + end).buffer;
    if (told.dtype !== "F16") tensors[name] = new KINDS[told.dtype](raw);
    else if (globalThis.Float16Array) tensors[name] = Float32Array.from(new Float16Array(raw));
    else tensors[name] = fromHalves(new Uint16Array(raw));
    tensors[name].shape = told.shape;
  }
  return { tensors, record };
}
