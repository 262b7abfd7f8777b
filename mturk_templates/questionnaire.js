/* One question at a time, keys, progress, and answers that survive a reload. Without scripts the page is one long form. */
(() => {
  "use strict";
  const root = document.getElementById("nc");
  const form = root.closest("form");
  const pages = [...root.querySelectorAll(".page")];
  const questions = pages.filter(page => page.classList.contains("q"));
  const back = root.querySelector(".back"), next = root.querySelector(".next"), size = root.querySelector(".size");
  const bar = root.querySelector("progress"), count = root.querySelector("output");
  const say = root.querySelector(".say"), seconds = root.querySelector("input[name=seconds]");
  /* Who comes next at this computer finds no answers of who was here before: the name is that of one participant's page. */
  const secret = document.querySelector("input[name=nc_secret]");
  const store = ["nc", root.dataset.questionnaire, secret ? secret.value : location.pathname + location.search].join("-");
  let spent = {}, at = 0, since = Date.now();

  const field = page => { const input = page.querySelector("input[type=radio]"); return input && input.name; };
  const answered = page => page.querySelector("input:checked");

  /* Time counts while the page is in view, for the question in view. */
  function tick() {
    const name = pages[at] && field(pages[at]);
    if (name) spent[name] = (spent[name] || 0) + Math.max(0, Date.now() - since) / 1000;
    since = Date.now();
    const rounded = {};
    for (const key in spent) rounded[key] = Math.round(spent[key] * 10) / 10;
    seconds.value = JSON.stringify(rounded);
  }

  function remember() {
    tick();
    const answers = {};
    for (const page of questions) { const input = answered(page); if (input) answers[input.name] = input.value; }
    try { localStorage.setItem(store, JSON.stringify({ answers, spent, at })); } catch (e) { /* private mode */ }
  }

  function recall() {
    let saved = null;
    try { saved = JSON.parse(localStorage.getItem(store)); } catch (e) { /* nothing usable */ }
    if (!saved || typeof saved !== "object") return 0;
    spent = saved.spent || {};
    for (const page of questions) for (const input of page.querySelectorAll("input")) {
      if ((saved.answers || {})[input.name] === input.value) input.checked = true;
    }
    return Math.min(Math.max(saved.at | 0, 0), pages.length - 1);
  }

  function progress() {
    const done = questions.filter(answered).length, page = pages[at];
    bar.value = done;
    count.textContent = done + " of " + questions.length;
    back.disabled = at === 0;
    next.hidden = at === pages.length - 1;
    next.disabled = Boolean(field(page) && !answered(page));
    next.textContent = at === 0 ? (done ? "Continue" : "Start") : "Next";
  }

  function show(where, focus) {
    tick();
    at = Math.min(Math.max(where, 0), pages.length - 1);
    pages.forEach((page, i) => page.classList.toggle("on", i === at));
    say.textContent = "";
    for (const page of pages.slice(at, at + 3)) for (const image of page.querySelectorAll("img")) image.loading = "eager";
    progress();
    remember();
    if (focus) {
      window.scrollTo(0, 0);
      const head = pages[at].querySelector("legend, h1, h2");
      head.tabIndex = -1;
      head.focus({ preventScroll: true });
    }
  }

  function choose(page, number) {
    const label = [...page.querySelectorAll("label")].find((one, i) => {
      const key = one.querySelector("b");
      return (key ? key.textContent : String(i + 1)) === number;
    });
    const input = label && label.querySelector("input");
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

  root.addEventListener("change", event => { if (event.target.type === "radio") changed(event.target); });
  back.addEventListener("click", () => show(at - 1, true));
  next.addEventListener("click", () => show(at + 1, true));
  size.addEventListener("click", () => size.setAttribute("aria-pressed", String(root.classList.toggle("large"))));
  document.addEventListener("visibilitychange", () => { if (document.hidden) remember(); else since = Date.now(); });
  window.addEventListener("pagehide", remember);

  document.addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(TEXTAREA|SELECT)$/.test(event.target.tagName)) return;
    const page = pages[at];
    if (/^[0-9]$/.test(event.key) && field(page)) { choose(page, event.key); event.preventDefault(); }
    else if (event.key === "ArrowRight" || (event.key === "Enter" && event.target.type === "radio")) {
      event.preventDefault();
      if (!next.hidden && !next.disabled) show(at + 1, true);
      else if (field(page)) say.textContent = "Please choose an answer first.";
    } else if (event.key === "ArrowLeft") { event.preventDefault(); if (at > 0) show(at - 1, true); }
  });

  if (form) {
    form.noValidate = true;
    form.addEventListener("submit", event => {
      remember();
      const open = questions.filter(page => !answered(page));
      if (!open.length) return;
      event.preventDefault();
      show(pages.indexOf(open[0]), true);
      say.textContent = "This question still needs an answer (" + open.length + " open).";
    });
  }

  root.classList.add("js");
  bar.max = questions.length;
  const start = recall();
  since = Date.now();
  show(start, false);
})();
