"use strict";
// One rating session in a browser. What stands before its keepers is tested without one.
const study = "STUDY";

// What the page says, in the language that it was made in.
function word(name, values) {
  return study.words[name].replace(/\{(\w+)\}/g, (_, field) => values[field]);
}

function drawn(names) {
  const left = [...names];
  return names.map(() => left.splice(Math.floor(Math.random() * left.length), 1)[0]);
}

function fresh(rater) {
  return { rater, order: [...drawn(study.ratings), ...drawn(study.satisfaction)], records: [] };
}

// The answers that stand, oldest first.
function standing(records) {
  const told = [];
  for (const record of records) record.back ? told.pop() : told.push(record);
  return told;
}

function file(session) {
  const head = Object.assign({}, study.header, { rater: session.rater, order: session.order });
  return [head, ...session.records].map((line) => JSON.stringify(line) + "\n").join("");
}

// What keeps the sessions: the program that served the page, or this browser. `add` says how the session stands.
const program = {
  sessions: () => ask("sessions"),
  open: (rater) => ask("sessions/" + rater, {}),
  add: async (session, line) => {
    const further = await ask("sessions/" + session.rater + "/lines", line);
    return further.records ? further : Object.assign({}, session, { records: [...session.records, line] });
  },
};

async function ask(what, content) {
  const sent = content && { method: "POST", body: JSON.stringify(content) };
  let reply;
  try {
    reply = await fetch(what, sent);
  } catch (problem) {
    throw new Error(word("ended"));
  }
  const told = await reply.json();
  if (!reply.ok && told.problem) throw new Error(told.problem);
  return told;
}

const browser = {
  place: "kogao-ratings:" + study.study + ":",
  stored: (rater) => {
    try {
      return JSON.parse(localStorage.getItem(browser.place + rater));
    } catch (problem) {
      return null;
    }
  },
  sessions: async () => Object.keys(localStorage)
    .filter((key) => key.startsWith(browser.place))
    .sort()
    .map((key) => browser.stored(key.slice(browser.place.length)))
    .map(({ rater, order, records }) => ({ rater, done: standing(records).length, total: order.length })),
  open: async (rater) => browser.stored(rater) || fresh(rater),
  add: async (session, line) => {
    // Another tab may have gone on with the same session.
    const kept = browser.stored(session.rater);
    if (kept && kept.records.length > session.records.length) return kept;
    const next = Object.assign({}, session, { records: [...session.records, line] });
    try {
      localStorage.setItem(browser.place + session.rater, JSON.stringify(next));
    } catch (problem) {
      // It goes on without: the first page has said so, and the answers can be saved at any time.
    }
    return next;
  },
};

if (typeof document !== "undefined") begin();

function begin() {
  const part = (id) => document.getElementById(id);
  const keeper = study.served ? program : browser;
  // Few scales, CSS px a px, so that few conditions differ: a session has the largest that fits when it begins.
  const scales = [1, 3 / 4, 1 / 2, 1 / 3];
  let session = null;
  let scale = null;
  let shownAt = 0;
  // Time, ms, in which another tab or window was in front, since the picture was painted; from when on one is.
  let away = 0;
  let leftAt = null;
  let ready = false;
  let busy = false;
  let touched = false;

  const done = () => standing(session.records).length;

  function say(id, text) {
    part(id).textContent = text;
    part(id).hidden = !text;
  }

  function only(id) {
    for (const main of document.querySelectorAll("main")) main.hidden = main.id !== id;
  }

  async function welcome() {
    const pictures = study.ratings.length;
    for (const told of document.querySelectorAll(study.served ? ".alone" : ".served")) told.remove();
    part("task").textContent = word(pictures === 1 ? "task_one" : "task", { n: pictures });
    part("then").hidden = !study.satisfaction.length;
    const code = crypto.getRandomValues(new Uint8Array(4));
    part("rater").value = [...code].map((byte) => byte.toString(16).padStart(2, "0")).join("");
    only("start");
    try {
      const sessions = await keeper.sessions();
      if (!study.served) localStorage.setItem("kogao-study", "1");
      part("unfinished").hidden = !sessions.length;
      part("sessions").replaceChildren(...sessions.map(entry));
    } catch (problem) {
      say("warning", study.served ? problem.message
        : word("keeps_nothing"));
    }
  }

  function entry(begun) {
    const item = document.createElement("li");
    const button = document.createElement("button");
    button.textContent = begun.rater + ": " + word("place", begun);
    button.addEventListener("click", () => open(begun.rater));
    item.append(button);
    return item;
  }

  async function open(rater) {
    try {
      session = await keeper.open(rater);
    } catch (problem) {
      return say("warning", problem.message);
    }
    say("warning", "");
    const last = standing(session.records).pop();
    scale = last && last.shown ? Math.max(...last.shown) / Math.max(...study.box) : null;
    show();
  }

  function show() {
    const at = done();
    const total = session.order.length;
    say("trouble", "");
    part("progress").max = total;
    part("progress").value = at;
    part("place").textContent = word("place", { done: at, total });
    part("back").disabled = !at;
    if (at >= total) return finish();
    only("judge");
    const grading = at >= study.ratings.length;
    part("question").textContent = grading
      ? word("ask_satisfied")
      : word("ask_natural");
    part("answers").hidden = grading;
    part("grades").hidden = !grading;
    touched = false;
    part("grade").value = 50;
    part("shown").textContent = "–";
    part("enter").disabled = true;
    part("question").focus();
    draw(session.order[at]);
    if (at + 1 < total) new Image().src = session.order[at + 1];
  }

  function fits(scale) {
    const [width, height] = study.box;
    return scale * width <= part("stage").clientWidth && scale * height <= part("stage").clientHeight;
  }

  function draw(name) {
    const picture = part("picture");
    ready = false;
    picture.hidden = true;
    picture.onload = lay;
    picture.onerror = () => say("trouble", word("missing", { name }));
    picture.src = name;
  }

  // Shows the picture at the session's scale; its time begins after the frame that paints it.
  function lay() {
    const picture = part("picture");
    if (ready && fits(scale)) return;
    scale = scale || scales.find(fits) || scales[scales.length - 1];
    ready = false;
    picture.hidden = !fits(scale);
    if (picture.hidden) {
      return say("trouble", word("larger", { size: study.box.map((side) => Math.round(scale * side)).join(" × ") }));
    }
    say("trouble", "");
    picture.width = scale * picture.naturalWidth;
    picture.height = scale * picture.naturalHeight;
    requestAnimationFrame(() => requestAnimationFrame((now) => {
      shownAt = now;
      away = 0;
      leftAt = present() ? null : now;
      ready = !picture.hidden;
    }));
  }

  async function add(said) {
    if (busy) return;
    busy = true;
    const line = Object.assign({ n: session.records.length + 1 }, said);
    try {
      session = await keeper.add(session, line);
    } catch (problem) {
      return say("trouble", problem.message);
    } finally {
      busy = false;
    }
    show();
    if (session.records[session.records.length - 1] !== line) {
      say("trouble", word("elsewhere"));
    }
  }

  const present = () => document.visibilityState === "visible" && document.hasFocus();

  function attend() {
    const now = performance.now();
    if (leftAt !== null) away += now - leftAt;
    leftAt = present() ? null : now;
  }

  function answer(said) {
    if (!ready || part("judge").hidden) return;
    attend();
    const took = performance.now() - shownAt - away;
    // What is pressed sooner was meant for the picture before.
    if (took < study.least_ms) return;
    const box = part("picture").getBoundingClientRect();
    add(Object.assign({ picture: session.order[done()] }, said, {
      ms: Math.round(took),
      away: Math.round(away),
      shown: [Math.round(box.width), Math.round(box.height)],
      window: [innerWidth, innerHeight],
      ratio: devicePixelRatio,
      degrees: null,
      distance: null,
    }));
  }

  const grading = () => !part("grades").hidden;
  const judge = (said) => { if (!grading()) answer({ answer: said }); };
  const grade = () => { if (grading() && touched) answer({ grade: Number(part("grade").value) }); };
  const skip = () => { if (grading()) answer({ grade: null }); };

  function back() {
    const last = standing(session.records).pop();
    if (last) add({ picture: last.picture, back: true });
  }

  function save() {
    const link = document.createElement("a");
    link.download = "ratings-" + session.rater + ".jsonl";
    link.href = URL.createObjectURL(new Blob([file(session)], { type: "application/jsonl" }));
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  function finish() {
    only("end");
    part("said").textContent = word("said", { n: done(), rater: session.rater });
    if (part("hand")) part("hand").textContent = word("hand", { file: "ratings-" + session.rater + ".jsonl" });
    part("thanks").focus();
  }

  part("begin").addEventListener("submit", (event) => {
    event.preventDefault();
    open(part("rater").value);
  });
  part("grades").addEventListener("submit", (event) => {
    event.preventDefault();
    grade();
  });
  part("grade").addEventListener("input", () => {
    touched = true;
    part("shown").textContent = part("grade").value;
    part("enter").disabled = false;
  });
  part("natural").addEventListener("click", () => judge("natural"));
  part("unnatural").addEventListener("click", () => judge("unnatural"));
  part("skip").addEventListener("click", skip);
  part("back").addEventListener("click", back);
  part("again").addEventListener("click", back);
  for (const button of document.querySelectorAll(".save")) button.addEventListener("click", save);
  for (const change of ["focus", "blur"]) addEventListener(change, attend);
  document.addEventListener("visibilitychange", attend);
  addEventListener("resize", () => { if (session && !part("judge").hidden && part("picture").complete) lay(); });
  document.addEventListener("keydown", (event) => {
    if (!part("start").hidden || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    const keys = { f: () => judge("natural"), j: () => judge("unnatural"), s: skip, backspace: back };
    const does = keys[event.key.toLowerCase()];
    if (does) {
      event.preventDefault();
      does();
    } else if (event.key === "Enter" && event.target === part("grade")) {
      event.preventDefault();
      grade();
    }
  });
  welcome();
}
