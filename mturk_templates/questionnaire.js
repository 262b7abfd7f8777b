/* One question at a time, keys, progress, and answers that survive a reload. Without scripts the page is one long form. */
(function () {
  "use strict";
  var root = document.getElementById("nc");
  var form = root.closest("form");
  var pages = Array.prototype.slice.call(root.querySelectorAll(".page"));
  var questions = pages.filter(function (page) { return page.classList.contains("q"); });
  var back = root.querySelector(".back"), next = root.querySelector(".next"), size = root.querySelector(".size");
  var bar = root.querySelector("progress"), count = root.querySelector("output");
  var say = root.querySelector(".say"), seconds = root.querySelector("input[name=seconds]");
  var store = "nc-" + root.getAttribute("data-questionnaire");
  var spent = {}, at = 0, since = Date.now();

  function field(page) { var input = page.querySelector("input[type=radio]"); return input && input.name; }
  function answered(page) { return page.querySelector("input:checked"); }

  /* Time counts while the page is in view, for the question in view. */
  function tick() {
    var name = pages[at] && field(pages[at]);
    if (name) spent[name] = (spent[name] || 0) + Math.max(0, Date.now() - since) / 1000;
    since = Date.now();
    var rounded = {};
    Object.keys(spent).forEach(function (key) { rounded[key] = Math.round(spent[key] * 10) / 10; });
    seconds.value = JSON.stringify(rounded);
  }

  function remember() {
    tick();
    var answers = {};
    questions.forEach(function (page) { var input = answered(page); if (input) answers[field(page)] = input.value; });
    try { localStorage.setItem(store, JSON.stringify({ answers: answers, spent: spent, at: at })); } catch (e) { /* private mode */ }
  }

  function recall() {
    var saved = null;
    try { saved = JSON.parse(localStorage.getItem(store)); } catch (e) { /* nothing usable */ }
    if (!saved || typeof saved !== "object") return 0;
    spent = saved.spent || {};
    questions.forEach(function (page) {
      page.querySelectorAll("input").forEach(function (input) {
        if ((saved.answers || {})[field(page)] === input.value) input.checked = true;
      });
    });
    return Math.min(Math.max(saved.at | 0, 0), pages.length - 1);
  }

  function fetchAhead() {
    pages.slice(at, at + 3).forEach(function (page) {
      page.querySelectorAll("img").forEach(function (image) { image.loading = "eager"; });
    });
  }

  function progress() {
    var done = questions.filter(answered).length;
    bar.value = done;
    count.textContent = done + " of " + questions.length;
    var page = pages[at], open = field(page) && !answered(page);
    back.disabled = at === 0;
    next.hidden = at === pages.length - 1;
    next.disabled = Boolean(open);
    next.textContent = at === 0 ? (done ? "Continue" : "Start") : "Next";
  }

  function show(where, focus) {
    tick();
    at = Math.min(Math.max(where, 0), pages.length - 1);
    pages.forEach(function (page, i) { page.classList.toggle("on", i === at); });
    say.textContent = "";
    fetchAhead();
    progress();
    remember();
    if (focus) {
      window.scrollTo(0, 0);
      var head = pages[at].querySelector("legend, h1, h2");
      head.tabIndex = -1;
      head.focus({ preventScroll: true });
    }
  }

  function choose(page, number) {
    var label = Array.prototype.filter.call(page.querySelectorAll("label"), function (one, i) {
      var key = one.querySelector("b");
      return (key ? key.textContent : String(i + 1)) === number;
    })[0];
    var input = label && label.querySelector("input");
    if (input) { input.checked = true; input.focus({ preventScroll: true }); changed(input); }
  }

  function changed(input) {
    say.textContent = "";
    progress();
    remember();
    root.dispatchEvent(new CustomEvent("nc-answer", {
      detail: { field: input.name, value: input.value, seconds: spent[input.name] || 0 }
    }));
  }

  root.addEventListener("change", function (event) { if (event.target.type === "radio") changed(event.target); });
  back.addEventListener("click", function () { show(at - 1, true); });
  next.addEventListener("click", function () { show(at + 1, true); });
  size.addEventListener("click", function () {
    size.setAttribute("aria-pressed", String(root.classList.toggle("large")));
  });
  document.addEventListener("visibilitychange", function () { if (document.hidden) remember(); else since = Date.now(); });
  window.addEventListener("pagehide", remember);

  document.addEventListener("keydown", function (event) {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(TEXTAREA|SELECT)$/.test(event.target.tagName)) return;
    var page = pages[at];
    if (/^[0-9]$/.test(event.key) && field(page)) { choose(page, event.key); event.preventDefault(); }
    else if (event.key === "ArrowRight" || (event.key === "Enter" && event.target.type === "radio")) {
      event.preventDefault();
      if (!next.hidden && !next.disabled) show(at + 1, true);
      else if (field(page)) say.textContent = "Please choose an answer first.";
    } else if (event.key === "ArrowLeft") { event.preventDefault(); if (at > 0) show(at - 1, true); }
  });

  if (form) {
    form.noValidate = true;
    form.addEventListener("submit", function (event) {
      remember();
      var open = questions.filter(function (page) { return !answered(page); });
      if (!open.length) return;
      event.preventDefault();
      show(pages.indexOf(open[0]), true);
      say.textContent = "This question still needs an answer (" + open.length + " open).";
    });
  }

  root.classList.add("js");
  bar.max = questions.length;
  var start = recall();
  since = Date.now();
  show(start, false);
})();
