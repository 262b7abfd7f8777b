/* Sends each answer as it is given, again and again until the server has it. */
(function () {
  "use strict";
  var root = document.getElementById("nc"), say = root.querySelector(".say");
  var secret = document.querySelector("input[name=nc_secret]").value;
  var waiting = {}, busy = false, pause = 1000;

  function next() {
    var field = Object.keys(waiting)[0];
    if (busy || !field) return;
    busy = true;
    var sent = waiting[field];
    fetch("/answer", {
      method: "POST", credentials: "same-origin",
      headers: { "Content-Type": "application/json", "X-NC-Secret": secret }, body: JSON.stringify(sent)
    }).then(function (reply) {
      if (reply.status === 409 || reply.status === 403) { location.reload(); return; }
      if (!reply.ok) throw new Error(String(reply.status));
      if (waiting[field] === sent) delete waiting[field];
      pause = 1000;
      busy = false;
      if (say.textContent.indexOf("connection") >= 0) say.textContent = "";
      next();
    }).catch(function () {
      say.textContent = "No connection at the moment. Your answers are kept here and sent as soon as there is one.";
      pause = Math.min(pause * 2, 30000);
      setTimeout(function () { busy = false; next(); }, pause);
    });
  }

  /* The form brings all answers along, so none need be sent on their own any more. */
  document.querySelector("form").addEventListener("submit", function (event) {
    if (!event.defaultPrevented) { waiting = {}; busy = true; }
  });
  root.addEventListener("nc-answer", function (event) { waiting[event.detail.field] = event.detail; next(); });
  /* What was answered before a reload and hadn't reached the server then. */
  root.querySelectorAll("input[type=radio]:checked").forEach(function (input) {
    if (!input.defaultChecked) waiting[input.name] = { field: input.name, value: input.value, seconds: 0 };
  });
  next();
})();
