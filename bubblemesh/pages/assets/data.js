// The mesh, as the page embeds it: blocks of compressed bytes, those of one rank after the other.

const head = JSON.parse(document.getElementById("head").textContent);

async function unsignedIntegers(name) {
  const block = document.getElementById(name);
  const letters = atob(block.textContent);
  const packed = new Uint8Array(letters.length);
  for (let k = 0; k < packed.length; k++) packed[k] = letters.charCodeAt(k);
  block.remove(); // the letters are not needed any more
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const width = Number(block.dataset.width);
  const count = bytes.length / width;
  const values = new Uint32Array(count);
  for (let rank = width - 1; rank >= 0; rank--) {
    for (let k = 0, at = rank * count; k < count; k++, at++) values[k] = (values[k] << 8) | bytes[at];
  }
  return values;
}

// Nodes of the triangles, three after three, from columns of differences whose lowest bit is the sign.
function absolute(columns) {
  const count = columns.length / 3;
  const corners = new Uint32Array(3 * count);
  const signed = (value) => (value & 1 ? -((value + 1) / 2) : value / 2);
  for (let t = 0, first = 0; t < count; t++) {
    first += signed(columns[t]);
    corners[3 * t] = first;
    corners[3 * t + 1] = first + signed(columns[count + t]);
    corners[3 * t + 2] = first + signed(columns[2 * count + t]);
  }
  return corners;
}

function scaled(values, low, high, largest) {
  return Float64Array.from(values, (value) => low + (value / largest) * (high - low));
}

async function readMesh() {
  const [points, columns, diagonals, quality, size, ratio, region, facets] = await Promise.all(
    ["points", "triangles", "diagonals", "quality", "size", "ratio", "region", "facets"].map(unsignedIntegers),
  );
  const inQuadrilateral = new Uint8Array(columns.length); // 1 for sides of triangles that are no edges of cells
  for (const side of diagonals) inQuadrilateral[side] = 1;
  const nodes = points.length / 2;
  // Coordinates are counted from the lower left corner: far from the origin they would lose digits on the screen.
  const along = scaled(points, 0, head.extent, 2 ** 32 - 1);
  return {
    nodes,
    triangles: columns.length / 3,
    x: along.subarray(0, nodes),
    y: along.subarray(nodes),
    corners: absolute(columns),
    inQuadrilateral,
    quality: scaled(quality, 0, 1, 2 ** 16 - 1),
    size: scaled(size, 0, 1, 2 ** 8 - 1), // share of the scale of colours, which may be logarithmic
    ratio: scaled(ratio, 0, head.largestRatio, 2 ** 16 - 1),
    region,
    facets,
    labels: head.labels,
  };
}
