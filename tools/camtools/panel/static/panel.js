// SPDX-License-Identifier: Apache-2.0
// The token comes in the fragment of the address, which no server and no log ever sees. It is kept
// for this tab alone, taken out of the address, and shown to the panel whenever the page connects;
// with it goes the page's clock, by which late messages are known.
const takeToken = () => {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return;
  sessionStorage.setItem("camturn.token", token);
  history.replaceState(null, "", location.pathname + location.search);
};
takeToken();
// A page that is loaded anew continues the one before: with its command, and with its open question.
const PAGE = `camturn.page.${location.pathname}`;
let continues = JSON.parse(sessionStorage.getItem(PAGE) ?? "{}");
window.addEventListener("pagehide", () => {
  const asks = document.querySelector("[data-asks]")?.dataset.asks;
  sessionStorage.setItem(PAGE, JSON.stringify({ before: window.clientId, asks }));
});
window.panelHello = () => {
  const token = sessionStorage.getItem("camturn.token");
  emitEvent("panel_hello", { token, sent_ms: performance.now(), ...continues });
  continues = {};
};
window.addEventListener("hashchange", () => {
  takeToken();
  window.panelHello();
});
// STOP, on every page: caught on the way down, before an open menu or a field keeps it for itself.
const isStop = (event) => event.key === "Escape" && !event.repeat;
document.addEventListener("keydown", (e) => isStop(e) && emitEvent("stop", {}), true);
