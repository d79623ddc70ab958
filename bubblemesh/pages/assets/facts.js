// What there is to say of a triangle.

function facts(mesh, t) {
  const rows = [
    ["triangle", `${t + 1}`],
    ["quality q", mesh.quality[t].toFixed(4)],
    ["edges l/d", mesh.ratio[t].toFixed(3)],
  ];
  if (head.regions.length > 1) rows.push(["region", head.regions[mesh.region[t]].name]);
  for (const node of mesh.corners.subarray(3 * t, 3 * t + 3)) {
    const place = [head.origin[0] + mesh.x[node], head.origin[1] + mesh.y[node]].map(coordinate);
    rows.push([`node ${node + 1}`, `(${place.join(", ")})`]);
  }
  const list = document.createElement("dl");
  list.className = "facts";
  for (const [term, text] of rows) {
    const [dt, dd] = ["dt", "dd"].map((name) => document.createElement(name));
    dt.textContent = term;
    dd.textContent = text;
    list.append(dt, dd);
  }
  return list;
}

function number(value) {
  return value.toLocaleString("en");
}

// As many digits as tell places of the mesh apart.
function coordinate(value) {
  const finest = head.extent * 1e-7;
  return String(Number((Math.round(value / finest) * finest).toPrecision(12)));
}
