/* Sends each answer as it is given, and all of them at the end, again and again until the server has them. */
(function () {
  "use strict";
  var root = document.getElementById("nc"), say = root.querySelector(".say"), form = root.closest("form");
  var secret = document.querySelector("input[name=nc_secret]").value;
  var waiting = {}, busy = false, ending = false, pause = 1000, timer = 0;

  /* Stands wherever the participant goes, until it is taken back. */
  function tell(text) { root.dataset.note = text; say.textContent = text; }

  function away() {
    tell("No connection at the moment. Your answers are kept here and sent as soon as there is one.");
  }

  function lost() {
    away();
    timer = setTimeout(retry, pause);
    pause = Math.min(pause * 2, 30000);
  }

  function retry() {
    clearTimeout(timer);
    timer = 0;
    busy = false;
    next();
  }

  /* Refusals have pages of their own; what a proxy says while the server is away is no refusal. */
  function send(address, headers, body, done) {
    busy = true;
    fetch(address, { method: "POST", credentials: "same-origin", headers: headers, body: body }).then(function (reply) {
      if (reply.status === 429 || reply.status >= 500) throw new Error(String(reply.status));
      pause = 1000;
      if (root.dataset.note) tell("");
      done(reply);
    }).catch(lost);
  }

  function next() {
    var field = Object.keys(waiting)[0];
    if (busy) return;
    if (ending) { finish(); return; }
    if (!field) return;
    var sent = waiting[field];
    var headers = { "Content-Type": "application/json", "X-NC-Secret": secret };
    send("/answer", headers, JSON.stringify(sent), function (reply) {
      if (reply.status === 409 || reply.status === 403) { location.reload(); return; }
      if (!reply.ok) throw new Error(String(reply.status));
      if (waiting[field] === sent) delete waiting[field];
      retry();
    });
  }

  /* The form brings all answers along, so none need be sent on their own any more. */
  function finish() {
    tell("Sending your answers.");
    send("/finish", {}, new URLSearchParams(new FormData(form)), function (reply) {
      location.replace(reply.redirected ? reply.url : "/questions");
    });
  }

  form.addEventListener("submit", function (event) {
    if (event.defaultPrevented) return;
    event.preventDefault();
    if (ending) return;
    ending = true;
    next();
  });
  window.addEventListener("offline", away);
  window.addEventListener("online", function () {
    tell("");
    pause = 1000;
    if (timer) retry();
  });
  root.addEventListener("nc-answer", function (event) { waiting[event.detail.field] = event.detail; next(); });
  /* What was answered before a reload and hadn't reached the server then. */
  root.querySelectorAll("input[type=radio]:checked").forEach(function (input) {
    if (!input.defaultChecked) waiting[input.name] = { field: input.name, value: input.value, seconds: 0 };
  });
  next();
})();
