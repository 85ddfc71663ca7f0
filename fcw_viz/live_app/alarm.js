// Runs in each tab of the live page: the warning's sounds. Browsers let a page sound only after somebody has clicked
// or pressed a key in it.
const QUIET_MS = 1500; // of a picture that was captured longer ago nothing is heard any more
// Each level: [frequency in Hz, start in s, length in s] of its tones, and after how many seconds they come again.
// Caution is a soft double chime that comes seldom, warning a fast run of high tones (ISO 15006: urgency by rate).
const SOUNDS = {
  caution: { tones: [[660, 0, 0.16], [880, 0.2, 0.22]], every_s: 2.0, gain: 0.18, shape: "sine" },
  warning: {
    tones: [0, 0.13, 0.26, 0.39].map((start) => [1400, start, 0.09]), every_s: 0.6, gain: 0.3, shape: "square" },
};
// The camera is gone for good: tones that fall, once.
const LOST = { tones: [0, 0.9, 1.8].flatMap((start) => [[620, start, 0.25], [310, start + 0.3, 0.4]]), gain: 0.3,
  shape: "square" };

const alarm = (window.fcwAlarm ??= { level: "none", muted: false, context: null, captured: null, playedAt: 0,
  lost: false });
const context = () => {
  alarm.context ??= new AudioContext();
  if (alarm.context.state === "suspended") alarm.context.resume();
  return alarm.context;
};
const mark = () => {
  const ready = alarm.context?.state === "running";
  document.documentElement.dataset.fcwSound = alarm.muted ? "muted" : ready ? "on" : "waits";
  const late = alarm.captured === null || performance.now() - alarm.captured > QUIET_MS;
  return ready && !alarm.muted && !late;
};
const play = ({ tones, gain, shape }) => {
  const audio = context(), now = audio.currentTime;
  for (const [frequency, start, length] of tones) {
    const tone = audio.createOscillator(), volume = audio.createGain();
    tone.type = shape;
    tone.frequency.value = frequency;
    volume.gain.setValueAtTime(0, now + start);
    volume.gain.linearRampToValueAtTime(gain, now + start + 0.01); // without a click
    volume.gain.setValueAtTime(gain, now + start + length - 0.02);
    volume.gain.linearRampToValueAtTime(0, now + start + length);
    tone.connect(volume).connect(audio.destination);
    tone.start(now + start);
    tone.stop(now + start + length);
  }
};
const tick = () => {
  const sound = SOUNDS[alarm.level];
  if (!mark() || !sound || performance.now() - alarm.playedAt < sound.every_s * 1000) return;
  alarm.playedAt = performance.now();
  play(sound);
};
// The server tells the level with every picture, and when that was captured.
alarm.tell = (level, captured) => {
  if (level !== alarm.level) alarm.playedAt = 0; // a new level sounds at once
  alarm.level = level;
  alarm.captured = captured ?? performance.now();
  tick();
};
alarm.mute = (muted) => {
  alarm.muted = muted;
  mark();
};
// The drive has ended: silence is right now, once a loss was heard.
alarm.end = (lost) => {
  alarm.level = "none";
  alarm.captured = null;
  mark();
  if (lost && !alarm.lost && !alarm.muted && alarm.context?.state === "running") play(LOST);
  alarm.lost ||= lost;
};
if (!alarm.listens) {
  alarm.listens = true;
  for (const gesture of ["pointerdown", "keydown"])
    window.addEventListener(gesture, () => (context(), setTimeout(mark, 50)), { capture: true });
  setInterval(tick, 100);
}
mark();
