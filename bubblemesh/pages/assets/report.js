// Puts the parts together once the mesh is read; where that fails, the still picture stays.

const root = document.documentElement;
root.classList.add("scripted");
readMesh()
  .then((mesh) => {
    const viewer = new Viewer(mesh);
    new Pointers(viewer);
    listenToKeys(viewer);
    listenToControls(viewer);
    root.dataset.ready = "true";
  })
  .catch((error) => {
    root.classList.remove("scripted");
    $("failure").hidden = false;
    console.error(error);
  });

// A printed page shows what is folded on the screen.
let unfolded = [];
addEventListener("beforeprint", () => {
  unfolded = [...document.querySelectorAll("details:not([open])")];
  for (const details of unfolded) details.open = true;
});
addEventListener("afterprint", () => {
  for (const details of unfolded) details.open = false;
});
