// Runs after picture_view.js: somewhere else in the scene the camera orbits about a point, in viser's axes, within
// ranges of distance and depth. The server is told nothing of that: for it the camera stays before the picture, to
// which it comes back.
const ROTATE = 1, TOUCH_ROTATE = 64;
const ofThePicture = new Set(["ViewerCameraMessage", "ScenePointerMessage", "SceneNodeClickMessage", "SceneNodeDragMessage"]);

const sendOfPicture = viewer.sendMessage;
viewer.sendMessage = (message) => {
  if (!viewer.away || !ofThePicture.has(message.type)) sendOfPicture(message);
};

// viser lays out new words without asking for the frame in which they are seen.
const LATER_MS = [100, 400, 1200];
const place = (position, target) => {
  controls.setPosition(position.x, position.y, position.z, false);
  controls.setTarget(target.x, target.y, target.z, false);
};
const inThree = ([x, y, z]) => ({ x: -y, y: z, z: -x });
viewer.leavePicture = (position, target, distances, depths, lowestRad) => {
  const before = viewer.away?.before ?? {
    position: controls.getPosition(camera.position.clone()),
    target: controls.getTarget(camera.position.clone()),
    distances: [controls.minDistance, viewer.configuredMaxOrbitDistance],
  };
  viewer.away = { before, depths };
  controls.minPolarAngle = 0;
  controls.maxPolarAngle = lowestRad;
  controls.minAzimuthAngle = -Infinity;
  controls.maxAzimuthAngle = Infinity;
  controls.mouseButtons.left = ROTATE;
  controls.touches.one = TOUCH_ROTATE;
  controls.dollyToCursor = false;
  [controls.minDistance, viewer.configuredMaxOrbitDistance] = distances;
  bound();
  place(inThree(position), inThree(target));
  clip();
  for (const ms of LATER_MS) setTimeout(() => viewer.requestRender(), ms);
};
viewer.backToPicture = () => {
  if (!viewer.away) return;
  const { before } = viewer.away;
  viewer.away = null;
  controls.maxPolarAngle = Math.PI; // not bent to what held there
  [controls.minDistance, viewer.configuredMaxOrbitDistance] = before.distances;
  place(before.position, before.target);
  hold();
  bound();
  clip();
};
