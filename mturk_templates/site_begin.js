/* Who begins without a network is told so, in place of a page of the browser's own. */
(function () {
  "use strict";
  var say = document.querySelector("[role=status]");
  document.querySelector("form").addEventListener("submit", function (event) {
    if (navigator.onLine) return;
    event.preventDefault();
    say.textContent = "No connection at the moment. Please try again when there is one.";
  });
  window.addEventListener("online", function () { say.textContent = ""; });
})();
