// Runs in each tab, once the page's channel is open: tells it "drawn:" when a new picture is on the screen. viser
// gives up a picture that is still being decoded when the next one comes: sent faster than the browser can show
// them, none would ever be seen.
const viewer = window.__viserMutable;
viewer.lastDrawn = null;
viewer.scene.onAfterRender = () => {
  let texture = null;
  viewer.nodeRefFromName?.["/picture"]?.traverse((node) => {
    if (node.isMesh && node.material.map) texture = texture ?? node.material.map;
  });
  if (texture === null || texture === viewer.lastDrawn) return;
  viewer.lastDrawn = texture;
  window.fcwChannel.tell("drawn:");
};
