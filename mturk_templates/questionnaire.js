/* One question at a time, keys, progress, and answers that survive a reload. Without scripts the page is one long form. */
(() => {
  "use strict";
  const LOADING = "Please wait: pictures are still loading.";
  const MISSING = "Some pictures didn’t come: see below.";
  const root = document.getElementById("nc");
  const form = root.closest("form");
  const pages = [...root.querySelectorAll(".page")];
  const questions = pages.filter(page => page.matches("fieldset"));
  const back = root.querySelector(".back"), next = root.querySelector(".next"), size = root.querySelector(".size");
  const bar = root.querySelector("progress"), count = root.querySelector("output");
  const say = root.querySelector(".say"), keys = root.querySelector(".digits");
  const seconds = root.querySelector("input[name=seconds]"), lost = root.querySelector("input[name=pictures]");
  /* Who comes next at this computer finds no answers of who was here before: the name is that of one participant's page. */
  const secret = document.querySelector("input[name=nc_secret]");
  const store = ["nc", root.dataset.questionnaire, secret ? secret.value : location.pathname + location.search].join("-");
  let spent = {}, missed = {}, at = 0, since = Date.now(), digits = true, held = false;
  /* Pictures that are there, that are being fetched, and that failed when last fetched. */
  const good = new Set(), busy = new Set(), broken = new Set();

  const field = page => { const input = page.querySelector("input[type=radio]"); return input && input.name; };
  const answered = page => page.querySelector("input:checked");
  const pictures = page => [...page.querySelectorAll("img")];
  const blind = page => !pictures(page).every(image => good.has(image));
  const wait = seconds => new Promise(done => setTimeout(done, 1000 * seconds));
  /* What is said to the participant; with nothing to say, what the site's own script wants said. */
  const tell = text => { say.textContent = text || root.dataset.note || ""; };

  /* Fetches a picture, again if it doesn't come: after 1, 2 and 4 seconds. */
  async function load(image, page) {
    if (busy.has(image) || good.has(image)) return;
    busy.add(image);
    image.loading = "eager";
    for (let pause = 1; pause < 16; pause *= 2) {
      if (broken.has(image)) image.src = image.src;
      try {
        await Promise.race([image.decode(), wait(30 * pause).then(() => { throw 0; })]);
        tick();
        good.add(image);
        broken.delete(image);
        break;
      } catch (e) {
        broken.add(image);
        missed[field(page)] = (missed[field(page)] || 0) + 1;
        if (pause < 8) await wait(pause);
      }
    }
    busy.delete(image);
    if (good.has(image)) ahead();
    gate();
  }

  /* The question in view first, then the next two; a picture that was given up is fetched again when asked for. */
  function ahead(again) {
    for (const page of pages.slice(at, at + 3)) {
      for (const image of pictures(page)) if (again || !broken.has(image)) load(image, page);
      if (blind(page)) break;
    }
  }

  /* Nobody chooses before all pictures are there. Who can't get them says so, and goes on without a vote. */
  function gate() {
    const page = pages[at], shut = blind(page), miss = page.querySelector(".miss");
    page.classList.toggle("shut", shut);
    const gone = pictures(page).some(image => broken.has(image) && !busy.has(image));
    if (!shut && miss) miss.remove();
    if (gone && !miss) {
      page.insertAdjacentHTML("beforeend", '<div class=miss><button type=button>Try again</button><label><input value=unseen type=radio>I can’t see all pictures: go on without an answer</label></div>');
      page.querySelector(".miss input").name = field(page);
    }
    for (const input of page.querySelectorAll("input")) input.disabled = shut && !input.checked && input.value !== "unseen";
    if (gone) tell(MISSING);
    else if (!shut && [LOADING, MISSING].includes(say.textContent)) tell();
    progress();
  }

  /* Time counts while the page is in view, for the question in view, once its pictures are there. */
  function tick() {
    const name = pages[at] && field(pages[at]);
    if (name && !blind(pages[at])) spent[name] = (spent[name] || 0) + Math.max(0, Date.now() - since) / 1000;
    since = Date.now();
    const rounded = {};
    for (const key in spent) rounded[key] = +spent[key].toFixed(1);
    seconds.value = JSON.stringify(rounded);
    lost.value = Object.keys(missed).length ? JSON.stringify(missed) : "";
  }

  function remember() {
    tick();
    const answers = {};
    for (const page of questions) { const input = answered(page); if (input) answers[input.name] = input.value; }
    try { localStorage.setItem(store, JSON.stringify({ answers, spent, missed, at })); } catch (e) { /* private mode */ }
  }

  function recall() {
    let saved = null;
    try { saved = JSON.parse(localStorage.getItem(store)); } catch (e) {}
    if (!saved || typeof saved !== "object") return 0;
    spent = saved.spent || {};
    missed = saved.missed || {};
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
    const page = pages[at];
    held = false;
    pages.forEach(one => one.classList.toggle("on", one === page));
    tell();
    ahead(true);
    gate();
    wait(1).then(() => page === pages[at] && blind(page) && tell(LOADING));
    remember();
    if (focus) {
      scrollTo(0, 0);
      const head = page.querySelector("legend, h1, h2");
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
    if (input && !input.disabled) { input.checked = true; input.focus({ preventScroll: true }); changed(input); }
  }

  function changed(input) {
    tell();
    gate();
    remember();
    root.dispatchEvent(new CustomEvent("nc-answer", {
      detail: { field: input.name, value: input.value, seconds: spent[input.name] || 0 }
    }));
  }

  root.addEventListener("change", event => { if (event.target.type === "radio") changed(event.target); });
  back.addEventListener("click", () => show(at - 1, true));
  next.addEventListener("click", () => show(at + 1, true));
  root.addEventListener("click", event => { if (event.target.closest(".miss button")) { tell(LOADING); ahead(true); } });
  addEventListener("online", () => { ahead(true); if (held) form.requestSubmit(); });
  size.addEventListener("click", () => size.setAttribute("aria-pressed", String(root.classList.toggle("large"))));
  addEventListener("visibilitychange", () => { if (document.hidden) remember(); else since = Date.now(); });
  addEventListener("pagehide", remember);

  /* Whoever speaks to the computer, or hits keys by chance, can do without the digits. */
  function setDigits(on) {
    digits = on;
    keys.textContent = "Number keys: " + (on ? "on" : "off");
    try { localStorage.setItem("nc-digits", on ? "on" : "off"); } catch (e) {}
  }
  keys.addEventListener("click", () => setDigits(!digits));

  /* Arrows are left to the browser: they move the choice within the question, as in any group of radio buttons. */
  addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(TEXTAREA|SELECT)$/.test(event.target.tagName)) return;
    const page = pages[at];
    if (!field(page)) return;
    if (/^[0-9]$/.test(event.key) && digits) { choose(page, event.key); event.preventDefault(); }
    else if (event.key === "Enter" && !event.target.closest("button, a")) {
      event.preventDefault();
      if (next.disabled) tell(blind(page) ? LOADING : "Please choose an answer first.");
      else show(at + 1, true);
    }
  });

  if (form) {
    form.noValidate = true;
    form.addEventListener("submit", event => {
      remember();
      for (const input of root.querySelectorAll("input")) input.disabled = false;
      const open = questions.filter(page => !answered(page));
      if (open.length) {
        event.preventDefault();
        show(pages.indexOf(open[0]), true);
        tell("This question still needs an answer (" + open.length + " open).");
      } else if (!secret && !navigator.onLine) {
        event.preventDefault();
        held = true;
        tell("No connection. Answers are kept, and sent later.");
      }
    });
  }

  root.classList.add("js");
  bar.max = questions.length;
  try { setDigits(localStorage.getItem("nc-digits") !== "off"); } catch (e) { setDigits(true); }
  const start = recall();
  since = Date.now();
  show(start, false);
})();
