// Runs in each tab, after `halfWidth` and `halfHeight` (of the picture, in scene units): turns viser's orbiting
// camera into one that slides over a picture. It uses what viser shows to its own browser tests
// (`__viserMutable`, `__viserTestpoints`) and camera-controls' documented properties.
const viewer = window.__viserMutable;
const { cameraControl: controls, camera, canvas } = viewer;
const TRUCK = 2, TOUCH_TRUCK = 128; // camera-controls' ACTION, which viser does not export

viewer.away = null; // not so while the camera looks at something else, see picture_away.js
const hold = () => {
  // The view never tilts or rolls, whatever is dragged, touched or pressed.
  controls.minPolarAngle = controls.maxPolarAngle = Math.PI / 2;
  controls.minAzimuthAngle = controls.maxAzimuthAngle = Math.PI / 2; // viser's -y is three's x
  // Dragging slides the picture, the wheel zooms to the mouse.
  controls.mouseButtons.left = TRUCK;
  controls.touches.one = TOUCH_TRUCK;
  controls.dollyToCursor = true;
};
hold();
// camera-controls hears one movement a frame: where frames are slow, the picture would be left behind by the mouse.
Object.defineProperty(controls, "_dragNeedsUpdate", { get: () => true, set: () => {}, configurable: true });
controls.dollySpeed = 2.0; // 1.4 times a notch of the wheel
// The middle of the view stays on the picture, so that it is never lost.
let bounds;
const bound = () => controls.setBoundary(viewer.away ? undefined : bounds);
viewer.setPictureBounds = (halfWidth, halfHeight) => {
  bounds = { min: { x: 0, y: -halfHeight, z: -halfWidth }, max: { x: 0, y: halfHeight, z: halfWidth } };
  bound();
};
viewer.setPictureBounds(halfWidth, halfHeight);

// Layers lie very close to the picture, so that they do not shift against it towards the edges of the view:
// depth must be resolved around the picture at every zoom.
const clip = () => {
  const [near, far] = viewer.away?.depths ?? [controls.distance / 2, controls.distance * 2];
  [camera.near, camera.far] = [near, far];
  camera.updateProjectionMatrix();
};
controls.addEventListener("update", clip);
clip();

// viser moves its camera with W A S D Q E and the arrows. Hotkeys are heard one element further in.
const keys = new Set(["KeyW", "KeyA", "KeyS", "KeyD", "KeyQ", "KeyE", "ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight"]);
document.documentElement.addEventListener("keydown", (event) => {
  if (keys.has(event.code)) event.stopPropagation();
});

// Always as sharp as the screen (viser saves resolution on slow machines), and no orbit mark while sliding.
const sharpen = () => window.__viserTestpoints.devSettings.set({ fixedDpr: window.devicePixelRatio });
window.addEventListener("resize", sharpen);
if (!new URLSearchParams(window.location.search).has("fixedDpr")) sharpen();
window.__viserTestpoints.devSettings.set({ enableOrbitCrosshair: false });

// What a finger touches captures it, and viser takes no click from a pointer that is captured. A finger is let go of
// where it comes alone: of two that zoom or slide, neither taps, however still it is held.
let several = false;
canvas.addEventListener("pointerdown", ({ pointerId, isPrimary }) => {
  several = !isPrimary;
  if (isPrimary && canvas.hasPointerCapture(pointerId)) canvas.releasePointerCapture(pointerId);
}, { capture: true });

// The server is told the view's size in CSS pixels: marks keep their size for the eye, not for the graphics card.
const send = viewer.sendMessage;
viewer.sendMessage = (message) => {
  if (message.type === "ScenePointerMessage" && several) return;
  if (message.type === "SceneNodeDragMessage") viewer.dragged?.(message.phase);
  send(
    message.type === "ViewerCameraMessage"
      ? { ...message, image_width: canvas.clientWidth, image_height: canvas.clientHeight }
      : message,
  );
};
viewer.sendCamera();
// Its place may change without the window: the picture is fitted anew.
if (!viewer.watchesSize) {
  viewer.watchesSize = true;
  new ResizeObserver(() => viewer.sendCamera()).observe(canvas);
}
