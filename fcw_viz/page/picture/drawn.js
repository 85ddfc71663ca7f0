// Runs in each tab, once the page's channel is open: tells it "drawn:<ms>" when a new picture has been drawn, with the
// browser's clock then, which is not late when the word is. viser gives up a picture that is still being decoded when
// the next one comes: sent faster than the browser can show them, none would ever be seen.
const POLL_MS = 1;
const viewer = window.__viserMutable;
viewer.lastDrawn = null;
viewer.scene.onAfterRender = (renderer) => {
  let texture = null;
  viewer.nodeRefFromName?.["/picture"]?.traverse((node) => {
    if (node.isMesh && node.material.map) texture = texture ?? node.material.map;
  });
  // The picture with which a page begins is one pixel.
  if (texture === null || texture === viewer.lastDrawn || !(texture.image?.width > 1)) return;
  viewer.lastDrawn = texture;
  // It has only been asked for by now: without a graphics card drawing takes a while.
  const gl = renderer.getContext();
  const done = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  const look = () => {
    if (!gl.isContextLost() && gl.getSyncParameter(done, gl.SYNC_STATUS) !== gl.SIGNALED) {
      setTimeout(look, POLL_MS);
      return;
    }
    gl.deleteSync(done);
    const now = performance.now();
    window.dispatchEvent(new CustomEvent("fcw-drawn", { detail: now }));
    window.fcwChannel.tell(`drawn:${now}`);
  };
  gl.flush();
  setTimeout(look, POLL_MS);
};
