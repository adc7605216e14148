"use strict";
const ask = async (method, path, options = {}) => {
  const answer = await fetch(path, { method, ...options });
  const value = await answer.json().catch(() => ({}));
  if (!answer.ok) {
    const said = typeof value.detail === "string" ? value.detail : `refused (${answer.status})`;
    throw Object.assign(new Error(said), { status: answer.status });
  }
  return value;
};
const form = (id, act) => {
  const element = document.getElementById(id);
  if (!element) return;
  element.addEventListener("submit", async (event) => {
    event.preventDefault();
    const [button, line] = [element.querySelector("button"), element.querySelector(".answer")];
    button.disabled = true;
    line.textContent = "…";
    try { await act(element.elements); } catch (error) { line.textContent = error.message; button.disabled = false; }
  });
};
form("log-in", async ({ token }) => {
  const headers = { "Content-Type": "application/json" };
  await ask("POST", "/api/session", { headers, body: JSON.stringify({ token: token.value.trim() }) });
  location.reload();
});
form("upload", async ({ file, kind }) => {
  const [chosen] = file.files;
  const query = new URLSearchParams({ name: chosen.name, kind: kind.value });
  const headers = { "Content-Type": "application/octet-stream" };
  const { page } = await ask("POST", `/api/submissions?${query}`, { headers, body: chosen });
  location.assign(page);
});
document.getElementById("log-out")?.addEventListener("click", async () => {
  await ask("DELETE", "/api/session");
  location.assign("/");
});
const live = document.getElementById("live");
const watch = async () => {
  const now = await ask("GET", `/api/submissions/${live.dataset.number}?runs=false`).catch((error) => error);
  if (now.status === 410) return location.reload();
  if (!(now instanceof Error)) {
    live.querySelector("progress").value = now.done;
    live.querySelector(".count").textContent = `${now.done} of ${now.total} runs`;
    const state = live.querySelector(".state");
    state.textContent = now.state;
    state.className = `state ${now.state}`;
    if (now.state === "done" || now.put_off !== Number(live.dataset.putOff)) return location.reload();
  }
  setTimeout(watch, 1500);
};
if (live && live.dataset.state !== "done") watch();
