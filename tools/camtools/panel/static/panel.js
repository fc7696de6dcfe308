// SPDX-License-Identifier: Apache-2.0
// A page that is loaded anew continues the one before: with its command, and with its open question.
const PAGE = `camturn.page.${location.pathname}`;
let continues = JSON.parse(sessionStorage.getItem(PAGE) ?? "{}");
window.addEventListener("pagehide", () => {
  const asks = document.querySelector("[data-asks]")?.dataset.asks;
  sessionStorage.setItem(PAGE, JSON.stringify({ before: window.clientId, asks }));
});
// Whenever the page connects it sends its clock, by which late messages are recognised.
window.panelHello = () => {
  emitEvent("panel_hello", { sent_ms: performance.now(), ...continues });
  continues = {};
};
// STOP, on every page: caught on the way down, before an open menu or a field keeps it for itself.
const isStop = (event) => event.key === "Escape" && !event.repeat;
document.addEventListener("keydown", (e) => isStop(e) && emitEvent("stop", {}), true);
