// Runs after picture_view.js: where drawing is slow (no graphics card, mostly) the picture follows the mouse all
// the same. Left alone, viser draws on and on after every change, the browser queues these frames, and what is new
// is drawn behind several old ones. Here a frame is drawn when the one before is done, with all that has come until
// then. While something is dragged it has half the resolution, and is drawn only when there is something new; the
// panels, which the browser draws with the same processor, follow at their own pace. Pictures that follow one
// another, too, have half the resolution until one stays.
if (viewer.framesArePaced) return; // the connection was lost and is there again
viewer.framesArePaced = true;

const SLOW_MS = 40; // a frame; below, everything is left as it is
const REMEMBERED = 9; // frames whose median is asked
const TAIL_MS = 100; // what a change brings later (a picture must be decoded) is drawn once more after that
const PANELS_MS = 300; // from a change until the panels show it
const POLL_MS = 1;
const COARSE = 0.5; // of the screen's resolution
const STAYS_MS = 500; // after a picture, until it is drawn sharply
const DECODED_MS = 150; // a new picture is decoded by then, or the old one is drawn once more
const settings = window.__viserTestpoints.devSettings;
const usual_ms = []; // what the last frames took at full resolution
let dragging = false, passing = false, stays = null, sharpDpr = null;
let hasArrived = false, heldBack = [], release = null;
let drawNow = null, gl = null, inWork = null, soon = null;
let pictureSentAt = -Infinity, pictureBefore = null;
let wanted = false, isNew = false, askedAt = 0, drawnAt = 0, drawnSize = "";

const isSlow = () => [...usual_ms].sort((a, b) => a - b)[usual_ms.length >> 1] > SLOW_MS;
const size = () => `${canvas.width} ${canvas.height}`;

const draw = () => {
  clearTimeout(soon);
  const isUsual = sharpDpr === null && inWork === null;
  soon = null;
  wanted = isNew = false;
  drawNow(viewer.scene, viewer.camera);
  const start = (drawnAt = performance.now());
  drawnSize = size();
  const mine = (inWork = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0));
  gl.flush();
  const look = () => {
    if (!gl.isContextLost() && gl.getSyncParameter(mine, gl.SYNC_STATUS) !== gl.SIGNALED) {
      setTimeout(look, POLL_MS);
      return;
    }
    gl.deleteSync(mine);
    if (isUsual) usual_ms.push(performance.now() - start);
    if (usual_ms.length > REMEMBERED) usual_ms.shift();
    if (mine === inWork) {
      inWork = null;
      drawSoon();
    }
  };
  setTimeout(look, POLL_MS);
};

const picture = () => {
  let found = null;
  viewer.nodeRefFromName["/picture"]?.traverse((node) => {
    if (node.isMesh && node.material.map) found = found ?? node.material.map;
  });
  return found;
};
const isDecoding = () => performance.now() < pictureSentAt + DECODED_MS && picture() === pictureBefore;

// Not within viser's own frame: what its messages changed, React puts into the scene only after it.
const drawSoon = () => {
  if (!wanted || inWork !== null || soon !== null) return;
  if (isDecoding()) {
    // A frame with the old picture would only keep the one with the new picture waiting.
    soon = setTimeout(() => {
      soon = null;
      drawSoon();
    }, POLL_MS);
    return;
  }
  const tailAt = askedAt + TAIL_MS;
  const isTail = drawnAt < tailAt && performance.now() >= tailAt;
  if (!dragging || isNew || isTail) soon = setTimeout(draw, 0);
};

viewer.scene.onBeforeRender = (renderer) => {
  viewer.scene.onBeforeRender = () => {};
  gl = renderer.getContext();
  drawNow = renderer.render.bind(renderer);
  renderer.render = (scene, seenBy) => {
    const isFrame = scene === viewer.scene && renderer.getRenderTarget() === null;
    if (!isFrame || viewer.getRenderRequestState !== "ready") {
      drawNow(scene, seenBy);
    } else if (!isSlow() || drawnSize !== size()) {
      draw(); // a canvas of another size is empty until then
    } else {
      wanted = true;
      isNew ||= hasArrived; // viser reads its messages at the beginning of its frame
      hasArrived = false;
      drawSoon();
    }
  };
};

const request = viewer.requestRender;
viewer.requestRender = () => {
  // Of a mouse that drags there is nothing to see before the server's answer.
  if (dragging && isSlow() && window.event?.type === "pointermove") return;
  askedAt = performance.now();
  request();
};

// The browser tells of the mouse's movements once a frame, unless asked for them raw.
window.addEventListener("pointerrawupdate", (event) => {
  if (dragging && isSlow()) window.dispatchEvent(new PointerEvent("pointermove", event));
});

const queue = viewer.messageQueue;
const enqueue = queue.push.bind(queue);
queue.push = (message) => {
  const isForPanels = message.type.startsWith("Gui") && !message.type.startsWith("Gui3D");
  // The point and the glass come before the rows are solved: they are drawn with these, or in the tail.
  const isHeld = dragging && /^\/(handles|magnifier)/.test(message.name ?? "");
  if (!isForPanels && !isHeld) hasArrived = true;
  if (message.name === "/picture" && message.updates?._data) {
    pictureSentAt = performance.now();
    pictureBefore = picture();
    // One alone is sharp at once: changing the resolution takes frames, too.
    passing ||= stays !== null;
    clearTimeout(stays);
    stays = setTimeout(() => {
      stays = null;
      passing = false;
      setResolution();
    }, STAYS_MS);
    setResolution();
  }
  if (!isForPanels || !(heldBack.length || (dragging && isSlow()))) return enqueue(message);
  release ??= setTimeout(showPanels, PANELS_MS);
  return heldBack.push(message);
};
const showPanels = () => {
  clearTimeout(release);
  release = null;
  heldBack.splice(0).forEach(enqueue);
  request();
};

const setResolution = () => {
  const isCoarse = dragging || passing;
  if (isCoarse && sharpDpr === null && isSlow()) {
    sharpDpr = settings.get().fixedDpr ?? window.devicePixelRatio;
    settings.set({ fixedDpr: sharpDpr * COARSE });
  } else if (!isCoarse && sharpDpr !== null) {
    settings.set({ fixedDpr: sharpDpr });
    sharpDpr = null;
  }
};

viewer.dragged = (phase) => {
  dragging = phase !== "end";
  if (!dragging) showPanels();
  setResolution();
};
