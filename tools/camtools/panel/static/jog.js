// SPDX-License-Identifier: Apache-2.0
// A jog button moves an axis only while somebody holds it: begin, then hold ten times a second, then
// end, each with the number of the press. It needs the browser, since only that knows when a finger
// was lifted, a tab hidden or a window left. The server lets a press that was silent die.
(() => {
  let button = null, press = 0, beat = 0, isByPointer = false;
  const tell = (phase) =>
    emitEvent("jog", { phase, press, where: button.dataset.jog, sent_ms: performance.now() });
  const end = () => {
    if (!button) return;
    clearInterval(beat);
    tell("end");
    button.classList.remove("is-held");
    button = null;
  };
  const begin = (target, byPointer) => {
    const found = target.closest?.("[data-jog]");
    if (!found || found.disabled || button) return;
    button = found;
    isByPointer = byPointer;
    press += 1;
    button.classList.add("is-held");
    tell("begin");
    beat = setInterval(() => (button.isConnected && !button.disabled ? tell("hold") : end()), 100);
  };
  const isSpace = (event) => event.key === " " || event.key === "Enter";
  // On the way down (true), because the button itself stops keys on their way up.
  document.addEventListener("pointerdown", (e) => e.isPrimary && e.button === 0 && begin(e.target, true));
  document.addEventListener("keydown", (e) => isSpace(e) && !e.repeat && begin(e.target, false), true);
  document.addEventListener("keyup", (e) => isSpace(e) && end(), true);
  document.addEventListener("pointermove", (e) => {
    if (button && isByPointer && !button.contains(document.elementFromPoint(e.clientX, e.clientY))) end();
  });
  document.addEventListener("focusout", (e) => e.target === button && end());
  // A long press would open a menu, and with it end the press.
  document.addEventListener("contextmenu", (e) => button && e.preventDefault());
  for (const name of ["pointerup", "pointercancel"]) document.addEventListener(name, end);
  window.addEventListener("blur", end);
  window.addEventListener("pagehide", end);
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) end();
    emitEvent("seen", { is_seen: !document.hidden });
  });
})();
