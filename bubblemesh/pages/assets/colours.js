// Colours of the triangles as 32-bit numbers, in the order of bytes that pictures have.

const LITTLE = new Uint8Array(new Uint32Array([1]).buffer)[0] === 1;

function packedColour(text) {
  const [r, g, b] = [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16));
  return (LITTLE ? (255 << 24) | (b << 16) | (g << 8) | r : (r << 24) | (g << 16) | (b << 8) | 255) >>> 0;
}

const tables = Object.fromEntries(
  Object.entries(head.tables).map(([name, letters]) => [
    name,
    Uint32Array.from(letters.match(/.{6}/g), (digits) => packedColour(`#${digits}`)),
  ]),
);

function styleColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// One colour for each triangle.
function triangleColours(mesh, colouring) {
  const colours = new Uint32Array(mesh.triangles);
  if (colouring === "none") return colours.fill(packedColour(styleColour("--bare")));
  const table = tables[colouring];
  if (colouring === "region") {
    // Colours come again, but for the first, which is mostly that of what is around all others.
    const colourOf = (region) => (region === 0 ? 0 : 1 + ((region - 1) % (table.length - 1)));
    for (let t = 0; t < mesh.triangles; t++) colours[t] = table[colourOf(mesh.region[t])];
    return colours;
  }
  const [low, high] = head.limits[colouring];
  const values = mesh[colouring];
  const last = table.length - 1;
  for (let t = 0; t < mesh.triangles; t++) {
    const share = (values[t] - low) / (high - low);
    colours[t] = table[Math.round(Math.min(Math.max(share, 0), 1) * last)];
  }
  return colours;
}
