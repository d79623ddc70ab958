// Buttons, lists and boxes around the picture.

function $(id) {
  return document.getElementById(id);
}

function listenToControls(viewer) {
  $("nearer").addEventListener("click", () => viewer.zoom(STEP));
  $("farther").addEventListener("click", () => viewer.zoom(1 / STEP));
  $("fit").addEventListener("click", () => viewer.fit());
  for (const box of document.querySelectorAll("input[data-part]")) {
    box.addEventListener("change", () => viewer.toggle(box.dataset.part, box.checked));
  }
  for (const button of document.querySelectorAll("button.place")) {
    button.addEventListener("click", () => viewer.showPlace(Number(button.dataset.x), Number(button.dataset.y)));
  }
  for (const button of document.querySelectorAll("button.worst")) {
    button.addEventListener("click", () => viewer.showWorst(Number(button.dataset.rank)));
  }
  const labels = [...document.querySelectorAll("button.label")];
  for (const button of labels) {
    button.addEventListener("click", () => {
      viewer.single(Number(button.dataset.label));
      for (const other of labels) {
        other.setAttribute("aria-pressed", String(Number(other.dataset.label) === viewer.picture.label));
      }
    });
  }
  const recolour = () => {
    viewer.recolour($("colouring").value);
    for (const legend of document.querySelectorAll("[data-legend]")) {
      legend.hidden = legend.dataset.legend !== $("colouring").value;
    }
  };
  $("colouring").addEventListener("change", recolour);
  recolour();
}

// The colours of a colouring, from the least to the greatest value.
function drawScale(colouring) {
  const canvas = document.querySelector(`[data-legend="${colouring}"] canvas`);
  if (!canvas) return;
  const table = tables[colouring];
  canvas.width = table.length;
  canvas.height = 1;
  const context = canvas.getContext("2d");
  const image = context.createImageData(table.length, 1);
  new Uint32Array(image.data.buffer).set(table);
  context.putImageData(image, 0, 0);
}
